// The stop line to CAN joints beside a runtime that drives them, in virtual time: simulated drives of every protocol
// hear it.
#include "drivers/joints/can_stop_line.hpp"

#include <gmock/gmock.h>

#include "../no_connectors.hpp"
#include "drivers/joints/dronecan_servo.hpp"
#include "servo_rig.hpp"
#include "sim_hil/wire/sim_dronecan.hpp"

namespace sinew::drivers::can_stop_line_test {
namespace {

using ::testing::HasSubstr;

DeviceSpec table(const std::string& name, const std::string& driver, std::map<std::string, rt::ParamValue> keys) {
  DeviceSpec spec;
  spec.name = name, spec.driver = driver;
  for (auto& [key, value] : keys) spec.keys[key] = {value, 1};
  return spec;
}

DeviceSpec joint(const std::string& name, const std::string& driver, int bus, int id,
                 std::map<std::string, rt::ParamValue> more = {}) {
  more["bus"] = "can" + std::to_string(bus);
  more["id"] = std::int64_t{id};
  more["max_velocity_radps"] = 10.0;
  return table(name, driver, more);
}

/// Six joints of all protocols on four buses, driven by their hubs as in a runtime.
class Robot : public ServoRig {
 public:
  Robot() : ServoRig({}, 4) {
    ServoConfig c = plain(Protocol::cia402, 1);
    c.device_timeout = 10s;
    drive = static_cast<sim_hil::SimCia402*>(&add(Protocol::cia402, c, 0));
    motors = {drive, &add(Protocol::ak80, plain(Protocol::ak80, 2), 1),
              &add(Protocol::damiao, plain(Protocol::damiao, 3), 1),
              &add(Protocol::cybergear, plain(Protocol::cybergear, 4), 2)};
    auto node = std::make_unique<DronecanNode>(DronecanNodeConfig{});
    add_dronecan(*node, true);
    add_dronecan(*node, false);
    bus[3]->hub.add(std::move(node));
    configure();
    specs.buses = {
        table("can0", "udp", {{"address", std::int64_t{0}}}), table("can1", "udp", {{"address", std::int64_t{1}}}),
        table("can2", "udp", {{"address", std::int64_t{2}}}), table("can3", "udp", {{"address", std::int64_t{3}}})};
    DeviceSpec group = table("body", "can_servos", {});
    const std::map<std::string, rt::ParamValue> gains = {{"kp", 60.0}, {"kd", 2.0}};
    auto mit = [&](const char* motor) {
      auto keys = gains;
      keys["motor"] = std::string(motor);
      return keys;
    };
    group.joints = {
        joint("hip", "cia402", 0, 1, {{"counts_per_turn", 65536.0}}),
        joint("knee", "mit", 1, 2, mit("ak80_9")),
        joint("foot", "mit", 1, 3, mit("dm4310")),
        joint("neck", "cybergear", 2, 4, gains),
        joint("rotor", "dronecan", 3, 30,
              {{"esc", true},
               {"esc_full_radps", 100.0},
               {"actuator_id", std::int64_t{2}},
               {"mode", std::string("velocity")}}),
        joint("flap", "dronecan", 3, 31, {{"actuator_id", std::int64_t{7}}, {"on_stop", std::string("hold")}})};
    specs.devices.push_back(group);
  }
  bool all_live() const {
    return std::all_of(motors.begin(), motors.end(), [](const auto* m) { return m->live(); });
  }
  bool none_live() const {
    return std::none_of(motors.begin(), motors.end(), [](const auto* m) { return m->live(); });
  }
  /// Until every drive has torque, by commands, as in a run.
  bool come_alive() {
    for (std::size_t i = 0; i < motors.size(); ++i) setpoint[i] = 0.4;
    for (const Time end = os.now() + 10s; os.now() < end && !all_live();) run(10ms);
    return all_live();
  }
  /// The runtime is dead: only drives live on.
  void pass(Duration d) {
    for (const Time end = os.now() + d; os.now() < end;) {
      os.clock.set(os.now() + 500us);
      for (auto& b : bus) b->sims.poll(os.now());
    }
  }

  DeviceSpecs specs;
  std::vector<sim_hil::SimServo*> motors;
  sim_hil::SimCia402* drive = nullptr;

