#pragma once
// robots/quad/quad.toml in virtual time in a small world of these tests: the real modules, the real graph, no plant.
#include <cmath>
#include <deque>
#include <functional>
#include <vector>

#include "../control/test_world.hpp"
#include "apps/module_list.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "math/elementary.hpp"
#include "msg/flight.hpp"
#include "poisoner.hpp"
#include "rt/exec/discrete_executor.hpp"
#include "rt/guardian.hpp"
#include "rt/latch.hpp"
#include "source_dir.hpp"
#include "vision/pinhole.hpp"

namespace sinew::app::test {

using rt::Duration;
using rt::Time;
using namespace std::chrono_literals;

/// Samples that are ready as soon as they are put in.
template <class Interface, class M>
class FakeSensor final : public Interface {
 public:
  explicit FakeSensor(const hal::Clock& clock) : clock_(clock) {}
  std::deque<M> waiting;
  hal::Result<bool> read(M& out) noexcept override {
    if (waiting.empty()) return false;
    out = waiting.front();
    waiting.pop_front();
    return true;
  }
  hal::Time ready_at() const noexcept override { return waiting.empty() ? hal::kNever : clock_.now(); }
  void set_wake(hal::Wake*) noexcept override {}

 private:
  const hal::Clock& clock_;
};

/// A floor with an orange disc on dark cloth, seen from where the vehicle is.
class FakeCamera final : public hal::Camera {
 public:
  static constexpr std::uint32_t kWidth = 160, kHeight = 120;
  static constexpr math::Vec3 kPad{0.35, 0.25, 0};
  explicit FakeCamera(const hal::Clock& clock) : clock_(clock) {}
  struct Frame {
    Time stamp;
    math::Vec3 p_world;
    math::Quat q_world_optical;
  };
  std::deque<Frame> waiting;

  hal::Result<bool> read(msg::Image& out) noexcept override {
    if (waiting.empty()) return false;
    const Frame frame = waiting.front();
    waiting.pop_front();
    if (!out.format_as(msg::PixelFormat::yuyv, kWidth, kHeight)) return hal::Error{hal::Errc::bad_argument, "camera"};
    out.stamp = frame.stamp;
    out.frame_number = ++count_;
    for (std::uint32_t y = 0; y < kHeight; ++y)
      for (std::uint32_t x = 0; x < kWidth; x += 2) paint(out.row(y) + 2 * x, frame, x, y);
    return true;
  }
  hal::Time ready_at() const noexcept override { return waiting.empty() ? hal::kNever : clock_.now(); }
  void set_wake(hal::Wake*) noexcept override {}

