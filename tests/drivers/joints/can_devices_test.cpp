// Joints as a robot file describes them, on a bus in memory with simulated drives behind it.
#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "../no_connectors.hpp"
#include "drivers/board/driver_list.hpp"
#include "drivers/joints/can_servos.hpp"
#include "hal/platform.hpp"
#include "sim_hil/wire/memory_can.hpp"
#include "sim_hil/wire/sim_cia402.hpp"
#include "sim_hil/wire/sim_impedance.hpp"

namespace sinew::drivers::can_devices_test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Every bus is in memory; a caller that opens one gets a port.
class MemoryConnectors final : public test::NoConnectors {
 public:
  hal::Result<std::unique_ptr<hal::CanBus>> can(const hal::CanSpec& spec, std::string&) override {
    opened = spec;
    return std::unique_ptr<hal::CanBus>(std::make_unique<Port>(wire.attach()));
  }
  sim_hil::MemoryCan wire{1'000'000, &hal::system_os()};
  hal::CanSpec opened;

 private:
  class Port final : public hal::CanBus {
   public:
    explicit Port(hal::CanBus& port) : port_(port) {}
    hal::Result<bool> read(msg::CanFrame& out) noexcept override { return port_.read(out); }
    hal::Status send(const msg::CanFrame& f, hal::Time deadline) noexcept override { return port_.send(f, deadline); }
    hal::Status set_filters(std::span<const hal::CanFilter> f) override { return port_.set_filters(f); }
    void set_wake(hal::Wake* wake) noexcept override { port_.set_wake(wake); }
    hal::CanStats stats() const noexcept override { return port_.stats(); }
    std::uint32_t bit_rate() const noexcept override { return port_.bit_rate(); }

   private:
    hal::CanBus& port_;
  };
};

DeviceSpec table(const std::string& name, const std::string& driver, int line,
                 std::map<std::string, rt::ParamValue> keys) {
  DeviceSpec spec;
  spec.name = name, spec.driver = driver, spec.line = line;
  for (auto& [key, value] : keys) spec.keys[key] = {value, line};
  return spec;
}

DeviceSpecs head() {
  DeviceSpecs specs;
  specs.buses.push_back(
      table("can0", "udp", 1,
            {{"address", std::string("7")}, {"tick_hz", std::int64_t{200}}, {"priority", std::int64_t{0}}}));
  DeviceSpec group = table("head", "can_servos", 3, {});
  group.joints.push_back(table("pan", "cia402", 5,
                               {{"bus", std::string("can0")},
                                {"id", std::int64_t{1}},
                                {"counts_per_turn", std::int64_t{65536}},
                                {"max_velocity_radps", 20.0},
                                {"rated_effort_nm", 2.0},
                                {"zero_rad", 0.25}}));
  group.joints.push_back(table("tilt", "mit", 9,
                               {{"bus", std::string("can0")},
                                {"id", std::int64_t{2}},
                                {"motor", std::string("ak80_9")},
                                {"kp", 40.0},
                                {"kd", 2.0},
                                {"max_velocity_radps", 20.0}}));
  specs.devices.push_back(group);
  specs.devices.push_back(table("joints", "joints_of", 12, {{"group", std::string("head")}}));
  return specs;
}

std::vector<std::string> texts(const DeviceSpecs& specs) {
  std::vector<std::string> out;
  for (const auto& p : check_devices(specs, all_drivers())) out.push_back(rt::to_string(p, "r.toml"));
  return out;
}

