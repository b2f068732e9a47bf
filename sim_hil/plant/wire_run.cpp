#include "sim_hil/plant/wire_run.hpp"

#include <algorithm>
#include <cstdio>

namespace sinew::plant {
namespace {

using hal::Status;
using hal::Time;

}  // namespace

WireRun::WireRun(hal::Os& os, CameraFeed& camera, WireDevices& wire, const SessionOptions& options)
    : os_(os), feed_(camera), wire_(wire), options_(options) {}

Status WireRun::open() {
  report_.mode = sim_hil::Mode::free_running;
  report_.seed = options_.seed.value_or(1);
  const WorldInfo& info = options_.world.type->info;
  report_.world_name = info.name;
  if (const WorldDevice* camera = info.find(Part::camera)) camera_delay_ns_ = camera->delay_ns;
  auto made = options_.world.create(report_.seed);
  if (!made) {
    report_.reason = "the world could not be made";
    return made.error();
  }
  world_ = std::move(*made);
  feed_.set_seed(report_.seed);
  const Status attached = wire_.attach(*world_);
  if (!attached) report_.reason = attached.error().where;
  return attached;
}

Status WireRun::run(const std::function<bool()>& stop) {
  if (Status opened = open(); !opened) return opened;
  if (!os_.lock_memory()) std::fprintf(stderr, "sinew-sim: memory is not locked; page faults may delay samples\n");
  hal::ThreadOptions thread;
  thread.name = "plant_physics";
  thread.fifo_priority = options_.fifo_priority;
  thread.stack_bytes = std::size_t{1024} * 1024;
  auto physics = os_.start_thread(thread, [&] { loop(stop); });
  if (!physics) {
    report_.reason = "no thread for the physics";
    return physics.error();
  }
  report_.started = true;
  if (!(*physics)->shortfall().empty())
    std::fprintf(stderr, "sinew-sim: physics thread: %s\n", (*physics)->shortfall().c_str());
  (*physics)->join();
  if (feed_.busy()) feed_.wait();  // its pixels go to memory of the camera
  report_.still = world_->robot(0).still();
  report_.outcome = world_->robot(0).outcome();
  report_.plant_s = msg::seconds(world_->now());
  report_.wall_s = msg::seconds(os_.now() - host_zero_);
  for (const FaultLog::Entry& e : wire_.faults())
    if (e.fault.from_ns <= world_->now().ns) report_.faults.push_back(e);
  report_.text = report_.json(world_->robot(0));
  return {};
}

void WireRun::loop(const std::function<bool()>& stop) {
  const hal::Duration cpu = os_.thread_cpu_time();
  host_zero_ = os_.now();
  for (;;) {
    if (stop()) {
      report_.reason = "it was asked to stop";
      break;
    }
    if (options_.duration_s > 0 && msg::seconds(world_->now()) >= options_.duration_s) {
      report_.reason = "duration is over";
      break;
    }
    const Time due = host_zero_ + (world_->now() - Time{0}) + kExchange;
    const bool slept = os_.now() < due;
    if (slept) os_.sleep_until(due);
    const Time woken = os_.now();
    if (woken - due > kExchange) ++report_.steps_late;
    if (slept) report_.wake_late_max_ns = std::max(report_.wake_late_max_ns, (woken - due).count());
    advance_one_ms();
    finish_frame();
    report_.work_max_ns = std::max(report_.work_max_ns, (os_.now() - woken).count());
  }
  report_.cpu_s = msg::seconds(os_.thread_cpu_time() - cpu);
}

void WireRun::advance_one_ms() {
  for (int i = 0; i < kImuSteps; ++i) {
    const Due& due = world_->step({});  // the drives move its joints
    wire_.step(*world_, due, host_zero_ + (world_->now() - Time{0}));
    if ((due.cameras & 1) != 0 && wire_.camera()) begin_frame();
  }
}

void WireRun::begin_frame() {
  ++frame_number_;
  if (drawn_) {  // drawing takes longer than a frame's period; the frame numbers show it
    ++report_.render_late;
    return;
  }
  drawn_ = Frame{world_->now(), frame_number_};
  feed_.request(world_->robot(0).scene(0), frame_number_, wire_.camera()->canvas().data());
}

void WireRun::finish_frame() {
  if (!drawn_ || feed_.busy()) return;
  const std::int64_t age_ns = world_->now().ns - drawn_->stamp.ns;
  if (age_ns < camera_delay_ns_) return;
  if (age_ns > camera_delay_ns_ + kExchange.count()) ++report_.render_late;
  ++report_.frames;
  wire_.camera()->deliver(host_zero_ + (drawn_->stamp - Time{0}) + wire_.stamps_late(), drawn_->number);
  drawn_.reset();
}

}  // namespace sinew::plant
