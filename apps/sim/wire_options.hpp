#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "math/linear.hpp"
#include "msg/geometry.hpp"

namespace sinew::plant {

/// The options of sinew-sim that put parts of its world at the wire. docs/devices.md
struct WireOptions {
  std::string can, iio, v4l2, unplug, camera_turned, gyro_bias;
  double camera_late_ms = 0;
  std::vector<std::string> servos, serial;

  void describe(CLI::App& app);
  bool any() const { return !can.empty() || !serial.empty() || !iio.empty() || !v4l2.empty(); }
  math::Vec3 camera_turned_rad() const;
  msg::Vec3 gyro_bias_radps() const;
  /// When the camera is unplugged, in s of plant time; false: never.
  bool unplugged(double& from_s, double& until_s) const;
};

}  // namespace sinew::plant