 private:
  void add_dronecan(DronecanNode& node, bool esc) {
    ServoConfig c;
    c.name = esc ? "rotor" : "flap", c.node_id = esc ? 30 : 31, c.actuator_id = esc ? 2 : 7;
    c.mode = esc ? ServoMode::velocity : ServoMode::position;
    c.stop = esc ? StopAction::torque_off : StopAction::hold;
    c.limits = {-3, 3, 10, 20};
    const DronecanServoOptions options{.esc = esc, .esc_full_radps = esc ? 100.0 : 0.0, .status_hz = 100};
    ASSERT_EQ(to_string(check_dronecan(c, options)), "");
    ASSERT_TRUE(group().add(bus[3]->hub, std::make_unique<DronecanServo>(c, options, node)));
    sim_hil::SimDronecanServo::Parameters p;
    p.node_id = static_cast<std::uint8_t>(c.node_id), p.actuator_id = static_cast<std::uint8_t>(c.actuator_id);
    p.esc = esc, p.timeout = 10s;  // this is not about its own time-out
    joints.push_back(std::make_unique<sim_hil::JointModel>());
    motors.push_back(&bus[3]->sims.add<sim_hil::SimDronecanServo>(*joints.back(), sim_hil::SimMount{}, p));
  }
};

/// The parent's side: it sleeps, and the robot's time goes on.
class ParentOs final : public hal::Os {
 public:
  explicit ParentOs(Robot& robot) : robot_(robot) {}
  Time now() const noexcept override { return robot_.os.now(); }
  void sleep_until(Time t) noexcept override {
    const rt::trap::Scope off(nullptr);
    if (t <= now()) return;
    if (runtime_lives)
      robot_.run(t - now());
    else
      robot_.pass(t - now());
  }
  void wait(hal::WakeWord&, std::uint32_t, Time deadline) noexcept override { sleep_until(deadline); }
  void wake(hal::WakeWord&) noexcept override {}
  Duration thread_cpu_time() noexcept override { return {}; }
  hal::Result<std::unique_ptr<hal::Thread>> start_thread(const hal::ThreadOptions&, std::function<void()>) override {
    return hal::Error{hal::Errc::not_supported, "no threads here"};
  }
  hal::Result<std::unique_ptr<hal::SharedMemory>> shared_memory(std::string_view, std::size_t) override {
    return hal::Error{hal::Errc::not_supported, "no memory here"};
  }
  hal::Status lock_memory() override { return {}; }
  bool runtime_lives = false;

 private:
  Robot& robot_;
};

/// The address of a bus is its number.
class Plugs final : public test::NoConnectors {
 public:
  explicit Plugs(Robot& robot) : robot_(robot) {}
  hal::Result<std::unique_ptr<hal::CanBus>> can(const hal::CanSpec& spec, std::string& why) override {
    if (spec.address == missing) return test::NoConnectors::can(spec, why);
    ++opened;
    auto& wire = robot_.bus[static_cast<std::size_t>(std::stoi(spec.address))]->wire;
    return std::unique_ptr<hal::CanBus>(std::make_unique<Untrapped>(wire.attach()));
  }
  std::string missing = "none";
  int opened = 0;

