#include "sim_hil/plant/session.hpp"

#include <algorithm>
#include <cstdio>

namespace sinew::plant {
namespace {

using hal::Status;
using hal::Time;

constexpr hal::Duration kAlone = std::chrono::seconds(10);  // so long the plant steps a world that was cut off

}  // namespace

Session::Session(hal::Os& os, std::vector<CameraFeed*> cameras, const SessionOptions& options)
    : os_(os), options_(options) {
  const std::size_t each = RobotSession::cameras_of(options_.world.type->info);
  for (std::size_t i = 0; i < options_.world.robot_count(); ++i)
    robots_.push_back(
        std::make_unique<RobotSession>(os_, std::span(cameras).subspan(i * each, each), options_, physics_, i));
  commands_.resize(robots_.size());
}

Status Session::refuse_all(std::string why, hal::Error error) {
  for (const auto& robot : robots_) static_cast<void>(robot->refuse(why, error));
  return error;
}

Status Session::open(std::vector<sim_hil::Caller> callers, sim_hil::PlantListener* plant_listener) {
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (Status s = robots_[i]->open(std::move(callers[i]), plant_listener); !s)
      return robots_.size() == 1 ? s : refuse_all(robots_[i]->report().reason, s.error());
  const sim_hil::Hello& first = robots_[0]->hello();
  for (const auto& robot : robots_)
    if (robot->hello().mode != first.mode || robot->hello().rate != first.rate)
      return refuse_all("the robots of this world ask for different modes or rates",
                        {hal::Errc::not_supported, "plant session"});
  const std::uint64_t seed = options_.seed.value_or(first.seed);
  auto made = options_.world.create(seed);
  if (!made)
    return refuse_all(made.error().code == hal::Errc::bad_argument
                          ? "the world could not be made: " + std::string(made.error().where)
                          : "the world could not be made",
                      made.error());
  world_ = std::move(*made);
  if (options_.wire) {
    std::string why;
    if (first.mode == sim_hil::Mode::lockstep) why = "devices at the wire are in real time only";
    if (Status s = options_.wire->attach(*world_); !s) why = s.error().where;
    if (!why.empty()) return refuse_all(why, {hal::Errc::not_supported, "devices at the wire"});
  }
  for (const auto& robot : robots_) robot->enter(*world_, seed);
  const WorldInfo& info = options_.world.type->info;
  if (info.has_radio()) air_ = Air(air_options(info, options_.world.values), robots_.size(), seed);
  said_.reserve(robots_.size() * sim_hil::PlantLink::kMostSent);
  return {};
}

Status Session::serve(std::unique_ptr<hal::Stream> stream) {
  std::vector<sim_hil::Caller> callers(1);
  callers[0].stream = std::move(stream);
  SessionReport& report = robots_[0]->report();
  if (Status s = hear_hello(callers[0], "sinew-sim", report.reason); !s) {
    report.broken = true;
    return s;
  }
  return serve(std::move(callers), nullptr);
}

Status Session::serve(std::vector<sim_hil::Caller> callers, sim_hil::PlantListener& plant_listener) {
  return serve(std::move(callers), &plant_listener);
}

Status Session::serve(std::vector<sim_hil::Caller> callers, sim_hil::PlantListener* plant_listener) {
  if (Status s = open(std::move(callers), plant_listener); !s) {
    for (const auto& robot : robots_) robot->report().broken = true;
    return s;
  }
  const bool lockstep = robots_[0]->hello().mode == sim_hil::Mode::lockstep;
  if (!lockstep) rehearse();
  const Time begin = os_.now();
  Status waited;
  for (const auto& robot : robots_)
    if (Status s = robot->wait_start(); !s) waited = s;
  // One that leaves before the start only looked for its plant, so all have to come again.
  if (!waited && robots_.size() > 1)
    static_cast<void>(refuse_all("a robot of this world left before the start", waited.error()));
  Status ran;
  if (waited && lockstep) run_lockstep();
  if (waited && !lockstep) ran = run_free();
  if (!ran) static_cast<void>(refuse_all("no thread for the physics", ran.error()));
  physics_.wall_s = msg::seconds(os_.now() - begin);
  physics_.plant_s = msg::seconds(world_->now());
  for (const auto& robot : robots_) robot->finish();
  return ran;
}

bool Session::goes_on() {
  for (const auto& robot : robots_) robot->close_by_fault();
  if (options_.duration_s > 0 && msg::seconds(world_->now()) >= options_.duration_s) return false;
  return !all_gone();
}

bool Session::all_gone() const {
  return std::ranges::all_of(robots_, [](const auto& robot) { return robot->gone(); });
}

/// All runtimes work at the same time.
void Session::grant(Time until) {
  for (const auto& robot : robots_) robot->begin_grant(until);
  for (const auto& robot : robots_) robot->wait_done();
}

/// One exchange per millisecond. All samples that are ready by its end are known at its beginning, so the grant goes
/// that far; the four plant steps in it still start the commands exactly at their commits.
void Session::run_lockstep() {
  const hal::Duration cpu = os_.thread_cpu_time();
  grant(Time{0});
  while (goes_on()) {
    const Time until = world_->now() + kExchange - hal::Duration{1};
    for (const auto& robot : robots_) {
      robot->send_ready(until, true);
      if (air_.stations() > 0) robot->hear_air(air_, until);
    }
    grant(until);
    pass_on_said(until);
    if (all_gone()) break;
    advance_one_ms();
  }
  go_on_alone();
  physics_.cpu_s = msg::seconds(os_.thread_cpu_time() - cpu);
}

/// Steps a second world for a short time: page faults and lazy binding happen before the clock runs.
void Session::rehearse() {
  if (!os_.lock_memory()) std::fprintf(stderr, "sinew-sim: memory is not locked; page faults may delay samples\n");
  auto scratch = options_.world.create(robots_[0]->report().seed);
  if (!scratch) return;  // the real world has been made already
  const std::vector<double> command(options_.world.type->info.channels(Part::actuators), 0.8);
  const std::vector<RobotCommand> all(robots_.size(), RobotCommand(command));
  for (int i = 0; i < 800; ++i) (*scratch)->advance(all);
}

Status Session::run_free() {
  const auto body = [&] {
    const hal::Duration cpu = os_.thread_cpu_time();
    const double rate = robots_[0]->hello().rate;
    host_zero_ = os_.now();
    Time last_sent{-1};
    for (const auto& robot : robots_) robot->start_clock(Time{0}, host_zero_);
    while (goes_on()) {
      const Time end = world_->now() + kExchange;
      const Time due = host_zero_ + hal::Duration{static_cast<std::int64_t>(static_cast<double>(end.ns) / rate)};
      const bool slept = os_.now() < due;
      if (slept) os_.sleep_until(due);
      const Time woken = os_.now();
      if (woken - due > kExchange) ++physics_.steps_late;
      // Commands that came in the last millisecond act at their commits in it; then its samples go out.
      for (const auto& robot : robots_) robot->hear();
      pass_on_said(world_->now());
      advance_one_ms();
      for (const auto& robot : robots_) {
        robot->send_ready(world_->now(), false);
        if (air_.stations() > 0) robot->hear_air(air_, world_->now());
        robot->tell();
      }
      const Time sent = os_.now();
      if (last_sent.ns >= 0) physics_.imu_gap_max_ns = std::max(physics_.imu_gap_max_ns, (sent - last_sent).count());
      last_sent = sent;
      physics_.work_max_ns = std::max(physics_.work_max_ns, (sent - woken).count());
      if (slept) physics_.wake_late_max_ns = std::max(physics_.wake_late_max_ns, (woken - due).count());
    }
    go_on_alone();
    physics_.cpu_s = msg::seconds(os_.thread_cpu_time() - cpu);
  };
  hal::ThreadOptions thread;
  thread.name = "plant_physics";
  thread.fifo_priority = options_.fifo_priority;
  thread.stack_bytes = std::size_t{1024} * 1024;
  auto physics = os_.start_thread(thread, body);
  if (!physics) return physics.error();
  if (!(*physics)->shortfall().empty())
    std::fprintf(stderr, "sinew-sim: physics thread: %s\n", (*physics)->shortfall().c_str());
  (*physics)->join();
  return {};
}

void Session::advance_one_ms() {
  for (const auto& robot : robots_) robot->heed_stop_line();
  for (int i = 0; i < kImuSteps; ++i) {
    step();
    if (options_.wire) options_.wire->step(*world_, world_->robot(0).due(), host_zero_ + (world_->now() - Time{0}));
    if (options_.game) options_.game->step(*world_);
    for (const auto& robot : robots_) robot->send_due();
  }
  physics_.plant_s = msg::seconds(world_->now());
}

/// What was said by `now` goes into the air in an order that does not depend on who answered first.
void Session::pass_on_said(Time now) {
  if (air_.stations() == 0) return;
  said_.clear();
  for (const auto& robot : robots_) robot->collect_said(said_);
  if (said_.empty()) return;
  for (std::size_t i = 0; i < robots_.size(); ++i) air_.move(i, robots_[i]->robot().ground_truth().p_world_m);
  std::ranges::stable_sort(said_,
                           [](const Said& a, const Said& b) { return a.at != b.at ? a.at < b.at : a.robot < b.robot; });
  for (const Said& said : said_) air_.send(said.robot, said.at, said.bytes, now);
}

void Session::step() {
  for (std::size_t i = 0; i < robots_.size(); ++i) commands_[i] = robots_[i]->act();
  world_->advance(commands_);
}

/// A fault closed a connection, and no runtime hears or says anything any more: steps the world to its end. Nobody
/// watches, so not in real time.
void Session::go_on_alone() {
  const bool closed = std::ranges::any_of(robots_, [](const auto& robot) { return robot->closed_by_fault(); });
  if (!closed || !all_gone()) return;
  const Time end = world_->now() + kAlone;
  const auto all_still = [&] { return std::ranges::all_of(robots_, [](const auto& r) { return r->robot().still(); }); };
  do step();
  while (world_->now() < end && !all_still());
}

}  // namespace sinew::plant
