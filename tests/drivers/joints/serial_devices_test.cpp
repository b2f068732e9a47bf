// Serial servos by the keys of a robot file: what is refused, and a group over a pseudo terminal in real time.
#include <gmock/gmock.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "drivers/board/driver_list.hpp"
#include "drivers/joints/bus_check.hpp"
#include "hal/linux/devices/connectors.hpp"
#include "hal/linux/devices/serial.hpp"
#include "hal/linux/temporary_folder.hpp"
#include "hal/platform.hpp"
#include "sim_hil/wire/sim_serial_servo.hpp"

namespace sinew::drivers::serial_devices_test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

rt::Located<rt::ParamValue> at(rt::ParamValue value, int line = 0) { return {std::move(value), line}; }

DeviceSpec table(const std::string& name, const std::string& driver, int line = 0) {
  DeviceSpec spec;
  spec.name = name, spec.driver = driver, spec.line = line;
  return spec;
}

DeviceSpec servo(const std::string& name, int id, const std::string& model = "xm430_w350") {
  DeviceSpec joint = table(name, model.starts_with("s") ? "feetech" : "dynamixel");
  joint.keys["bus"] = at(std::string("legs"));
  joint.keys["id"] = at(std::int64_t{id}, 100 + id);
  joint.keys["model"] = at(model, 200 + id);
  joint.keys["min_rad"] = at(-2.4), joint.keys["max_rad"] = at(2.4);
  joint.keys["max_velocity_radps"] = at(4.0);
  return joint;
}

DeviceSpecs legs(const std::string& path, int servos, double tick_hz = 100) {
  DeviceSpecs specs;
  specs.buses.push_back(table("legs", "serial", 1));
  specs.buses[0].keys["path"] = at(path, 2);
  specs.buses[0].keys["tick_hz"] = at(tick_hz, 3);
  for (int i = 0; i < servos; ++i) {
    if (i % 8 == 0) specs.devices.push_back(table("group" + std::to_string(i / 8), "serial_servos", 10));
    specs.devices.back().joints.push_back(servo("joint" + std::to_string(i + 1), i + 1));
  }
  return specs;
}

std::vector<std::string> texts(const DeviceSpecs& specs) {
  std::vector<std::string> out;
  for (const auto& p : check_devices(specs, all_drivers())) out.push_back(rt::to_string(p, "x.toml"));
  return out;
}

TEST(SerialDevices, TwentyServosAtAHundredHertzAreFine) { EXPECT_THAT(texts(legs("/dev/ttyUSB0", 20)), IsEmpty()); }

TEST(SerialDevices, ACycleThatTheLineCannotHoldIsRefusedWithItsSum) {
  EXPECT_THAT(
      texts(legs("/dev/ttyUSB0", 20, 150)),
      ElementsAre("x.toml:3: bus.legs.tick_hz: 150: 20 servos at 150 Hz need 8 of 6.67 ms: goals 1.14, answers "
                  "4.54, one slow register 0.32, the adapter 2: fewer servos on the line, a lower tick_hz, or a "
                  "higher bit_rate, or fast_read"));
}

TEST(SerialDevices, TheSumOfACycleThatFitsIsTold) {
  EXPECT_THAT(describe_buses(legs("/dev/ttyUSB0", 20)),
              ElementsAre("bus legs: 20 servos at 100 Hz need 8 of 10 ms: goals 1.14, answers 4.54, one slow register "
                          "0.32, the adapter 2"));
}

TEST(SerialDevices, WhatDoesNotFitTogetherIsNamed) {
  DeviceSpecs twice = legs("/dev/ttyUSB0", 2);
  twice.devices[0].joints[1].keys["id"] = at(std::int64_t{1}, 7);
  EXPECT_THAT(texts(twice), ElementsAre(HasSubstr("x.toml:7: device.group0.joint.joint2.id: 1: a number that no other "
                                                  "servo on its line has: 'joint1' has it (bus legs)")));
  DeviceSpecs both = legs("/dev/ttyUSB0", 1);
  both.devices[0].joints.push_back(servo("old", 5, "ax12"));
  EXPECT_THAT(texts(both),
              ElementsAre(HasSubstr("x.toml:205: device.group0.joint.old.model: ax12: one with the packets")));
  DeviceSpecs model = legs("/dev/ttyUSB0", 1);
  model.devices[0].joints[0].keys["model"] = at(std::string("sts3215"), 9);
  EXPECT_THAT(texts(model),
              ElementsAre(HasSubstr("x.toml:9: device.group0.joint.joint1.model: \"sts3215\": one of "
                                    "\"xm430_w350\", \"xm430_w210\", \"xl430_w250\", \"mx28\", \"ax12\"")));
  DeviceSpecs can = legs("/dev/ttyUSB0", 1);
  can.buses[0] = table("legs", "socketcan", 1);
  can.buses[0].keys["address"] = at(std::string("can0"));
  EXPECT_THAT(texts(can), testing::Contains(HasSubstr("joint1.bus: \"legs\": a [bus.NAME] with driver serial")));
  DeviceSpecs group = legs("/dev/ttyUSB0", 1);
  group.devices[0].driver = "can_servos";
  EXPECT_THAT(texts(group), ElementsAre(HasSubstr("a joint of can_servos is on a CAN bus")));
}

