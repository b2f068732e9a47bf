// DroneCAN joints as a robot file describes them: device board, hub and its thread, frames over UDP, and simulated
// nodes with a bus of their own at the far end.
#include <gmock/gmock.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <mutex>
#include <thread>

#include "drivers/board/device_board.hpp"
#include "drivers/board/driver_list.hpp"
#include "hal/linux/devices/connectors.hpp"
#include "hal/platform.hpp"
#include "qemu_user.hpp"
#include "sim_hil/wire/sim_dronecan.hpp"

namespace sinew::drivers::dronecan_devices_test {
namespace {

using namespace std::chrono_literals;
using msg::JointMode;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

DeviceSpec table(const std::string& name, const std::string& driver, std::map<std::string, rt::ParamValue> keys) {
  DeviceSpec spec;
  spec.name = name, spec.driver = driver, spec.line = 1;
  for (auto& [key, value] : keys) spec.keys[key] = {value, 1};
  return spec;
}

using Keys = std::map<std::string, rt::ParamValue>;

DeviceSpec joint(const std::string& name, std::int64_t node, std::int64_t index, Keys more) {
  Keys keys = {{"bus", std::string("can0")},
               {"id", node},
               {"actuator_id", index},
               {"max_velocity_radps", 20.0},
               {"feedback_timeout_ms", std::int64_t{2000}},
               {"status_hz", 50.0}};
  keys.merge(more);
  return table(name, "dronecan", keys);
}

const Keys kHolds = {{"on_stop", std::string("hold")}};
const Keys kEsc = {{"esc", true},
                   {"mode", std::string("velocity")},
                   {"esc_full_radps", 100.0},
                   {"derate_start_c", 60.0},
                   {"derate_end_c", 80.0}};

std::string address() { return std::to_string(20 + ::getpid() % 200); }

DeviceSpecs head() {
  DeviceSpecs specs;
  specs.buses.push_back(table("can0", "udp",
                              {{"address", address()},
                               {"tick_hz", std::int64_t{100}},
                               {"priority", std::int64_t{0}},
                               {"dronecan_node", std::int64_t{11}}}));
  DeviceSpec group = table("head", "can_servos", {});
  Keys asks = kHolds;
  asks["unique_id"] = std::string("000102030405060708090A0B0C0D0E0F");
  group.joints = {joint("pan", 20, 0, kHolds), joint("tilt", 21, 1, kHolds), joint("left", 30, 0, kEsc),
                  joint("right", 31, 1, kEsc), joint("late", 50, 2, asks)};
  specs.devices.push_back(group);
  return specs;
}

/// Nodes on a thread of their own; a test changes them in at().
class Nodes {
 public:
  explicit Nodes(std::unique_ptr<hal::CanBus> bus) : bus_(std::move(bus)), sims_(*bus_) {
    add(20, 0, false), add(21, 1, false), add(30, 0, true), add(31, 1, true);
    for (std::uint8_t i = 0; i < 16; ++i) id_[i] = i;
    add(0, 2, false);
    thread_ = std::thread([this] {
      while (!stop_) {
        {
          const std::lock_guard lock(mutex_);
          sims_.poll(hal::system_os().now());
        }
        hal::system_os().sleep_until(hal::system_os().now() + 1ms);
      }
    });
  }
  ~Nodes() {
    stop_ = true;
    thread_.join();
  }
  template <class Do>
  auto at(std::size_t i, Do&& what) {
    const std::lock_guard lock(mutex_);
    return what(*servos_[i]);
  }