TEST(CanDevices, RobotFileMakesJointsThatFollow) {
  const DeviceSpecs specs = head();
  ASSERT_THAT(texts(specs), IsEmpty());
  MemoryConnectors connectors;
  sim_hil::SimServos sims(connectors.wire.attach());
  sim_hil::JointModel pan, tilt;
  sim_hil::SimMount mount;
  mount.zero_rad = 0.25;
  sims.add<sim_hil::SimCia402>(pan, mount, sim_hil::SimCia402::Parameters());
  sims.add<sim_hil::SimMitMotor>(
      tilt, {}, sim_hil::SimMitMotor::Parameters{.motor = 2, .master = 0, .type = *wire::mit_motor_type("ak80_9")});
  std::atomic<bool> stop{false};
  std::thread world([&] {
    while (!stop) {
      sims.poll(hal::system_os().now());
      hal::system_os().sleep_until(hal::system_os().now() + 1ms);
    }
  });
  {
    DeviceBoard board(specs, all_drivers(), connectors, hal::system_os());
    auto actuators = board.actuators("head");
    auto joints = board.sensor<msg::JointState>("joints");
    ASSERT_TRUE(actuators) << board.problem();
    ASSERT_TRUE(joints) << board.problem();
    EXPECT_EQ(connectors.opened.transport, "udp");
    EXPECT_EQ(connectors.opened.address, "7");
    ASSERT_TRUE(board.start()) << board.problem();
    msg::ActuatorCommand command;
    command.count = 2, command.armed = 1;
    command.value[0] = 0.5, command.value[1] = -0.4;
    msg::JointState state;
    const hal::Time deadline = hal::system_os().now() + 20s;
    const auto near = [&] {
      return std::abs(state.position_rad[0] - 0.5) < 0.02 && std::abs(state.position_rad[1] + 0.4) < 0.02;
    };
    while (!(state.ready == 3 && near()) && hal::system_os().now() < deadline) {
      ASSERT_TRUE((*actuators)->write(command, 500ms));
      hal::system_os().sleep_until(hal::system_os().now() + 5ms);
      while (true) {
        const auto got = (*joints)->read(state);
        if (!got || !*got) break;
      }
    }
    EXPECT_EQ(state.count, 2u);
    EXPECT_EQ(state.ready, 3u);
    EXPECT_NEAR(state.position_rad[0], 0.5, 0.02);
    EXPECT_NEAR(state.position_rad[1], -0.4, 0.02);
  }
  stop = true;
  world.join();
}

TEST(CanDevices, EveryWrongKeyIsNamed) {
  DeviceSpecs specs = head();
  specs.buses[0].keys["bit_rate"] = {rt::ParamValue{std::int64_t{1}}, 2};
  specs.devices[0].joints[0].keys["bus"] = {rt::ParamValue{std::string("can9")}, 6};
  specs.devices[0].joints[0].keys["colour"] = {rt::ParamValue{std::string("red")}, 7};
  specs.devices[0].joints[1].driver = "servo";
  specs.devices[1].keys["group"] = {rt::ParamValue{std::string("legs")}, 13};
  EXPECT_THAT(texts(specs),
              ElementsAre(HasSubstr("r.toml:2: bus.can0.bit_rate: 1: one of 10000, 20000, 33333, 50000, 83333, 100000, "
                                    "125000, 250000, 500000, 800000, 1000000"),
                          HasSubstr("r.toml:6: device.head.joint.pan.bus: \"can9\": the name of a [bus.NAME]: can0"),
                          HasSubstr("r.toml:7: device.head.joint.pan.colour: \"red\": one of"),
                          HasSubstr("r.toml:9: device.head.joint.tilt.driver: \"servo\": one of"),
                          HasSubstr("r.toml:13: device.joints.group: \"legs\"")));
}

TEST(CanDevices, FollowingIsWatchedAsTheRobotFileSays) {
  DeviceSpecs specs = head();
  specs.devices[0].joints[0].keys["following_error_rad"] = {rt::ParamValue{0.1}, 7};
  specs.devices[0].joints[0].keys["following_time_ms"] = {rt::ParamValue{200.0}, 8};
  EXPECT_THAT(texts(specs), IsEmpty());
  std::vector<rt::Problem> problems;
  DeviceKeys keys(specs.devices[0].joints[0], "joint", problems);
  const JointConfig joint = read_joint(keys, specs);
  EXPECT_EQ(joint.servo.following.position_rad, 0.1);
  EXPECT_EQ(joint.servo.following.time, hal::Duration{200ms});
}

