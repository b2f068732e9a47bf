#include "sim_hil/plant/session.hpp"

#include <algorithm>
#include <cstdio>

namespace sinew::plant {
namespace {

using hal::Status;
using hal::Time;

constexpr std::int64_t kMsNs = 1'000'000;
constexpr std::int64_t kExposureNs = 8'000'000;
constexpr std::int64_t kCameraDelayNs = 25'000'000;  // middle of the exposure to the driver: exposure, read-out, USB
constexpr std::int64_t kImuDelayNs = kImuSteps * kStepNs / 2;
constexpr std::int64_t kAloneNs = 10'000'000'000;     // so long a world is watched whose runtime has been cut off
constexpr std::int64_t kReportEveryNs = 100'000'000;  // the last one before the end tells where it came to rest

hal::Duration ns(std::int64_t n) { return hal::Duration{n}; }

sim_hil::DeviceInfo sensor(sim_hil::DeviceKind kind, const char* name, int steps, std::int64_t latency_ns) {
  sim_hil::DeviceInfo d;
  d.kind = kind;
  d.name = name;
  d.period = ns(steps * kStepNs);
  d.latency = ns(latency_ns);
  return d;
}

}  // namespace

Session::Session(hal::Os& os, CameraFeed& camera_feed, const SessionOptions& options)
    : os_(os), feed_(camera_feed), options_(options) {}

sim_hil::PlantDescription Session::description(const CameraOptions& view, const SessionOptions& options) {
  using sim_hil::DeviceKind;
  sim_hil::PlantDescription d;
  d.name = "sinew-sim";
  d.step = ns(kStepNs);
  d.seed = options.seed;
  d.devices.push_back(sensor(DeviceKind::imu, "imu", kImuSteps, kImuDelayNs));
  d.devices.push_back(sensor(DeviceKind::range, "range", kRangeSteps, kRangeDelayNs));
  d.devices.push_back(sensor(DeviceKind::baro, "baro", kBaroSteps, kBaroDelayNs));
  sim_hil::DeviceInfo c;
  c.kind = DeviceKind::camera;
  c.name = "camera";
  c.period = ns(1'000'000'000 / kCameraHz);
  c.latency = ns(kCameraDelayNs);
  c.width = view.width;
  c.height = view.height;
  c.format = view.format;
  d.devices.push_back(c);
  sim_hil::DeviceInfo m;
  m.kind = DeviceKind::actuators;
  m.name = "motors";
  m.channels = kRotors;
  d.devices.push_back(m);
  d.devices.push_back(sensor(DeviceKind::battery, "battery", kBatterySteps, kBatteryDelayNs));
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
  WorldOptions world = options_.world;
  world.seed = report_.seed = options_.seed.value_or(link_->hello().seed);
  auto made = World::create(world);
  if (!made) {
    report_.reason = "the world could not be made";
    link_->bye(report_.reason);
    return made.error();
  }
  world_ = std::move(*made);
  report_.mass_kg = world_->mass_kg();
  feed_.set_seed(report_.seed);
  faults_ = std::make_unique<PlantFaults>(options_.faults, report_.seed, feed_.options());
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

Status Session::serve(sim_hil::Caller caller, sim_hil::PlantDoor& door) {
  door_ = &door;
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
    static_cast<void>(link_->send_report(world_->now(), report_.json()));  // the run is over; nobody may be there
    link_->bye(report_.reason);
    return {};
  }
  report_.reason = link_->reason();
  if (relink_ && relink_->in_vain()) report_.reason += "; no other runtime has come";
  report_.broken = !link_->ended_politely();
  return {};
}

bool Session::over() const { return options_.duration_s > 0 && msg::seconds(world_->now()) >= options_.duration_s; }

/// One exchange per millisecond: all samples ready by its end are known at its beginning, so the grant goes that far,
/// and the four plant steps in it still start the commands exactly at their commits.
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

/// Takes page faults and lazy binding before the clock runs: a short flight of a second world, ground included.
void Session::rehearse() {
  if (!os_.lock_memory()) std::fprintf(stderr, "sinew-sim: memory is not locked; page faults may delay samples\n");
  auto scratch = World::create(options_.world);
  if (!scratch) return;  // the real one has been made already
  for (int i = 0; i < 800; ++i) (*scratch)->step({0.8, 0.8, 0.8, 0.8});
}

Status Session::run_free() {
  Status result;
  const auto body = [&] {
    const hal::Duration cpu = os_.thread_cpu_time();
    const double rate = link_->hello().rate;
    const Time start = os_.now();
    result = link_->start_clock(Time{0}, start);
    while (result && !over() && !line_closed()) {
      const std::int64_t end_ns = world_->now().ns + kMsNs;
      const Time due{start.ns + static_cast<std::int64_t>(static_cast<double>(end_ns) / rate)};
      const bool slept = os_.now() < due;
      if (slept) os_.sleep_until(due);
      const Time woken = os_.now();
      if (woken - due > ns(kMsNs)) ++report_.steps_late;
      // Commands that came in the millisecond just gone by act at their commits in it; then its samples go out.
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

/// Ok: the runtime is gone without a good-bye, and the world waits for another.
Status Session::go_on_without_runtime(Status lost) {
  const bool breach = lost.error().code == hal::Errc::bad_data;
  const bool waiting = relink_ && relink_->looking();
  if (!door_ || options_.relink_s <= 0 || breach || waiting || link_->ended_politely()) return lost;
  if (!relink_)
    relink_ = std::make_unique<Relink>(os_, *door_, description(feed_.options(), options_), frames_.get(),
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

/// Once a millisecond; it holds until the end of the run.
void Session::heed_stop_line() {
  if (!door_ || report_.stopped_by_supervisor || !door_->stopped()) return;
  link_->stop_for_good();
  report_.stopped_by_supervisor = true;
  report_.stopped_at = world_->now();
}

Status Session::advance_one_ms() {
  heed_stop_line();
  for (int i = 0; i < kImuSteps; ++i) {
    commanded_ = link_->setpoints_at(motors, world_->now());
    if (Status s = send_due(world_->step(motor_command())); !s) return s;
  }
  return {};
}

/// What the motors do in the step that starts now: nothing without a valid command.
std::array<double, kRotors> Session::motor_command() {
  const sim_hil::Setpoints acting = faults_->motors.act(commanded_, world_->now());
  std::array<double, kRotors> command{};
  if (!acting.valid || report_.stopped_by_supervisor) return command;  // the stop line passes by all faults
  std::copy_n(acting.value.begin(), kRotors, command.begin());
  const Time now = world_->now();
  if (now - acting.commit >= acting.lease) ++report_.stale_actuations;
  report_.setpoint_age_max_ns = std::max(report_.setpoint_age_max_ns, (now - acting.stamp).count());
  return command;
}

bool Session::line_closed() {
  if (!faults_->line_closes_by(world_->now())) return false;
  if (feed_.busy()) feed_.wait();
  refresh_report();
  link_.reset();  // without a good-bye
  go_on_alone();
  return true;
}

/// Where the vehicle ends whose runtime hears and says nothing any more. Nobody watches, so not in real time.
void Session::go_on_alone() {
  const Time end{world_->now().ns + kAloneNs};
  do {
    world_->step(motor_command());
    report_.last = world_->truth();
  } while (world_->now() < end && !(report_.at_rest() && report_.motors_stopped()));
}

Status Session::send_due(const Due& due) {
  const auto pass = [&](auto& faults, Device device, const auto& sample, std::int64_t delay_ns) {
    return faults.offer(sample, sample.stamp + ns(delay_ns), sender(device));
  };
  Status s;
  if (due.imu) s = pass(faults_->imu, imu, due.imu_sample, kImuDelayNs);
  if (s && due.range) s = pass(faults_->range, range, due.range_sample, kRangeDelayNs);
  if (s && due.baro) s = pass(faults_->baro, baro, due.baro_sample, kBaroDelayNs);
  if (s && due.battery) s = pass(faults_->battery, battery, due.battery_sample, kBatteryDelayNs);
  if (s && due.camera) s = begin_frame();
  if (s && due.truth) s = send_truth_and_report();
  return s;
}

/// What was held back and is ready by then.
Status Session::release_held(Time until) {
  Status s = faults_->imu.release(until, sender(imu));
  if (s) s = faults_->range.release(until, sender(range));
  if (s) s = faults_->baro.release(until, sender(baro));
  if (s) s = faults_->battery.release(until, sender(battery));
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
  if (!faulty) frame.slot = link_->begin_frame(camera);
  frame.meta.stamp = world_->now();
  frame.meta.ready = frame.meta.stamp + ns(kCameraDelayNs);
  frame.meta.exposure_ns = kExposureNs;
  frame.meta.number = frame_number_;
  const auto pixels = faulty ? faults_->frames.canvas() : frame.slot.pixels;
  feed_.request(world_->camera_pose(), frame_number_, pixels.data());
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
  if (!faults_->frames.any()) return link_->send_frame(camera, frame.slot, frame.meta);
  return faults_->frames.offer(frame.meta, [this](auto pixels, const auto& meta) { return copy_frame(pixels, meta); });
}

Status Session::copy_frame(std::span<const std::uint8_t> pixels, const sim_hil::FrameMeta& meta) {
  const sim_hil::FrameSlot slot = link_->begin_frame(camera);
  std::copy(pixels.begin(), pixels.end(), slot.pixels.begin());
  return link_->send_frame(camera, slot, meta);
}

Status Session::send_truth_and_report() {
  const TruthState t = world_->truth();
  sim_hil::Truth out;
  out.p_world_m = t.p_world_m;
  out.v_world_mps = t.v_world_mps;
  out.q_world_base = t.q_world_base;
  out.gyro_radps = t.gyro_radps;
  out.battery_v = t.voltage_v;
  out.contact = t.contact;
  out.landed = t.feet_down == 4;
  if (Status s = link_->send_truth(t.stamp, out); !s) return s;
  const bool news = world_->summary().touched_down && !told_touchdown_;
  if (!news && t.stamp.ns % kReportEveryNs != 0) return {};
  told_touchdown_ |= news;
  refresh_report();
  return link_->send_report(t.stamp, report_.json());
}

void Session::refresh_report() {
  report_.flight = world_->summary();
  report_.last = world_->truth();
  report_.plant_s = msg::seconds(world_->now());
  report_.faults.clear();
  for (const FaultLog::Entry& e : faults_->log.entries())
    if (e.fault.from_ns <= world_->now().ns) report_.faults.push_back(e);
  if (!link_) return;
  report_.lease_expiries = expired_before_ + link_->stats().lease_expiries;
}

}  // namespace sinew::plant
