#include "apps/robot_file/calibration.hpp"

#include <gmock/gmock.h>

#include "apps/module_list.hpp"

namespace sinew::app::calibration_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::string_view kRobot = R"(
robot = { name = "head", board = "linux", calibration = "unit7.toml" }
[device.imu]
driver = "iio"
name = "mpu6050"
gyro_bias_x_radps = 0.5
[[device.head.joint]]
name = "pan"
driver = "cia402"
[device.head]
driver = "can_servos"
)";
// [[device.head.joint]] before [device.head] is TOML's "defined implicitly"; the other order is the usual one.

RobotFile robot() {
  LoadedRobot loaded = parse_robot(kRobot, "/robots/head.toml");
  EXPECT_THAT(loaded.problems, IsEmpty());
  return loaded.robot;
}

std::vector<std::string> texts(const std::vector<rt::Problem>& problems) {
  std::vector<std::string> out;
  for (const auto& p : problems) out.push_back(rt::to_string(p, "c.toml"));
  return out;
}

TEST(Calibration, TakesThePlaceOfTheRobotFilesKeys) {
  RobotFile r = robot();
  EXPECT_EQ(calibration_path(r), "/robots/unit7.toml");
  const auto c = parse_calibration(
      "[device.imu]\ngyro_bias_x_radps = 0.25\naccel_scale_z = 1.01\n"
      "[device.head.joint.pan]\nzero_rad = -0.5\n",
      "c.toml");
  EXPECT_THAT(apply_calibration(c, all_modules(), r), IsEmpty());
  ASSERT_EQ(r.devices.devices.size(), 2u);
  for (const auto& d : r.devices.devices) {
    if (d.name == "imu") {
      EXPECT_EQ(std::get<double>(d.keys.at("gyro_bias_x_radps").value), 0.25);
      EXPECT_EQ(std::get<double>(d.keys.at("accel_scale_z").value), 1.01);
      EXPECT_EQ(std::get<std::string>(d.keys.at("name").value), "mpu6050") << "what it does not name stays";
    } else {
      ASSERT_EQ(d.joints.size(), 1u);
      EXPECT_EQ(std::get<double>(d.joints[0].keys.at("zero_rad").value), -0.5);
    }
  }
}

TEST(Calibration, OfSomethingThatTheRobotHasNotIsAProblemWithItsLine) {
  RobotFile r = robot();
  const auto c = parse_calibration(
      "[device.gps]\noffset = 1\n[device.head.joint.tilt]\nzero_rad = 1\n"
      "[module.ball]\nfocal_px = 300.0\n",
      "c.toml");
  EXPECT_THAT(texts(apply_calibration(c, all_modules(), r)),
              ElementsAre("c.toml:2: device.gps.offset: 1: a key of a device of the robot file: one of head, imu",
                          "c.toml:4: device.head.joint.tilt.zero_rad: 1: a key of a joint of this device: one of pan",
                          ::testing::HasSubstr("c.toml:6: module.ball")));
}

TEST(Calibration, WrongFormIsNamed) {
  EXPECT_THAT(texts(parse_calibration("x = 1\n[device.imu]\na = [1]\n", "c.toml").problems),
              ElementsAre(::testing::HasSubstr("c.toml:3: device.imu.a"), ::testing::HasSubstr("c.toml:1: x")));
  EXPECT_THAT(texts(parse_calibration("[device.imu\n", "c.toml").problems), ElementsAre(::testing::HasSubstr("TOML")));
}

TEST(Calibration, TextReadsBackAsWhatItWas) {
  const auto c = parse_calibration(
      "[device.imu]\ngyro_bias_x_radps = 0.25\n[device.head.joint.pan]\nzero_rad = 2.0\n"
      "[module.ball]\nfocal_px = 300.0\n",
      "c.toml");
  const std::string text = calibration_text("head", c);
  const auto again = parse_calibration(text, "again.toml");
  EXPECT_THAT(again.problems, IsEmpty());
  EXPECT_EQ(again.keys.size(), 2u);
  EXPECT_EQ(again.params.params.size(), 1u);
  EXPECT_EQ(calibration_text("head", again), text);
}

}  // namespace
}  // namespace sinew::app::calibration_test