 private:
  void add(std::uint8_t node, std::uint8_t index, bool esc) {
    sim_hil::SimDronecanServo::Parameters p;
    p.node_id = node, p.actuator_id = index, p.esc = esc, p.timeout = 2s, p.unique_id = id_;
    joints_.push_back(std::make_unique<sim_hil::JointModel>(
        sim_hil::JointModel::Parameters{.min_rad = -1e6, .max_rad = 1e6}));  // rotors turn on
    servos_.push_back(&sims_.add<sim_hil::SimDronecanServo>(*joints_.back(), sim_hil::SimMount{}, p));
  }
  std::unique_ptr<hal::CanBus> bus_;
  sim_hil::SimServos sims_;
  wire::DronecanUniqueId id_{};
  std::vector<std::unique_ptr<sim_hil::JointModel>> joints_;
  std::vector<sim_hil::SimDronecanServo*> servos_;
  std::mutex mutex_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

class DronecanDevices : public testing::Test {
 protected:
  void SetUp() override {
    SINEW_SKIP_UNDER_QEMU_USER("IP_MULTICAST_ALL");
    std::string why;
    auto opened = hal::LinuxConnectors::open(hal::system_os(), why);
    ASSERT_TRUE(opened) << why;
    connectors = std::move(*opened);
    hal::CanSpec spec{"udp", address()};
    auto far = connectors->can(spec, why);
    auto third = connectors->can(spec, why);
    ASSERT_TRUE(far && third) << why;
    nodes = std::make_unique<Nodes>(std::move(*far));
    ear = std::move(*third);
    specs = head();
    for (const auto& p : check_devices(specs, all_drivers())) ADD_FAILURE() << rt::to_string(p, "r.toml");
    board = std::make_unique<DeviceBoard>(specs, all_drivers(), *connectors, hal::system_os());
    auto group = board->actuators("head");
    auto sensor = board->sensor<msg::JointState>("head");
    ASSERT_TRUE(group && sensor) << board->problem();
    actuators = *group, joints = *sensor;
    ASSERT_TRUE(board->start()) << board->problem();
    for (std::size_t i : {0u, 1u, 4u}) command.value[i] = 0.4;
    for (std::size_t i : {2u, 3u}) command.value[i] = 15;
    command.count = 5, command.armed = 1;
  }
  void TearDown() override {
    board.reset();
    nodes.reset();
  }
  /// Commands until it holds, at most 30 s.
  bool until(const std::function<bool()>& holds) {
    for (const hal::Time end = hal::system_os().now() + 30s; hal::system_os().now() < end;) {
      EXPECT_TRUE(actuators->write(command, 5s));
      hal::system_os().sleep_until(hal::system_os().now() + 5ms);
      for (auto got = joints->read(state); got && *got; got = joints->read(state)) {
      }
      if (holds()) return true;
    }
    return false;
  }
  bool all_follow() {
    const auto near = [this](std::size_t i) { return std::abs(state.position_rad[i] - command.value[i]) < 0.05; };
    const auto turns = [this](std::size_t i) { return std::abs(state.velocity_radps[i] - command.value[i]) < 2; };
    return state.ready == 31 && near(0) && near(1) && turns(2) && turns(3) && near(4);
  }

  std::string told() const {
    std::string all;
    for (std::size_t i = 0; i < 5; ++i)
      all += std::to_string(i) + ": at " + std::to_string(state.position_rad[i]) + ", " +
             std::to_string(state.velocity_radps[i]) + ", mode " + std::to_string(static_cast<int>(state.mode[i])) +
             ", faults " + std::to_string(state.faults[i]) + ", code " + std::to_string(state.fault_code[i]) + "\n";
    return all;
  }