TEST(CanDevices, TimeOutsLeaveRoomForWhatIsLate) {
  DeviceSpecs specs = head();
  specs.buses[0].keys["tick_hz"] = {rt::ParamValue{std::int64_t{25}}, 2};
  EXPECT_THAT(
      texts(specs),
      ElementsAre("r.toml:5: device.head.joint.pan.feedback_timeout_ms: default 50: at least 100, as its answers come "
                  "every 40 ms (the bus's tick_hz)",
                  "r.toml:9: device.head.joint.tilt.feedback_timeout_ms: default 50: at least 100, as its answers come "
                  "every 40 ms (the bus's tick_hz)"));
  specs = head();
  specs.devices[0].joints[0].keys["device_timeout_ms"] = {rt::ParamValue{30.0}, 7};
  EXPECT_THAT(texts(specs), IsEmpty());
  specs.buses[0].keys["master_heartbeat_ms"] = {rt::ParamValue{20.0}, 2};
  EXPECT_THAT(texts(specs),
              ElementsAre("r.toml:7: device.head.joint.pan.device_timeout_ms: 30: 0 (as the drive is set) or at least "
                          "60, as our signs of life come every 20 ms (the bus's master_heartbeat_ms)"));
}

TEST(CanDevices, DronecanJointsHaveTheirPlaceAndAnswerOftenEnough) {
  DeviceSpecs specs = head();
  DeviceSpec& joint = specs.devices[0].joints[0];
  joint = table("pan", "dronecan", 5,
                {{"bus", std::string("can0")}, {"id", std::int64_t{20}}, {"on_stop", std::string("hold")}});
  EXPECT_THAT(texts(specs), ElementsAre(HasSubstr("device.head.joint.pan.actuator_id")));
  joint.keys["actuator_id"] = {rt::ParamValue{std::int64_t{0}}, 6};
  EXPECT_THAT(texts(specs), IsEmpty());
  joint.keys["status_hz"] = {rt::ParamValue{10.0}, 7};
  EXPECT_THAT(
      texts(specs),
      ElementsAre("r.toml:5: device.head.joint.pan.feedback_timeout_ms: default 50: at least 250, as its answers "
                  "come every 100 ms (status_hz)"));
  joint.keys["feedback_timeout_ms"] = {rt::ParamValue{250.0}, 8};
  EXPECT_THAT(texts(specs), IsEmpty());
}

TEST(CanDevices, WhyABusCannotBeOpenedIsSaidOnceWhoeverAsksFirst) {
  for (const bool joints_first : {false, true}) {
    test::NoConnectors connectors;
    DeviceBoard board(head(), all_drivers(), connectors, hal::system_os());
    if (joints_first) static_cast<void>(board.sensor<msg::JointState>("joints"));
    EXPECT_FALSE(board.actuators("head"));
    EXPECT_FALSE(board.sensor<msg::JointState>("joints"));
    EXPECT_EQ(board.problem(),
              "device 'head' (driver can_servos): bus 'can0': /dev/nothing: no such file\n"
              "device 'joints' (driver joints_of): device 'head' is not there");
  }
}

TEST(CanDevices, BusThatCannotCarryItsJointsDoesNotStart) {
  DeviceSpecs specs = head();
  specs.buses[0].keys["bit_rate"] = {rt::ParamValue{std::int64_t{125'000}}, 2};
  specs.buses[0].keys["tick_hz"] = {rt::ParamValue{std::int64_t{1000}}, 2};
  class SlowWire final : public test::NoConnectors {
   public:
    hal::Result<std::unique_ptr<hal::CanBus>> can(const hal::CanSpec& spec, std::string&) override {
      wire = std::make_unique<sim_hil::MemoryCan>(spec.bit_rate, &hal::system_os());
      return std::unique_ptr<hal::CanBus>(std::make_unique<sim_hil::MemoryCanPort>(*wire));
    }
    std::unique_ptr<sim_hil::MemoryCan> wire;
  } connectors;
  DeviceBoard board(specs, all_drivers(), connectors, hal::system_os());
  ASSERT_TRUE(board.actuators("head")) << board.problem();
  const hal::Status started = board.start();
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().code, hal::Errc::bad_argument);
  const auto checked = texts(specs);
  ASSERT_EQ(checked.size(), 1u);
  const auto load = checked[0].find("2 servos at 1000 Hz need ");
  ASSERT_NE(load, std::string::npos) << checked[0];
  EXPECT_EQ(checked[0].substr(0, load), "r.toml:1: bus.can0.max_load_percent: 90: ");
  EXPECT_EQ(board.problem(), "bus 'can0': max_load_percent: 90: " + checked[0].substr(load)) << "by the same function";
}

}  // namespace
}  // namespace sinew::drivers::can_devices_test