/// Two servos at the other end of a pseudo terminal, in real time.
class ServosOnATerminal {
 public:
  ServosOnATerminal() : pseudo_(std::move(*hal::make_pseudo_serial())), line_({}, hal::system_os()) {
    for (std::uint8_t id = 1; id <= 2; ++id) {
      sim_hil::SimSerialServo::Parameters p;
      p.id = id, p.model = wire::servo_model("xm430_w350"), p.return_delay = 0;
      servos_.push_back(std::make_unique<sim_hil::SimSerialServo>(line_, joints_[id - 1u], sim_hil::SimMount{}, p));
    }
    thread_ = std::thread([this] { run(); });
  }
  ~ServosOnATerminal() {
    ending_ = true;
    thread_.join();
  }
  const std::string& path() const { return pseudo_.path; }

 private:
  void run() {
    hal::Os& os = hal::system_os();
    std::array<std::uint8_t, 256> bytes;
    while (!ending_) {
      if (const auto n = pseudo_.end->read_now(bytes); n && *n > 0)
        static_cast<void>(line_.host().write_now({bytes.data(), *n}));
      line_.advance(os.now());
      if (const auto n = line_.host().read_now(bytes); n && *n > 0)
        static_cast<void>(pseudo_.end->write_now({bytes.data(), *n}));
      os.sleep_until(os.now() + 200us);
    }
  }
  hal::PseudoSerial pseudo_;
  sim_hil::SimSerialLine line_;
  std::array<sim_hil::JointModel, 2> joints_;
  std::vector<std::unique_ptr<sim_hil::SimSerialServo>> servos_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

TEST(SerialDevices, AGroupOfARobotFileMovesOverASerialLine) {
  ServosOnATerminal servos;
  DeviceSpecs specs = legs(servos.path(), 2, 50);
  specs.buses[0].keys["latency_ms"] = at(8.0);
  specs.buses[0].keys["priority"] = at(std::int64_t{0});
  for (DeviceSpec& joint : specs.devices[0].joints) joint.keys["feedback_timeout_ms"] = at(500.0);
  ASSERT_THAT(texts(specs), IsEmpty());
  hal::Os& os = hal::system_os();
  const auto connectors = hal::LinuxConnectors::unwatched(os);
  DeviceBoard board(specs, all_drivers(), *connectors, os);
  const auto actuators = board.actuators("group0");
  ASSERT_TRUE(actuators) << board.problem();
  const auto joints = board.sensor<msg::JointState>("group0");
  ASSERT_TRUE(joints);
  ASSERT_TRUE(board.start()) << board.problem();
  msg::ActuatorCommand command;
  command.count = 2, command.armed = 1;
  command.value[0] = 0.3, command.value[1] = -0.3;
  msg::JointState state;
  const hal::Time end = os.now() + 20s;
  const auto there = [&] {
    return state.count == 2 && state.ready == 3 && std::abs(state.position_rad[0] - 0.3) < 0.02 &&
           std::abs(state.position_rad[1] + 0.3) < 0.02;
  };
  while (!there() && os.now() < end) {
    ASSERT_TRUE((*actuators)->write(command, 500ms));
    for (auto got = (*joints)->read(state); got && *got; got = (*joints)->read(state)) {
    }
    os.sleep_until(os.now() + 10ms);
  }
  EXPECT_TRUE(there()) << state.position_rad[0] << " " << state.position_rad[1] << " " << state.ready;
  EXPECT_THAT(board.complaints(), IsEmpty());
}

TEST(SerialDevices, TheLatencyTimerOfAUsbAdapterIsSetOrNamed) {
  const auto pseudo = hal::make_pseudo_serial();
  ASSERT_TRUE(pseudo);
  const auto folder = hal::TemporaryFolder::make("serial_devices");
  ASSERT_TRUE(folder);
  const std::string name = pseudo->path.substr(pseudo->path.rfind('/') + 1);
  const std::filesystem::path timer =
      std::filesystem::path((*folder)->path()) / "sys/bus/usb-serial/devices" / name / "latency_timer";
  std::filesystem::create_directories(timer.parent_path());
  std::ofstream(timer) << "16\n";
  hal::SerialSpec spec{.path = pseudo->path, .low_latency = true, .root = (*folder)->path()};
  std::string why;
  ASSERT_TRUE(hal::open_serial(spec, why)) << why;
  EXPECT_EQ(why, "");
  std::string now;
  std::getline(std::ifstream(timer), now);
  EXPECT_EQ(now.substr(0, 1), "1");
  EXPECT_NE(now, "16");
  // A pseudo terminal has no flag for it, and this timer takes nothing.
  std::filesystem::remove(timer);
  std::filesystem::create_symlink("/dev/full", timer);
  ASSERT_TRUE(hal::open_serial(spec, why)) << why;
  EXPECT_THAT(why, HasSubstr("its adapter hands bytes over after 0 ms, and may not be set to 1: echo 1 | sudo tee " +
                             timer.string()));
}

}  // namespace
}  // namespace sinew::drivers::serial_devices_test