 private:
  Robot& robot_;
};

class CanStopLineTest : public testing::Test {
 protected:
  std::unique_ptr<CanStopLine> open() {
    const std::vector<std::string> groups = {"body"};
    return CanStopLine::open(robot.specs, groups, plugs, os, why);
  }
  /// As the parent: whatever allocates, locks or blocks in there ends the test.
  static hal::Status stop(CanStopLine& line) {
    const rt::trap::Scope trap("stop line");
    return line.stop();
  }
  Robot robot;
  ParentOs os{robot};
  Plugs plugs{robot};
  std::string why;
};

TEST_F(CanStopLineTest, JointsOfEveryProtocolAreWithoutTorqueAndSaySo) {
  const auto line = open();
  ASSERT_TRUE(line) << why;
  EXPECT_EQ(line->joints(), 6u);
  EXPECT_EQ(plugs.opened, 4) << "each bus once";
  EXPECT_FALSE(line->is_latching());
  ASSERT_TRUE(robot.come_alive());
  const Time before = os.now();
  const hal::Status stopped = stop(*line);
  EXPECT_TRUE(stopped) << line->last_report();
  EXPECT_TRUE(robot.none_live());
  EXPECT_LT(os.now() - before, CanStopLine::kPatience);
  EXPECT_EQ(line->last_report(), "6 of 6 joints are without torque");
  robot.pass(1s);
  EXPECT_TRUE(robot.none_live());
}

TEST_F(CanStopLineTest, DriveIsStoppedInWhateverStateItIs) {
  const auto line = open();
  ASSERT_TRUE(line);
  EXPECT_TRUE(stop(*line)) << "before anything was configured: " << line->last_report();
  ASSERT_TRUE(robot.come_alive());
  robot.drive->fail(0x4310);
  EXPECT_TRUE(stop(*line)) << "in a fault: " << line->last_report();
  EXPECT_TRUE(robot.none_live());
}

TEST_F(CanStopLineTest, JointThatDoesNotAnswerIsNamedAndStoppedAllTheSame) {
  const auto line = open();
  ASSERT_TRUE(robot.come_alive());
  robot.motors[0]->faults.silent = true;
  const hal::Status stopped = stop(*line);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, hal::Errc::timeout);
  EXPECT_EQ(stopped.error().detail, 1);
  EXPECT_EQ(line->last_report(), "5 of 6 joints are without torque; joint 'hip' (can0) did not answer");
  EXPECT_TRUE(robot.none_live()) << "it heard";
}

TEST_F(CanStopLineTest, WhatADriveSaidBeforeIsNoAnswer) {
  const auto line = open();
  ASSERT_TRUE(line);
  robot.run(2s, false);  // the drive says many times that it has no torque; nobody reads the line's queue
  robot.drive->power(false);
  EXPECT_FALSE(stop(*line));
  EXPECT_THAT(line->last_report(), HasSubstr("joint 'hip' (can0) did not answer"));
}

TEST_F(CanStopLineTest, DriveThatIgnoresItsControlwordIsStoppedByNmt) {
  const auto line = open();
  ASSERT_TRUE(robot.come_alive());
  robot.drive->deaf = true;
  auto& ear = robot.bus[0]->wire.attach();
  EXPECT_TRUE(stop(*line)) << "6007h, with NMT stopped: " << line->last_report();
  EXPECT_TRUE(robot.none_live());
  int nmt_stops = 0;
  for (msg::CanFrame frame; *ear.read(frame);) {
    const auto nmt = wire::decode_nmt(frame);
    if (nmt && nmt->command == wire::NmtCommand::stop && nmt->node == 1) ++nmt_stops;
  }
  EXPECT_EQ(nmt_stops, 1) << "for those only that do not obey";
}

TEST_F(CanStopLineTest, BusThatIsGoneIsNamedAndTheOthersAreStopped) {
  const auto line = open();
  ASSERT_TRUE(robot.come_alive());
  robot.bus[2]->wire.connect(false);
  const hal::Status stopped = stop(*line);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, hal::Errc::timeout);
  EXPECT_THAT(line->last_report(), HasSubstr("5 of 6 joints are without torque; bus 'can2' takes no frame (closed)"));
  EXPECT_THAT(line->last_report(), HasSubstr("joint 'neck' (can2) did not answer"));
  for (std::size_t i = 0; i < robot.motors.size(); ++i) EXPECT_EQ(robot.motors[i]->live(), i == 3) << i;
  robot.bus[2]->wire.connect(true);
  EXPECT_TRUE(stop(*line)) << "and again when it is back: " << line->last_report();
  EXPECT_TRUE(robot.none_live());
}

TEST_F(CanStopLineTest, WithoutAnyBusItSaysClosed) {
  const auto line = open();
  for (auto& bus : robot.bus) bus->wire.connect(false);
  const hal::Status stopped = stop(*line);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, hal::Errc::closed);
}

TEST_F(CanStopLineTest, RuntimeThatStillSendsUndoesItUntilItIsDead) {
  const auto line = open();
  ASSERT_TRUE(robot.come_alive());
  os.runtime_lives = true;
  (void)stop(*line);
  robot.run(5s);
  EXPECT_FALSE(robot.none_live()) << "this is why it does not last";
  (void)stop(*line);
  os.runtime_lives = false;
  EXPECT_TRUE(stop(*line)) << line->last_report();
  EXPECT_TRUE(robot.none_live());
}

TEST_F(CanStopLineTest, QueueIsKeptEmptyAndNothingIsSentWhileAllIsWell) {
  const auto line = open();
  ASSERT_TRUE(robot.come_alive());
  for (int i = 0; i < 400; ++i) {
    robot.run(5ms);
    const rt::trap::Scope trap("tend");
    line->poll();
  }
  EXPECT_TRUE(robot.all_live());
  EXPECT_TRUE(stop(*line)) << line->last_report();
}

TEST_F(CanStopLineTest, BusThatCannotBeOpenedIsSaidAndTheOthersHaveTheirLine) {
  plugs.missing = "1";
  const auto line = open();
  ASSERT_TRUE(line);
  EXPECT_EQ(line->joints(), 4u);
  EXPECT_EQ(why, "bus 'can1': /dev/nothing: no such file");
}

TEST_F(CanStopLineTest, GroupsThatAreNotNamedHaveNone) {
  const std::vector<std::string> groups = {"tail"};
  EXPECT_FALSE(CanStopLine::open(robot.specs, groups, plugs, os, why));
  EXPECT_EQ(plugs.opened, 0);
}

}  // namespace
}  // namespace sinew::drivers::can_stop_line_test
