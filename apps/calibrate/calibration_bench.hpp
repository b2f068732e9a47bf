#pragma once
// Shared by the commands `sinew calibrate ...`: their options, the robot with its devices, its calibration file.
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "apps/command/command.hpp"
#include "apps/robot/linux_board.hpp"
#include "apps/robot_file/calibration.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::app {

struct CalibrateOptions {
  std::string robot, device, joint, file;
  double seconds = 5, gravity_mps2 = 9.80665, at_rad = 0;
  bool six = false, dry = false;
  std::vector<std::string> set;  // "device.imu.root=/tmp/x"
  // camera-offset
  std::string camera = "camera", mount;
  double fov_y_deg = 0;  // 0: the robot file's
};

inline constexpr hal::Duration kSilent = std::chrono::seconds(2);  // a device silent for so long has failed

/// The robot file, its board, and the existing calibration.
class CalibrationBench {
 public:
  /// False after printing the reason. `factory`: keys of the device's table that are left out when it is opened.
  bool open(const CalibrateOptions& o, const std::vector<std::string>& factory);
  void set(const std::string& device, const std::string& joint, const std::string& key, double value);
  void set_param(const std::string& module, const std::string& param, double value);
  /// Replaces the old file in one piece; `dry`: prints it instead. Returns the exit code.
  int write(bool dry) const;

  RobotFile robot;
  std::string path;
  Calibration old;
  std::unique_ptr<LinuxBoard> board;

 private:
  bool read_old();
  std::vector<rt::Problem> apply_keys();
};

/// Reads a sensor for --seconds. False, after printing why: it stayed silent, failed, or a signal ended the reading.
template <class M, class Each>
bool read_for(hal::Sensor<M>& sensor, hal::Duration length, const std::string& name, const Each& each) {
  hal::Os& os = hal::system_os();
  const hal::Time begin = os.now();
  hal::Time last = begin;
  std::size_t failed = 0;
  while (os.now() - begin < length || last == begin) {
    if (hal::stop_requested()) {
      fail("ended by a signal", kFailed);
      return false;
    }
    M sample;
    const auto got = sensor.read(sample);
    if (got && *got) {
      last = os.now();
      each(sample);
      continue;
    }
    if (!got) ++failed;
    if (os.now() - last > kSilent) {
      fail(fmt::format("device '{}': nothing came for {} s{}", name, kSilent.count() / 1'000'000'000,
                       failed ? fmt::format(", {} reads failed", failed) : ""),
           kFailed);
      return false;
    }
    os.sleep_until(os.now() + std::chrono::milliseconds(1));
  }
  return true;
}

/// `calibrate camera-offset`: the exit code.
int calibrate_camera_offset(const CalibrateOptions& o, const rt::ModuleTypes& types);

}  // namespace sinew::app
