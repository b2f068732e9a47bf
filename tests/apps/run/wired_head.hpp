#pragma once
// A complete head with two joints on a bus, an IMU, a barometer and a camera; and the problems reported when something
// is changed.
#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/module_list.hpp"
#include "apps/robot/robot_check.hpp"
#include "apps/run/run_setup.hpp"

namespace sinew::app {

inline constexpr std::string_view kRobot = R"(robot = { name = "head", board = "linux" }
[[thread]]
name = "steer"
priority = 80
period_us = 1000
order = ["imu", "baro", "joints", "filter", "camera", "ball", "follower"]
[module.imu]
type = "drivers::ImuSource"
[module.baro]
type = "drivers::BaroSource"
params = { device = "air" }
[module.joints]
type = "drivers::JointSource"
params = { device = "head" }
[module.filter]
type = "control::ErrorStateFilter"
in = { imu = "imu.raw" }
[module.camera]
type = "drivers::CameraSource"
[module.ball]
type = "vision::BallDetector"
in = { image = "camera.raw" }
[module.follower]
type = "control::HeadFollower"
in = { state = "filter.state", joints = "joints.raw", ball = "ball.sighting", safety = "guardian.state" }
[topic."camera.raw"]
image = { width = 640, height = 480, format = "yuyv" }
[actuator.head]
command = "follower.command"
channels = 2
limit = [[-1.4, 1.4], [-1.0, 0.9]]
lease_ms = 20
[bus.can0]
driver = "udp"
address = 7
max_load_percent = 80
[device.imu]
driver = "mpu6050"
path = "/dev/i2c-1"
[device.air]
driver = "bmp280"
path = "/dev/i2c-1"
[device.camera]
driver = "v4l2"
path = "/dev/video0"
width = 640
height = 480
format = "yuyv"
[device.head]
driver = "can_servos"
[[device.head.joint]]
name = "pan"
driver = "cia402"
bus = "can0"
id = 1
counts_per_turn = 65536
min_rad = -1.4
max_rad = 1.4
[[device.head.joint]]
name = "tilt"
driver = "cia402"
bus = "can0"
id = 2
counts_per_turn = 65536
min_rad = -1.0
max_rad = 0.9
)";

using Change = std::pair<std::string_view, std::string_view>;

inline std::string changed(const std::vector<Change>& changes) {
  std::string text(kRobot);
  for (const auto& [from, to] : changes) {
    const auto at = text.find(from);
    EXPECT_NE(at, text.npos) << from;
    if (at != text.npos) text.replace(at, from.size(), to);
  }
  return text;
}

/// The problems of the robot with these changes; each changes the first place of its text.
inline std::vector<std::string> problems(const std::vector<Change>& changes = {}) {
  std::vector<std::string> out;
  const LoadedRobot loaded = parse_robot(changed(changes), "r.toml");
  for (const auto& p : loaded.problems) out.push_back(rt::to_string(p, "r.toml"));
  if (!out.empty()) return out;
  const rt::Graph graph(loaded.robot.graph, all_modules());
  for (const auto& p : check_robot(loaded.robot, graph, check_options(loaded.robot)))
    out.push_back(rt::to_string(p, "r.toml"));
  return out;
}

/// The line of the robot file, 1 for the first, on which `text` begins for the first time.
inline std::string at(std::string_view text) {
  const auto place = kRobot.find(text);
  EXPECT_NE(place, kRobot.npos) << text;
  return "r.toml:" + std::to_string(1 + std::count(kRobot.begin(), kRobot.begin() + place, '\n')) + ": ";
}

}  // namespace sinew::app
