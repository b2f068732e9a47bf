#include "sim_hil/plant/session.hpp"

#include <algorithm>
#include <cstdio>

namespace sinew::plant {
namespace {

using hal::Status;
using hal::Time;

constexpr std::int64_t kMsNs = 1'000'000;
constexpr std::int64_t kExposureNs = 8'000'000;
constexpr std::int64_t kAloneNs = 10'000'000'000;     // so long the plant steps a world that was cut off
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
    case Part::joints:
      break;
  }
  return sim_hil::DeviceKind::joints;
}

/// The delay of a part, which the world may lack.
std::int64_t delay_of(const WorldInfo& world, Part part) {
  const WorldDevice* device = world.find(part);
  return device ? device->delay_ns : 0;
}

}  // namespace

Session::Session(hal::Os& os, CameraFeed& camera_feed, const SessionOptions& options)
    : os_(os), feed_(camera_feed), options_(options) {}

sim_hil::PlantDescription Session::description(const CameraOptions& view, const SessionOptions& options) {
  sim_hil::PlantDescription d;
  d.name = "sinew-sim";
  d.step = ns(kStepNs);
  d.seed = options.seed;
  for (const WorldDevice& part : options.world.type->info.devices) {
    sim_hil::DeviceInfo& info = d.devices.emplace_back();
    info.kind = kind_of(part.part);
    info.name = part.name;
    info.period = ns(part.steps * kStepNs);
    info.latency = ns(part.delay_ns);
    info.channels = part.channels;
    if (part.part != Part::camera) continue;
    info.period = ns(1'000'000'000 / kCameraHz);
    info.width = view.width;
    info.height = view.height;
    info.format = view.format;
  }
  return d;
}

Status Session::open(sim_hil::Caller caller) {
  const sim_hil::PlantDescription plant = description(feed_.options(), options_);
  if (caller.stream->local()) {
    auto memory = os_.shared_memory("sinew_sim_frames", sim_hil::PlantLink::frame_memory_bytes(plant));
    if (memory) frames_ = std::move(*memory);  // without it frames go through the stream
  }
  auto link = sim_hil::PlantLink::accept(std::move(caller), plant, frames_.get(), report_.reason);
  if (!link) return link.error();
  link_ = std::move(*link);
  report_.mode = link_->hello().mode;
  if (options_.only && *options_.only != report_.mode) {
    report_.reason = report_.mode == sim_hil::Mode::lockstep ? "this plant was started for free-running only"
                                                             : "this plant was started for lockstep only";
    link_->bye(report_.reason);
    return hal::Error{hal::Errc::not_supported, "plant session"};
  }
  report_.seed = options_.seed.value_or(link_->hello().seed);
  info_ = options_.world.type->info;
  report_.world_name = info_.name;
  for (std::size_t i = 0; i < info_.devices.size(); ++i)
    ids_[static_cast<std::size_t>(info_.devices[i].part)] = static_cast<std::uint16_t>(i);
  auto made = options_.world.type->create(options_.world.values, report_.seed);
  if (!made) {
    report_.reason = "the world could not be made";
    link_->bye(report_.reason);
    return made.error();
  }
  world_ = std::move(*made);
  if (options_.wire) {
    if (report_.mode == sim_hil::Mode::lockstep) report_.reason = "devices at the wire are in real time only";
    if (Status s = options_.wire->attach(*world_); !s) report_.reason = s.error().where;
    if (!report_.reason.empty()) {
      link_->bye(report_.reason);
      return hal::Error{hal::Errc::not_supported, "devices at the wire"};
    }
  }
  feed_.set_seed(report_.seed);
  faults_ = std::make_unique<PlantFaults>(options_.faults, report_.seed, feed_.options(), info_);
  return {};
}

Status Session::serve(std::unique_ptr<hal::Stream> stream) {
  sim_hil::Caller caller;
  caller.stream = std::move(stream);
  if (Status s = hear_hello(caller, "sinew-sim", report_.reason); !s) {
    report_.broken = true;
    return s;
  }
  return serve(std::move(caller));
}

Status Session::serve(sim_hil::Caller caller, sim_hil::PlantListener& plant_listener) {
  plant_listener_ = &plant_listener;
  return serve(std::move(caller));
}

Status Session::serve(sim_hil::Caller caller) {
  if (Status s = open(std::move(caller)); !s) {
    report_.broken = true;
    return s;
  }
  if (report_.mode == sim_hil::Mode::free_running) rehearse();
  const Time begin = os_.now();
  Status s = link_->wait_start();
  report_.started = s.has_value();
  if (s) s = report_.mode == sim_hil::Mode::lockstep ? run_lockstep() : run_free();
  if (feed_.busy()) feed_.wait();  // its pixels go to memory of this session
  refresh_report();
  report_.wall_s = msg::seconds(os_.now() - begin);
  if (!link_) {
    report_.reason = "a fault closed the connection";
    return {};
  }
  if (s) {
    report_.reason = "duration is over";
    static_cast<void>(link_->send_report(world_->now(), report_.text));  // the run is over; the runtime may be gone
    link_->bye(report_.reason);
    return {};
  }
  report_.reason = link_->reason();
  if (relink_ && relink_->in_vain()) report_.reason += "; no other runtime has come";
  report_.broken = !link_->ended_politely();
  return {};
}

bool Session::over() const { return options_.duration_s > 0 && msg::seconds(world_->now()) >= options_.duration_s; }

/// One exchange per millisecond. All samples that are ready by its end are known at its beginning, so the grant goes
/// that far; the four plant steps in it still start the commands exactly at their commits.
Status Session::run_lockstep() {
  const hal::Duration cpu = os_.thread_cpu_time();
  Status s = link_->grant(Time{0});
  while (s && !over() && !line_closed()) {
    const Time until{world_->now().ns + kMsNs - 1};
    s = send_frame_due_by(until, true);
    if (s) s = release_held(until);
    if (s) s = link_->grant(until);
    if (s) s = advance_one_ms();
  }
  report_.cpu_s = msg::seconds(os_.thread_cpu_time() - cpu);
  return s;
}

/// Steps a second world for a short time: page faults and lazy binding happen before the clock runs.
void Session::rehearse() {
  if (!os_.lock_memory()) std::fprintf(stderr, "sinew-sim: memory is not locked; page faults may delay samples\n");
  auto scratch = options_.world.type->create(options_.world.values, report_.seed);
  if (!scratch) return;  // the real world has been made already
  std::array<double, msg::kMaxChannels> command;
  command.fill(0.8);
  const std::span<const double> used(command.data(), info_.find(Part::actuators)->channels);
  for (int i = 0; i < 800; ++i) (*scratch)->step(used);
}

Status Session::run_free() {
  Status result;
  const auto body = [&] {
    const hal::Duration cpu = os_.thread_cpu_time();
    const double rate = link_->hello().rate;
    const Time start = os_.now();
    host_zero_ = start;
    result = link_->start_clock(Time{0}, start);
    while (result && !over() && !line_closed()) {
      const std::int64_t end_ns = world_->now().ns + kMsNs;
      const Time due{start.ns + static_cast<std::int64_t>(static_cast<double>(end_ns) / rate)};
      const bool slept = os_.now() < due;
      if (slept) os_.sleep_until(due);
      const Time woken = os_.now();
      if (woken - due > ns(kMsNs)) ++report_.steps_late;
      // Commands that came in the last millisecond act at their commits in it; then its samples go out.
      if (relink_) result = welcome_another(start);
      if (result) result = link_->exchange();
      if (result) result = advance_one_ms();
      if (result) result = send_frame_due_by(world_->now(), false);
      if (result) result = release_held(world_->now());
      if (result) result = link_->exchange();
      if (!result) result = go_on_without_runtime(result);
      const Time sent = os_.now();
      note_imu_gap(sent);
      report_.work_max_ns = std::max(report_.work_max_ns, (sent - woken).count());
      if (slept) report_.wake_late_max_ns = std::max(report_.wake_late_max_ns, (woken - due).count());
    }
    report_.cpu_s = msg::seconds(os_.thread_cpu_time() - cpu);
  };
  hal::ThreadOptions thread;
  thread.name = "plant_physics";
  thread.fifo_priority = options_.fifo_priority;
  thread.stack_bytes = 1024 * 1024;
  auto physics = os_.start_thread(thread, body);
  if (!physics) return physics.error();
  if (!(*physics)->shortfall().empty())
    std::fprintf(stderr, "sinew-sim: physics thread: %s\n", (*physics)->shortfall().c_str());
  (*physics)->join();
  return result;
}

/// Ok: the runtime is gone without a Bye, and the world waits for another.
Status Session::go_on_without_runtime(Status lost) {
  const bool breach = lost.error().code == hal::Errc::bad_data;
  const bool waiting = relink_ && relink_->looking();
  if (!plant_listener_ || options_.relink_s <= 0 || breach || waiting || link_->ended_politely()) return lost;
  if (!relink_)
    relink_ = std::make_unique<Relink>(os_, *plant_listener_, description(feed_.options(), options_), frames_.get(),
                                       link_->hello().rate);
  if (!relink_->look(hal::Duration{static_cast<std::int64_t>(options_.relink_s * 1e9)})) return lost;
  link_->go_alone();
  return {};
}

Status Session::welcome_another(Time start) {
  if (!relink_->looking()) return {};
  if (relink_->in_vain()) return hal::Error{hal::Errc::closed, "no other runtime has come"};
  if (feed_.busy()) return {};  // it draws into the old link's memory
  auto link = relink_->take();
  if (!link) return {};
  ++report_.relinks;
  expired_before_ += link_->stats().lease_expiries;
  pending_.reset();
  link_ = std::move(link);
  if (report_.stopped_by_supervisor) link_->stop_for_good();
  const auto since_start = static_cast<std::int64_t>(static_cast<double>(world_->now().ns) / link_->hello().rate);
  return link_->start_clock(world_->now(), Time{start.ns + since_start});
}

void Session::note_imu_gap(Time now) {
  if (last_imu_.ns >= 0) report_.imu_gap_max_ns = std::max(report_.imu_gap_max_ns, (now - last_imu_).count());
  last_imu_ = now;
}

/// Called once a millisecond. A stop holds until the end of the run.
void Session::heed_stop_line() {
  if (!plant_listener_ || report_.stopped_by_supervisor || !plant_listener_->stopped()) return;
  link_->stop_for_good();
  report_.stopped_by_supervisor = true;
  report_.stopped_at = world_->now();
}

Status Session::advance_one_ms() {
  heed_stop_line();
  for (int i = 0; i < kImuSteps; ++i) {
    commanded_ = link_->setpoints_at(id(Part::actuators), world_->now());
    const Due& due = world_->step(act());
    if (options_.wire) options_.wire->step(*world_, due, host_zero_ + (world_->now() - Time{0}));
    if (Status s = send_due(due); !s) return s;
  }
  return {};
}

/// The setpoints of the step that starts now; without a valid command none: the safe action.
std::span<const double> Session::act() {
  const sim_hil::Setpoints acting = faults_->actuators.act(commanded_, world_->now());
  if (!acting.valid || report_.stopped_by_supervisor) return {};  // the stop line passes by all faults
  acting_ = acting.value;
  const Time now = world_->now();
  if (now - acting.commit >= acting.lease) ++report_.stale_actuations;
  report_.setpoint_age_max_ns = std::max(report_.setpoint_age_max_ns, (now - acting.stamp).count());
  return {acting_.data(), info_.find(Part::actuators)->channels};
}

bool Session::line_closed() {
  if (!faults_->line_closes_by(world_->now())) return false;
  if (feed_.busy()) feed_.wait();
  refresh_report();
  link_.reset();  // without a good-bye
  go_on_alone();
  return true;
}

/// Steps the world to its end when the runtime neither hears nor says anything. Nobody watches, so not in real time.
void Session::go_on_alone() {
  const Time end{world_->now().ns + kAloneNs};
  do {
    world_->step(act());
  } while (world_->now() < end && !world_->still());
}

Status Session::send_due(const Due& due) {
  const auto pass = [&](auto& faults, Part part, const auto& sample) {
    return faults.offer(sample, sample.stamp + ns(delay_of(info_, part)), sender(part));
  };
  Status s;
  if (due.imu) s = pass(faults_->imu, Part::imu, due.imu_sample);
  if (s && due.range) s = pass(faults_->range, Part::range, due.range_sample);
  if (s && due.baro) s = pass(faults_->baro, Part::baro, due.baro_sample);
  if (s && due.battery) s = pass(faults_->battery, Part::battery, due.battery_sample);
  if (s && due.joints) s = pass(faults_->joints, Part::joints, due.joints_sample);
  if (s && due.camera) s = begin_frame();
  if (s && due.truth) s = send_truth_and_report();
  return s;
}

/// Sends the samples and frames that were held back and are ready by then.
Status Session::release_held(Time until) {
  Status s = faults_->imu.release(until, sender(Part::imu));
  if (s) s = faults_->range.release(until, sender(Part::range));
  if (s) s = faults_->baro.release(until, sender(Part::baro));
  if (s) s = faults_->battery.release(until, sender(Part::battery));
  if (s) s = faults_->joints.release(until, sender(Part::joints));
  if (s) s = faults_->frames.release(until, [this](auto pixels, const auto& meta) { return copy_frame(pixels, meta); });
  return s;
}

Status Session::begin_frame() {
  ++frame_number_;
  if (pending_) {  // free-running only: drawing takes longer than a frame's period
    ++report_.render_late;
    return {};
  }
  PendingFrame frame;
  const bool faulty = faults_->frames.any();
  if (!faulty) frame.slot = link_->begin_frame(id(Part::camera));
  frame.meta.stamp = world_->now();
  frame.meta.ready = frame.meta.stamp + ns(delay_of(info_, Part::camera));
  frame.meta.exposure_ns = kExposureNs;
  frame.meta.number = frame_number_;
  const auto pixels = faulty ? faults_->frames.canvas() : frame.slot.pixels;
  feed_.request(world_->scene(), frame_number_, pixels.data());
  pending_ = frame;
  return {};
}

Status Session::send_frame_due_by(Time until, bool wait) {
  if (!pending_ || pending_->meta.ready > until) return {};
  if (wait) feed_.wait();
  if (feed_.busy()) return {};
  if (!wait && until - pending_->meta.ready > ns(kMsNs)) {
    ++report_.render_late;
    pending_->meta.ready = until;
  }
  ++report_.frames;
  const PendingFrame frame = *pending_;
  pending_.reset();
  if (!faults_->frames.any()) return send_frame(frame.slot, frame.meta);
  return faults_->frames.offer(frame.meta, [this](auto pixels, const auto& meta) { return copy_frame(pixels, meta); });
}

Status Session::send_frame(const sim_hil::FrameSlot& slot, const sim_hil::FrameMeta& meta) {
  if (WireCamera* camera = options_.wire ? options_.wire->camera() : nullptr) {
    std::copy(slot.pixels.begin(), slot.pixels.end(), camera->canvas().begin());
    camera->deliver(host_zero_ + (meta.stamp - Time{0}) + options_.wire->stamps_late(), meta.number);
  }
  return link_->send_frame(id(Part::camera), slot, meta);
}

Status Session::copy_frame(std::span<const std::uint8_t> pixels, const sim_hil::FrameMeta& meta) {
  const sim_hil::FrameSlot slot = link_->begin_frame(id(Part::camera));
  std::copy(pixels.begin(), pixels.end(), slot.pixels.begin());
  return send_frame(slot, meta);
}

Status Session::send_truth_and_report() {
  const WorldTruth t = world_->ground_truth();
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
  const bool news = world_->news() != told_news_;
  if (!news && now.ns % kReportEveryNs != 0) return {};
  told_news_ = world_->news();
  refresh_report();
  return link_->send_report(now, report_.text);
}

void Session::refresh_report() {
  report_.still = world_->still();
  report_.outcome = world_->outcome();
  report_.plant_s = msg::seconds(world_->now());
  report_.faults.clear();
  for (const FaultLog::Entry& e : faults_->log.entries())
    if (e.fault.from_ns <= world_->now().ns) report_.faults.push_back(e);
  if (options_.wire)
    for (const FaultLog::Entry& e : options_.wire->faults())
      if (e.fault.from_ns <= world_->now().ns) report_.faults.push_back(e);
  if (link_) report_.lease_expiries = expired_before_ + link_->stats().lease_expiries;
  report_.text = report_.json(*world_);
}

}  // namespace sinew::plant