 private:
  void paint(std::uint8_t* yuyv, const Frame& frame, std::uint32_t x, std::uint32_t y) const {
    const msg::Vec3 d = pinhole_.direction(x + 0.5, y);
    const math::Vec3 ray = frame.q_world_optical.rotate(math::Vec3(d));
    const math::Vec3 at = ray.z < -0.05 ? frame.p_world + ray * (-frame.p_world.z / ray.z) - kPad : math::Vec3{9, 9, 0};
    const double r = math::hypot(at.x, at.y);
    const bool disc = r<0.30, ring = r> 0.144 && r < 0.166, cloth = math::fabs(at.x) < 0.4 && math::fabs(at.y) < 0.4;
    const std::uint8_t luma = ring ? 230 : disc ? 110 : cloth ? 60 : 140;
    const bool orange = disc && !ring;
    yuyv[0] = yuyv[2] = luma;
    yuyv[1] = orange ? 75 : 128;   // Cb
    yuyv[3] = orange ? 210 : 128;  // Cr
  }
  const hal::Clock& clock_;
  vision::Pinhole pinhole_ = vision::Pinhole::from_fov(1.0382921838, kWidth, kHeight);
  std::uint32_t count_ = 0;
};

/// Motors that judge their commands, and stop by themselves when the lease is over.
class JudgedMotors final : public hal::Actuators {
 public:
  struct Event {
    Time at;
    bool stopped;
  };
  JudgedMotors(const hal::Clock& clock, Duration lease) : clock_(clock), lease_(lease) { events.reserve(100'000); }

  hal::Status write(const msg::ActuatorCommand& c, Duration lease) noexcept override {
    if (c.count != 4) ++wrong;
    for (std::uint32_t i = 0; i < 4; ++i)
      if (!(c.value[i] >= 0 && c.value[i] <= 1)) ++wrong;
    if (lease <= Duration{0} || lease > lease_) ++wrong;
    for (std::size_t i = 0; i < 4; ++i) largest_change = std::max(largest_change, math::fabs(c.value[i] - value_[i]));
    until_ = clock_.now() + lease;
    if (newest_commit && until_ > newest_commit() + lease_) ++wrong;  // it would outlive the command
    std::copy_n(c.value.begin(), 4, value_.begin());
    note({clock_.now(), false});
    return {};
  }
  hal::Status stop() noexcept override {
    until_ = {};
    note({clock_.now(), true});
    return {};
  }
  std::array<double, 4> at(Time now) const { return now < until_ ? value_ : std::array<double, 4>{}; }

  std::vector<Event> events;
  int wrong = 0;                        // wrong values, channels or leases
  double largest_change = 0;            // of a value, from one command to the next
  std::function<Time()> newest_commit;  // of the command topic

 private:
  void note(const Event& e) noexcept {
    if (events.size() < events.capacity()) events.push_back(e);
  }
  const hal::Clock& clock_;
  Duration lease_;
  Time until_{};
  std::array<double, 4> value_{};
};

/// The world, its board and its grants: a plant step of 0.25 ms each.
class FaultWorld final : public hal::EmptyBoard, public hal::GrantSource {
 public:
  FaultWorld(hal::ManualClock& clock, Duration lease)
      : imus_(clock), ranges_(clock), baros_(clock), batteries_(clock), camera_(clock), motors(clock, lease) {}
  hal::Result<hal::Device*> open_sensor(hal::SensorKind kind, std::string_view) override {
    switch (kind) {
      case hal::SensorKind::imu:
        return &imus_;
      case hal::SensorKind::range:
        return &ranges_;
      case hal::SensorKind::baro:
        return &baros_;
      case hal::SensorKind::battery:
        return &batteries_;
      default:
        return hal::Error{hal::Errc::not_found, "fault world"};
    }
  }
  hal::Result<hal::Camera*> camera(std::string_view) override { return &camera_; }
  hal::Result<hal::Actuators*> actuators(std::string_view) override { return &motors; }

  hal::Result<Time> next_grant(Time done_to) override {
    if (look) look(done_to);
    if (done_to >= end) return hal::Error{hal::Errc::closed, "end of the test"};
    const control::test::Samples s = model.step(motors.at(done_to));
    const control::test::Truth truth = model.truth();
    fastest_fall_mps = std::max(fastest_fall_mps, -truth.v_world_mps.z);
    largest_tilt_rad = std::max(largest_tilt_rad, std::acos(std::min(1.0, truth.q_world_base.rotate({0, 0, 1}).z)));
    ++steps_;
    if (s.imu && imu_works)
      imus_.waiting.push_back(imu_stuck ? msg::ImuSample{s.now, {0, 0, 0}, {0, 0, 9.81}} : *s.imu);
    if (s.range && range_works) ranges_.waiting.push_back(*s.range);
    if (steps_ % 80 == 40 && baro_works) {
      const double kelvin = 288.15, p = 101325 * math::exp(-truth.p_world_m.z / (29.2718 * kelvin));
      baros_.waiting.push_back({s.now, p + noise_.normal(0, 2), kelvin - 273.15});
    }
    if (steps_ % 400 == 100) batteries_.waiting.push_back({s.now, voltage_v + noise_.normal(0, 0.02), 9, 0.8});
    if (steps_ % 133 == 50 && camera_works)
      camera_.waiting.push_back({s.now, truth.p_world_m + truth.q_world_base.rotate(model.p_base_camera),
                                 truth.q_world_base * model.q_base_optical});
    return s.now;
  }

  control::test::QuadModel model;
  Time end{};
  double voltage_v = 15.5;
  bool imu_works = true, imu_stuck = false, range_works = true, baro_works = true, camera_works = true;
  double fastest_fall_mps = 0, largest_tilt_rad = 0;
  std::function<void(Time)> look;

 private:
  FakeSensor<hal::Imu, msg::ImuSample> imus_;
  FakeSensor<hal::Range, msg::RangeSample> ranges_;
  FakeSensor<hal::Baro, msg::BaroSample> baros_;
  FakeSensor<hal::Battery, msg::BatterySample> batteries_;
  FakeCamera camera_;
  math::Random noise_{3, 9};
  std::int64_t steps_ = 0;

 public:
  JudgedMotors motors;
};

/// The record of a flight.
class FlightLog final : public rt::RunObserver {
 public:
  FlightLog() {
    guardian_steps.reserve(100'000);
    battery_steps.reserve(10'000);
  }
  void completed(const rt::StepRecord& r) noexcept override {
    if (r.module == guardian && guardian_steps.size() < guardian_steps.capacity()) guardian_steps.push_back(r.now);
    if (r.module == battery && r.status == rt::StepStatus::ok) battery_steps.push_back(r.now);
  }
  std::uint32_t guardian = 0, battery = 0;
  std::vector<Time> guardian_steps;
  std::vector<Time> battery_steps;  // raw messages are committed when they begin
};

struct SafetyEvent {
  Time at;  // SafetyState::stamp: the guardian's step
  msg::SafetyState state;
};

/// One flight of robots/quad/quad.toml with one fault.
class FaultFlight {
 public:
  explicit FaultFlight(std::function<void(rt::GraphSpec&)> change = {}) {
    auto loaded = load_robot(sinew::test::source_dir() + "/robots/quad/quad.toml");
    EXPECT_TRUE(loaded.problems.empty());
    spec = std::move(loaded.robot.graph);
    if (change) change(spec);
  }
  /// `module` gets the fault of `plan`.
  void poison(const std::string& module, const PoisonPlan& plan) {
    for (rt::ModuleSpec& m : spec.modules) {
      if (m.name != module) continue;
      if (plan.fault == Fault::disabled) disabled_ = module, disabled_at_ = plan.from;
      if (plan.fault == Fault::stalled) stall(m, plan.from);
      const std::string type = m.type;
      m.type = "test::Poisoner";
      types.add(m.type, [type, plan] { return std::make_unique<Poisoner>(all_modules().make(type), plan); });
    }
  }
  void fly(Duration duration) {
    graph = std::make_unique<rt::Graph>(spec, types);
    for (const auto& p : graph->check({.virtual_time = true})) ADD_FAILURE() << rt::to_string(p, "quad.toml");
    const Duration lease = spec.actuators[0].lease;
    world = std::make_unique<FaultWorld>(clock, lease);
    ASSERT_TRUE(graph->configure(*world, {.taps = {"guardian.state", "mission.mission"}}));
    log.guardian = 0;
    log.battery = graph->find_module("battery");
    latch_ = std::make_unique<rt::Latch>(graph->segment());
    latch_->bind(safety_, graph->taps()[0]);
    latch_->bind(mission_, graph->taps()[1]);
    world->end = Time{duration.count()};
    world->look = [this](Time now) { look(now); };
    rt::DiscreteOptions options;
    options.observer = &log;
    executor = std::make_unique<rt::DiscreteExecutor>(*graph, clock, *world, options);
    world->motors.newest_commit = [this] { return last_published(spec.actuators[0].command.value); };
    ASSERT_TRUE(executor->run());
  }
  Time last_published(const std::string& topic) {
    return Time{executor->runner().topic_stats(graph->find_topic(topic)).last_published_ns.value()};
  }
  std::optional<Time> first_stop_since(Time t) const {
    for (const auto& e : world->motors.events)
      if (e.stopped && e.at >= t) return e.at;
    return std::nullopt;
  }
  std::optional<Time> first_write() const {
    for (const auto& e : world->motors.events)
      if (!e.stopped) return e.at;
    return std::nullopt;
  }
  bool any_write_since(Time t) const {
    for (const auto& e : world->motors.events)
      if (!e.stopped && e.at >= t) return true;
    return false;
  }
  /// Commit of the first battery message at or after t.
  Time first_battery_since(Time t) const {
    for (const Time s : log.battery_steps)
      if (s >= t) return s;
    return Time{INT64_MAX};
  }
  /// The first step of the guardian at or after t.
  Time guardian_step_since(Time t) const {
    for (const Time s : log.guardian_steps)
      if (s >= t) return s;
    return Time{INT64_MAX};
  }

  rt::GraphSpec spec;
  rt::ModuleTypes types = all_modules();
  hal::ManualClock clock;
  std::unique_ptr<rt::Graph> graph;
  std::unique_ptr<FaultWorld> world;
  std::unique_ptr<rt::DiscreteExecutor> executor;
  FlightLog log;
  std::vector<SafetyEvent> actions;  // each change of the action or of its cause
  std::vector<msg::MissionPhase> phases;
  std::function<void(Time)> at_each_grant;

 private:
  void stall(rt::ModuleSpec& m, Time from) {
    Duration period = 33'250us;  // the camera's
    for (const rt::ThreadSpec& t : spec.threads)
      for (const auto& name : t.order)
        if (name.value == m.name && t.trigger == rt::ThreadSpec::Trigger::period) period = t.period;
    m.exec.kind = rt::ExecModel::Kind::trace;
    m.exec.trace.assign(static_cast<std::size_t>(from.ns / period.count()), m.exec.constant);
    m.exec.trace.emplace_back(1000s);
  }
  void look(Time now) {
    if (at_each_grant) at_each_grant(now);
    if (!disabled_.empty() && now >= disabled_at_) {
      EXPECT_TRUE(graph->set_enabled(disabled_, false));
      disabled_.clear();
    }
    latch_->latch();
    if (const auto* s = safety_.get())
      if (actions.empty() ? s->action != msg::FailsafeAction::none
                          : s->action != actions.back().state.action || s->acted != actions.back().state.acted)
        actions.push_back({s->stamp, *s});
    if (const auto* m = mission_.get())
      if (phases.empty() || phases.back() != m->phase) phases.push_back(m->phase);
    latch_->release();
    const bool done = !phases.empty() && phases.back() == msg::MissionPhase::done;
    if (!done) not_done_ = now;
    if (now - not_done_ > 500ms) world->end = now;
  }
  std::string disabled_;
  Time disabled_at_{}, not_done_{};
  std::unique_ptr<rt::Latch> latch_;
  rt::In<msg::SafetyState> safety_;
  rt::In<msg::MissionState> mission_;
};

}  // namespace sinew::app::test