  std::unique_ptr<hal::Connectors> connectors;
  std::unique_ptr<Nodes> nodes;
  std::unique_ptr<hal::CanBus> ear;
  DeviceSpecs specs;
  std::unique_ptr<DeviceBoard> board;
  hal::Actuators* actuators = nullptr;
  hal::Joints* joints = nullptr;
  msg::ActuatorCommand command;
  msg::JointState state;
};

TEST_F(DronecanDevices, ActuatorsEscsAndANodeWithoutAnIdFollowTheirCommands) {
  ASSERT_TRUE(until([this] { return all_follow(); }));
  EXPECT_EQ(nodes->at(4, [](auto& s) { return s.node_id(); }), 50) << "given to it by the robot file";
  EXPECT_TRUE(std::isnan(state.position_rad[2])) << "an ESC measures none";
  EXPECT_NEAR(state.temperature_c[2], 25, 0.2);
  EXPECT_NEAR(state.voltage_v[3], 24, 0.1);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(state.faults[i], 0u) << i;
  int followed = 0;  // and they stay there
  ASSERT_TRUE(until([&] { return all_follow() && ++followed == 200; })) << told();
  EXPECT_NEAR(state.velocity_radps[0], 0, 0.1);
}

TEST_F(DronecanDevices, BothEscsAndAllActuatorsShareOneTransferATick) {
  ASSERT_TRUE(until([this] { return all_follow(); }));
  const std::array<wire::DronecanWanted, 2> kinds = {wire::kDronecanEscRawCommand, wire::kDronecanActuatorCommand};
  wire::DronecanAssembler assembler(kinds, 4);
  msg::CanFrame frame;
  while (*ear->read(frame)) {  // what was before all of them were there
  }
  int raw = 0, arrays = 0;
  ASSERT_TRUE(until([&] {
    wire::DronecanTransfer transfer;
    for (auto got = ear->read(frame); got && *got; got = ear->read(frame)) {
      if (assembler.push(frame, frame.stamp, 99, transfer) != wire::DronecanAssembler::Heard::complete) continue;
      EXPECT_EQ(transfer.id.source, 11) << "dronecan_node";
      if (transfer.id.type == wire::kDronecanEscRawCommand.type) {
        wire::DronecanEscRawCommand command_of;
        EXPECT_TRUE(decode(transfer.payload, command_of));
        EXPECT_EQ(command_of.count, 2);
        EXPECT_GT(command_of.command[0], 0);
        EXPECT_GT(command_of.command[1], 0);
        ++raw;
      } else {
        wire::DronecanActuatorCommand command_of;
        EXPECT_TRUE(decode(transfer.payload, command_of));
        EXPECT_EQ(command_of.count, 3);
        ++arrays;
      }
    }
    return raw >= 20 && arrays >= 20;
  }));
  EXPECT_LE(std::abs(raw - arrays), 2) << "one of each a tick";
}

TEST_F(DronecanDevices, BrokenNodeLeavesTheOthersAloneAndComesBack) {
  ASSERT_TRUE(until([this] { return all_follow(); }));
  nodes->at(1, [](auto& s) { s.fail(0x77); });
  nodes->at(3, [](auto& s) { s.power(false); });
  ASSERT_TRUE(until([this] { return state.mode[1] == JointMode::fault && state.mode[3] == JointMode::absent; }));
  EXPECT_EQ(state.fault_code[1], 0x77u);
  EXPECT_NE(state.faults[3] & msg::kJointLost, 0u);
  EXPECT_EQ(state.ready, 0b10101u);
  command.value[0] = -0.2;
  EXPECT_TRUE(until([this] { return std::abs(state.position_rad[0] + 0.2) < 0.05; })) << "the others go on";
  nodes->at(1, [](auto& s) { s.power(false); });
  ASSERT_TRUE(until([this] { return state.mode[1] == JointMode::absent; }));
  nodes->at(1, [](auto& s) { s.power(true); });
  nodes->at(3, [](auto& s) { s.power(true); });
  EXPECT_TRUE(until([this] { return all_follow(); })) << told();
}

TEST_F(DronecanDevices, HotEscIsDeratedAndSaysSo) {
  ASSERT_TRUE(until([this] { return all_follow(); }));
  nodes->at(2, [](auto& s) { s.temperature_c = 70; });
  EXPECT_TRUE(until([this] {
    return (state.faults[2] & msg::kJointDerated) != 0 && std::abs(state.velocity_radps[2] - 10) < 1;
  })) << "half way between: half of max_velocity_radps";
  EXPECT_NEAR(state.velocity_radps[3], 15, 2) << "the other is not";
  EXPECT_EQ(state.mode[2], JointMode::enabled);
}

TEST_F(DronecanDevices, WhenCommandsEndTheBusIsDisarmed) {
  ASSERT_TRUE(until([this] { return all_follow(); }));
  ASSERT_TRUE(actuators->stop());
  const hal::Time end = hal::system_os().now() + 30s;
  const auto any_live = [this] {
    bool live = false;
    for (std::size_t i = 0; i < 5; ++i) live = nodes->at(i, [](auto& s) { return s.live(); }) || live;
    return live;
  };
  while (any_live() && hal::system_os().now() < end) hal::system_os().sleep_until(hal::system_os().now() + 1ms);
  EXPECT_FALSE(any_live());
}

TEST(DronecanKeys, WrongOnesAreNamed) {
  DeviceSpecs specs = head();
  specs.devices[0].joints[4].keys["unique_id"] = {rt::ParamValue{std::string("0102")}, 7};
  specs.devices[0].joints[2].keys["mode"] = {rt::ParamValue{std::string("position")}, 8};
  std::string all;
  for (const auto& p : check_devices(specs, all_drivers())) all += rt::to_string(p, "r.toml") + "\n";
  EXPECT_THAT(all, HasSubstr("r.toml:7: device.head.joint.late.unique_id: \"0102\": 32 hexadecimal digits"));
  EXPECT_THAT(all, HasSubstr("r.toml:8: device.head.joint.left.mode: \"position\": \"velocity\"; an ESC has no other"));
}

}  // namespace
}  // namespace sinew::drivers::dronecan_devices_test
