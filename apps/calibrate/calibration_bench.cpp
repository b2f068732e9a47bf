#include "apps/calibrate/calibration_bench.hpp"

#include <algorithm>
#include <cstdio>

#include "apps/calibrate/lens_command.hpp"
#include "apps/run/run_setup.hpp"

namespace sinew::app {

bool CalibrationBench::open(const CalibrateOptions& o, const std::vector<std::string>& factory) {
  LoadedRobot loaded = load_robot(o.robot);
  for (const auto& p : loaded.problems) std::fprintf(stderr, "%s\n", to_string(p, loaded.robot).c_str());
  if (!loaded.problems.empty()) return false;
  robot = std::move(loaded.robot);
  path = !o.file.empty() ? o.file : calibration_path(robot);
  if (path.empty() && !o.dry) {
    fail(o.robot + ": robot.calibration names no file; write it there, or say --file FILE");
    return false;
  }
  if (!read_old()) return false;
  std::vector<rt::Problem> problems = apply_keys();
  for (auto& device : robot.devices.devices)
    if (device.name == o.device)
      for (const std::string& key : factory) device.keys.erase(key);
  OptionLines options;
  for (const std::string& setting : o.set) {
    if (const std::string why = apply_only_device_setting(robot.devices, setting, options.line_of("--set " + setting));
        !why.empty()) {
      fail(why);
      return false;
    }
  }
  for (auto& p : check_linux_devices(robot)) problems.push_back(std::move(p));
  for (const auto& p : problems) std::fprintf(stderr, "%s\n", options.told(p, robot).c_str());
  if (!problems.empty()) return false;
  std::string why;
  auto real = LinuxBoard::open(robot, hal::system_os(), why);
  if (!real) {
    fail(why);
    return false;
  }
  board = std::move(*real);
  return true;
}

void CalibrationBench::set(const std::string& device, const std::string& joint, const std::string& key, double value) {
  std::erase_if(old.keys,
                [&](const CalibratedKey& k) { return k.device == device && k.joint == joint && k.key == key; });
  old.keys.push_back({device, joint, key, value, 0});
}

void CalibrationBench::set_param(const std::string& module, const std::string& param, double value) {
  std::erase_if(old.params.params, [&](const OverlayParam& p) { return p.module == module && p.param == param; });
  old.params.params.push_back({module, param, value, 0});
}

int CalibrationBench::write(bool dry) const {
  const std::string text = calibration_text(robot.graph.robot, old);
  if (dry) {
    std::fputs(text.c_str(), stdout);
    return kDone;
  }
  return write_calibration(path, robot.graph.robot, old, false);
}

bool CalibrationBench::read_old() { return read_calibration(path, old); }

std::vector<rt::Problem> CalibrationBench::apply_keys() {
  Calibration keys = old;
  keys.params = {};  // modules are not run here
  return apply_calibration(keys, rt::ModuleTypes{}, robot);
}

}  // namespace sinew::app
