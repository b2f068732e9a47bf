#pragma once
// Values that differ from one robot of a kind to the next, in a file beside the robot file (robot.calibration):
//
//   [device.imu]                 # keys of [device.imu]
//   gyro_bias_x_radps = 0.0021
//   [device.head.joint.pan]      # keys of that joint
//   zero_rad = -0.013
//   [module.ball]                # parameters of a module
//   focal_px = 287.4
//
// It holds for real devices only: with board = "sim" it is ignored.
#include <string>
#include <string_view>
#include <vector>

#include "apps/robot_file/param_overlay.hpp"
#include "apps/robot_file/robot_file.hpp"

namespace sinew::app {

struct CalibratedKey {
  std::string device, joint, key;  // joint empty: key of the device itself
  rt::ParamValue value;
  int line = 0;
};

struct Calibration {
  std::vector<CalibratedKey> keys;
  ParamOverlay params;
  std::vector<rt::Problem> problems;  // of form

  /// The line that sets "device.imu.rate_hz" or "device.head.joint.pan.zero_rad"; 0: there is none.
  int line_of(std::string_view path) const;
};

Calibration parse_calibration(std::string_view text, const std::string& path);

/// Puts the values in place of those of the robot file. What does not fit (no such device, joint, module or parameter)
/// becomes a problem with the line of the calibration.
std::vector<rt::Problem> apply_calibration(const Calibration& calibration, const rt::ModuleTypes& types,
                                           RobotFile& robot);

/// The path of the robot's calibration file, relative paths beside the robot file. Empty: it has none.
std::string calibration_path(const RobotFile& robot);

/// The text of such a file, devices before modules, each in the order in which they come.
std::string calibration_text(std::string_view robot, const Calibration& calibration);

}  // namespace sinew::app
