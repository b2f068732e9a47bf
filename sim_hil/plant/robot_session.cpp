#include "sim_hil/plant/robot_session.hpp"

#include <algorithm>
#include <limits>

namespace sinew::plant {
namespace {

using hal::Status;
using hal::Time;

constexpr std::int64_t kExposureNs = 8'000'000;
constexpr std::int64_t kReportEveryNs = 100'000'000;  // the last report before the end has the final place

hal::Duration ns(std::int64_t n) { return hal::Duration{n}; }

sim_hil::DeviceKind kind_of(Part part) {
  switch (part) {
    case Part::imu:
      return sim_hil::DeviceKind::imu;
    case Part::range:
      return sim_hil::DeviceKind::range;
    case Part::baro:
      return sim_hil::DeviceKind::baro;
    case Part::camera:
      return sim_hil::DeviceKind::camera;
    case Part::actuators:
      return sim_hil::DeviceKind::actuators;
    case Part::battery:
      return sim_hil::DeviceKind::battery;
    case Part::soles:
      return sim_hil::DeviceKind::soles;
    case Part::referee:
      return sim_hil::DeviceKind::referee;
    case Part::joints:
      break;
  }
  return sim_hil::DeviceKind::joints;
}

/// The delay of a part that the world has.
hal::Duration delay_of(const WorldInfo& world, Part part) { return ns(world.find(part)->delay_ns); }

std::vector<Fault> faults_of(const std::vector<Fault>& all, std::size_t robot) {
  std::vector<Fault> own;
  std::ranges::copy_if(all, std::back_inserter(own), [&](const Fault& f) { return f.robot == robot; });
  return own;
}

}  // namespace

RobotSession::RobotSession(hal::Os& os, std::span<CameraFeed* const> cameras, const SessionOptions& options,
                           const PhysicsReport& physics, std::size_t number)
    : os_(os),
      view_(cameras[0]->options()),
      options_(options),
      physics_(physics),
      number_(number),
      info_(options.world.info_of(number)) {
  report_.world_name = info_.name;
  if (!options.world.robots.empty()) report_.robot_name = options.world.robots[number].name;
  for (std::uint16_t id = 0; id < info_.devices.size(); ++id) {
    const WorldDevice& device = info_.devices[id];
    ids_[static_cast<std::size_t>(device.part)] = id;
    const std::size_t n = cameras_.size();
    if (device.part == Part::camera) cameras_.push_back({cameras[n], id, device.delay_ns, n});
    if (device.part == Part::actuators) groups_.push_back({id, device.channels});
    if (device.part == Part::joints) joints_.push_back({id, device.delay_ns});
  }
}

sim_hil::PlantDescription RobotSession::description(const CameraOptions& view, const SessionOptions& options,
                                                    std::size_t robot) {
  sim_hil::PlantDescription d;
  d.name = "sinew-sim";
  d.step = ns(kStepNs);
  d.seed = options.seed;
  for (const WorldDevice& part : options.world.info_of(robot).devices) {
    sim_hil::DeviceInfo& info = d.devices.emplace_back();
    info.kind = kind_of(part.part);
    info.name = part.name;
    info.period = ns(part.steps * kStepNs);
    info.latency = ns(part.delay_ns);
    info.channels = part.channels;
    if (part.part != Part::camera) continue;
    if (part.steps == 0) info.period = ns(1'000'000'000 / kCameraHz);
    info.width = view.width;
    info.height = view.height;
    info.format = view.format;
  }
  if (options.world.type->info.has_radio()) {
    sim_hil::DeviceInfo& info = d.devices.emplace_back();
    info.kind = sim_hil::DeviceKind::radio;
    info.name = kRadioName;
  }
  return d;
}

// ---- before the run

Status RobotSession::open(sim_hil::Caller caller, sim_hil::PlantListener* listener) {
  listener_ = listener;
  const sim_hil::PlantDescription plant = description(view_, options_, number_);
  if (caller.stream->local()) {
    auto memory = os_.shared_memory("sinew_sim_frames", sim_hil::PlantLink::frame_memory_bytes(plant));
    if (memory) frames_ = std::move(*memory);  // without it frames go through the stream
  }
  auto link = sim_hil::PlantLink::accept(std::move(caller), plant, frames_.get(), report_.reason);
  if (!link) return link.error();
  link_ = std::move(*link);
  report_.mode = hello().mode;
  if (!options_.only || *options_.only == report_.mode) return {};
  return refuse(report_.mode == sim_hil::Mode::lockstep ? "this plant was started for free-running only"
                                                        : "this plant was started for lockstep only",
                {hal::Errc::not_supported, "plant session"});
}

Status RobotSession::refuse(std::string why, hal::Error error) {
  report_.reason = std::move(why);
  report_.started = false;
  if (link_) link_->bye(report_.reason);
  keep(error);
  return error;
}

void RobotSession::enter(World& world, std::uint64_t seed) {
  world_ = &world;
  robot_ = &world.robot(number_);
  report_.seed = seed;
  const std::uint64_t own_seed = seed_of_robot(seed, number_);
  for (const Camera& camera : cameras_) camera.feed->set_seed(own_seed + camera.number);
  if (report_.mode == sim_hil::Mode::lockstep) link_->set_robot_clock(clock(own_seed));
  faults_ = std::make_unique<PlantFaults>(faults_of(options_.faults, number_), own_seed, view_, info_);
}

/// The clocks of several robots differ, as those of real ones do.
sim_hil::RobotClock RobotSession::clock(std::uint64_t own_seed) const {
  constexpr std::uint32_t kStream = 0x636c636b;
  constexpr double kMostOffset_s = 60, kMostDrift_ppm = 50;
  math::Random random(own_seed, kStream);
  const bool alone = options_.world.robot_count() == 1;
  const double offset_s = alone ? 0 : random.uniform(0, kMostOffset_s);
  const double drift_ppm = alone ? 0 : random.uniform(-kMostDrift_ppm, kMostDrift_ppm);
  const WorldValues values = options_.world.values_of(number_);
  const double wanted_s = info_.value(values, "clock_offset_s").value_or(offset_s);
  const double wanted_ppm = info_.value(values, "clock_drift_ppm").value_or(drift_ppm);
  return {ns(static_cast<std::int64_t>(1e9 * wanted_s)), static_cast<std::int64_t>(1e3 * wanted_ppm)};
}

Status RobotSession::wait_start() {
  keep(link_->wait_start());
  report_.started = !gone();
  return status_;
}

// ---- lockstep

void RobotSession::begin_grant(Time until) {
  if (!gone()) keep(link_->begin_grant(until));
}

void RobotSession::wait_done() {
  if (!gone()) keep(link_->wait_done());
}

// ---- free-running

void RobotSession::start_clock(Time now, Time host_now) {
  host_zero_ = host_now;
  keep(link_->start_clock(now, host_now));
}

void RobotSession::hear() {
  if (gone()) return;
  if (relink_) keep(welcome_another());
  if (!gone()) keep(link_->exchange());
}

void RobotSession::tell() {
  if (!gone()) keep(link_->exchange());
  if (gone() && link_) status_ = go_on_without_runtime(status_);
}

/// Ok: the runtime is gone without a Bye, and the world waits for another.
Status RobotSession::go_on_without_runtime(Status lost) {
  const bool breach = lost.error().code == hal::Errc::bad_data;
  const bool waiting = relink_ && relink_->looking();
  if (!listener_ || options_.relink_s <= 0 || breach || waiting || link_->ended_politely()) return lost;
  if (!relink_)
    relink_ =
        std::make_unique<Relink>(os_, *listener_, number_, description(view_, options_), frames_.get(), hello().rate);
  if (!relink_->look(hal::Duration{static_cast<std::int64_t>(options_.relink_s * 1e9)})) return lost;
  link_->go_alone();
  return {};
}

Status RobotSession::welcome_another() {
  if (!relink_->looking()) return {};
  if (relink_->in_vain()) return hal::Error{hal::Errc::closed, "no other runtime has come"};
  if (drawing()) return {};  // into the old link's memory
  auto link = relink_->take();
  if (!link) return {};
  ++report_.relinks;
  expired_before_ += link_->stats().lease_expiries;
  for (Camera& camera : cameras_) camera.pending.reset();
  link_ = std::move(link);
  if (report_.stopped_by_supervisor) link_->stop_for_good();
  const auto since_start = static_cast<std::int64_t>(static_cast<double>(world_->now().ns) / hello().rate);
  return link_->start_clock(world_->now(), Time{host_zero_.ns + since_start});
}

// ---- both

/// A stop holds until the end of the run.
void RobotSession::heed_stop_line() {
  if (!listener_ || !link_ || report_.stopped_by_supervisor || !listener_->stopped(number_)) return;
  link_->stop_for_good();
  report_.stopped_by_supervisor = true;
  report_.stopped_at = world_->now();
}

void RobotSession::close_by_fault() {
  if (!link_ || !faults_->line_closes_by(world_->now())) return;
  wait_for_drawing();
  refresh_report();
  link_.reset();  // without a good-bye
  keep(hal::Error{hal::Errc::closed, "a fault closed the connection"});
}

void RobotSession::hear_air(Air& air, Time until) {
  while (const msg::Datagram* heard = air.receive(number_, until))
    if (!gone()) keep(faults_->radio.hears(*heard, radio_sender()));
  if (!gone()) keep(faults_->radio.release(until, radio_sender()));
  report_.radio = air.counts(number_);
}

void RobotSession::collect_said(std::vector<Said>& all) {
  if (!link_) return;
  for (const sim_hil::PlantLink::Sent& sent : link_->sent())
    if (faults_->radio.says(sent.commit)) all.push_back({sent.commit, number_, sent.datagram.bytes()});
  link_->forget_sent();
}

RobotCommand RobotSession::act() {
  const Time now = world_->now();
  bool any = false;
  std::size_t channels = 0;
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    Group& group = groups_[i];
    if (link_) group.commanded = link_->setpoints_at(group.id, now);
    const sim_hil::Setpoints acting = faults_->actuators[i].act(group.commanded, now);
    const bool acts = acting.valid && !report_.stopped_by_supervisor;  // the stop line passes by all faults
    for (std::uint32_t c = 0; c < group.channels; ++c)
      acting_[channels++] = acts ? acting.value[c] : std::numeric_limits<double>::quiet_NaN();
    if (!acts) continue;
    any = true;
    if (now - acting.commit >= acting.lease) ++report_.stale_actuations;
    report_.setpoint_age_max_ns = std::max(report_.setpoint_age_max_ns, (now - acting.stamp).count());
  }
  return any ? RobotCommand(acting_.data(), channels) : RobotCommand();
}

void RobotSession::send_due() {
  const Due& due = robot_->due();
  if (!gone()) keep(send_samples(due));
  for (Camera& camera : cameras_)
    if (!gone() && (due.cameras >> camera.number & 1) != 0) keep(begin_frame(camera));
  if (!gone() && due.truth) keep(send_truth_and_report());
}

Status RobotSession::send_samples(const Due& due) {
  // Not before now: a world may give samples that are old already.
  const auto ready = [now = world_->now()](Time stamp, hal::Duration delay) { return std::max(stamp + delay, now); };
  const auto pass = [&](auto& faults, Part part, const auto& sample) {
    return faults.offer(sample, ready(sample.stamp, delay_of(info_, part)), sender(id(part)));
  };
  Status s;
  if (due.imu) s = pass(faults_->imu, Part::imu, due.imu_sample);
  if (s && due.range) s = pass(faults_->range, Part::range, due.range_sample);
  if (s && due.baro) s = pass(faults_->baro, Part::baro, due.baro_sample);
  if (s && due.battery) s = pass(faults_->battery, Part::battery, due.battery_sample);
  if (s && due.soles) s = pass(faults_->soles, Part::soles, due.soles_sample);
  if (s && due.referee) s = pass(faults_->referee, Part::referee, due.referee_sample);
  for (std::size_t i = 0; i < joints_.size() && due.joints && s; ++i) {
    const msg::JointState& sample = due.joints_samples[i];
    s = faults_->joints[i].offer(sample, ready(sample.stamp, ns(joints_[i].delay_ns)), sender(joints_[i].id));
  }
  return s;
}

void RobotSession::send_ready(Time until, bool wait) {
  for (Camera& camera : cameras_)
    if (!gone()) keep(send_frame_due_by(camera, until, wait));
  if (!gone()) keep(release_held(until));
}

/// Sends the samples and frames that were held back and are ready by then.
Status RobotSession::release_held(Time until) {
  Status s = faults_->imu.release(until, sender(id(Part::imu)));
  if (s) s = faults_->range.release(until, sender(id(Part::range)));
  if (s) s = faults_->baro.release(until, sender(id(Part::baro)));
  if (s) s = faults_->battery.release(until, sender(id(Part::battery)));
  if (s) s = faults_->soles.release(until, sender(id(Part::soles)));
  if (s) s = faults_->referee.release(until, sender(id(Part::referee)));
  for (std::size_t i = 0; i < joints_.size() && s; ++i) s = faults_->joints[i].release(until, sender(joints_[i].id));
  for (const Camera& camera : cameras_)
    if (s)
      s = faults_->frames[camera.number].release(
          until, [&](auto pixels, const auto& meta) { return copy_frame(camera, pixels, meta); });
  return s;
}

bool RobotSession::drawing() const {
  return std::ranges::any_of(cameras_, [](const Camera& camera) { return camera.feed->busy(); });
}

void RobotSession::wait_for_drawing() {
  for (const Camera& camera : cameras_)
    if (camera.feed->busy()) camera.feed->wait();
}

Status RobotSession::begin_frame(Camera& camera) {
  ++camera.frames;
  if (camera.pending) {  // free-running only: drawing takes longer than a frame's period
    ++report_.render_late;
    return {};
  }
  FrameFaults& faults = faults_->frames[camera.number];
  PendingFrame frame;
  if (!faults.any()) frame.slot = link_->begin_frame(camera.id);
  frame.meta.stamp = world_->now();
  frame.meta.ready = frame.meta.stamp + ns(camera.delay_ns);
  frame.meta.exposure_ns = kExposureNs;
  frame.meta.number = camera.frames;
  const auto pixels = faults.any() ? faults.canvas() : frame.slot.pixels;
  const Scene scene = robot_->scene(camera.number);
  if (options_.scenes) options_.scenes->picture(number_, camera.number, camera.frames, frame.meta.stamp, scene);
  camera.feed->request(scene, camera.frames, pixels.data());
  camera.pending = frame;
  return {};
}

Status RobotSession::send_frame_due_by(Camera& camera, Time until, bool wait) {
  if (!camera.pending || camera.pending->meta.ready > until) return {};
  if (wait) camera.feed->wait();
  if (camera.feed->busy()) return {};
  if (!wait && until - camera.pending->meta.ready > kExchange) {
    ++report_.render_late;
    camera.pending->meta.ready = until;
  }
  ++report_.frames;
  const PendingFrame frame = *camera.pending;
  camera.pending.reset();
  FrameFaults& faults = faults_->frames[camera.number];
  if (!faults.any()) return send_frame(camera, frame.slot, frame.meta);
  return faults.offer(frame.meta, [&](auto pixels, const auto& meta) { return copy_frame(camera, pixels, meta); });
}

Status RobotSession::send_frame(const Camera& camera, const sim_hil::FrameSlot& slot, const sim_hil::FrameMeta& meta) {
  WireCamera* const wire = options_.wire && camera.number == 0 ? options_.wire->camera() : nullptr;
  if (wire) {
    std::copy(slot.pixels.begin(), slot.pixels.end(), wire->canvas().begin());
    wire->deliver(host_zero_ + (meta.stamp - Time{0}) + options_.wire->stamps_late(), meta.number);
  }
  return link_->send_frame(camera.id, slot, meta);
}

Status RobotSession::copy_frame(const Camera& camera, std::span<const std::uint8_t> pixels,
                                const sim_hil::FrameMeta& meta) {
  const sim_hil::FrameSlot slot = link_->begin_frame(camera.id);
  std::copy(pixels.begin(), pixels.end(), slot.pixels.begin());
  return send_frame(camera, slot, meta);
}

Status RobotSession::send_truth_and_report() {
  const WorldTruth t = robot_->ground_truth();
  const Time now = world_->now();
  sim_hil::Truth out;
  out.p_world_m = t.p_world_m;
  out.v_world_mps = t.v_world_mps;
  out.q_world_base = t.q_world_base;
  out.gyro_radps = t.gyro_radps;
  out.pad_world_m = t.target_world_m;
  out.battery_v = t.battery_v;
  out.contact = t.contact;
  out.landed = t.landed;
  if (Status s = link_->send_truth(now, out); !s) return s;
  const bool news = robot_->news() != told_news_;
  if (!news && now.ns % kReportEveryNs != 0) return {};
  told_news_ = robot_->news();
  refresh_report();
  return link_->send_report(now, report_.text);
}

// ---- the report

void RobotSession::refresh_report() {
  static_cast<PhysicsReport&>(report_) = physics_;
  report_.plant_s = msg::seconds(world_->now());
  report_.still = robot_->still();
  report_.outcome = robot_->outcome();
  report_.faults.clear();
  for (const FaultLog::Entry& e : faults_->log.entries())
    if (e.fault.from_ns <= world_->now().ns) report_.faults.push_back(e);
  if (options_.wire)
    for (const FaultLog::Entry& e : options_.wire->faults())
      if (e.fault.from_ns <= world_->now().ns) report_.faults.push_back(e);
  if (link_) report_.lease_expiries = expired_before_ + link_->stats().lease_expiries;
  report_.text = report_.json(*robot_);
}

void RobotSession::finish() {
  wait_for_drawing();  // its pixels go to memory of this session
  refresh_report();
  if (!link_) {
    report_.reason = "a fault closed the connection";
  } else if (!gone()) {
    report_.reason = "duration is over";
    static_cast<void>(link_->send_report(world_->now(), report_.text));  // the run is over; the runtime may be gone
    link_->bye(report_.reason);
  } else {
    report_.reason = link_->reason();
    if (relink_ && relink_->in_vain()) report_.reason += "; no other runtime has come";
    report_.broken = !link_->ended_politely();
  }
}

}  // namespace sinew::plant
