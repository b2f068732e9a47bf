// calibrate imu, joint: measures what one robot differs in, and keeps it in its calibration file.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>

#include "apps/calibration.hpp"
#include "apps/commands.hpp"
#include "apps/imu_rest.hpp"
#include "apps/linux_board.hpp"
#include "apps/number_check.hpp"
#include "hal/linux/os.hpp"
#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

struct CalibrateOptions {
  std::string robot, device, joint, file;
  double seconds = 5, gravity_mps2 = 9.80665, at_rad = 0;
  bool six = false, dry = false;
};

constexpr hal::Duration kSilent = 2s;  // a device that says nothing for so long is given up

/// The robot file, its board, and the calibration that is there already.
class Bench {
 public:
  /// False after the reason was printed. `factory`: the device is opened without these keys of its table.
  bool open(const CalibrateOptions& o, const std::vector<std::string>& factory) {
    LoadedRobot loaded = load_robot(o.robot);
    for (const auto& p : loaded.problems) std::fprintf(stderr, "%s\n", rt::to_string(p, o.robot).c_str());
    if (!loaded.problems.empty()) return false;
    robot = std::move(loaded.robot);
    path = !o.file.empty() ? o.file : calibration_path(robot);
    if (path.empty() && !o.dry)
      return fail(o.robot + ": robot.calibration names no file; write it there, or say --file FILE"), false;
    if (!read_old()) return false;
    std::vector<rt::Problem> problems = apply_keys();
    for (auto& device : robot.devices.devices)
      if (device.name == o.device)
        for (const std::string& key : factory) device.keys.erase(key);
    for (auto& p : check_linux_devices(robot)) problems.push_back(std::move(p));
    for (const auto& p : problems) std::fprintf(stderr, "%s\n", rt::to_string(p, o.robot).c_str());
    if (!problems.empty()) return false;
    std::string why;
    auto real = LinuxBoard::open(robot, hal::linux_os(), why);
    if (!real) return fail(why), false;
    board = std::move(*real);
    return true;
  }

  void set(const std::string& device, const std::string& joint, const std::string& key, double value) {
    std::erase_if(old.keys,
                  [&](const CalibratedKey& k) { return k.device == device && k.joint == joint && k.key == key; });
    old.keys.push_back({device, joint, key, value, 0});
  }

  /// Another file takes the place of the old one in one piece.
  int write(bool dry) const {
    const std::string text = calibration_text(robot.graph.robot, old);
    if (dry) return std::fputs(text.c_str(), stdout), kDone;
    const std::string fresh = path + ".new";
    std::ofstream out(fresh, std::ios::binary);
    out << text;
    out.close();
    std::error_code error;
    if (out) std::filesystem::rename(fresh, path, error);
    if (!out || error) return fail(path + ": cannot be written", kFailed);
    std::printf("written: %s\n", path.c_str());
    return kDone;
  }

  RobotFile robot;
  std::string path;
  Calibration old;
  std::unique_ptr<LinuxBoard> board;

 private:
  bool read_old() {
    std::ifstream in(path, std::ios::binary);
    if (!in) return true;  // the first one
    const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    old = parse_calibration(text, path);
    for (const auto& p : old.problems) std::fprintf(stderr, "%s\n", rt::to_string(p, path).c_str());
    return old.problems.empty();
  }
  std::vector<rt::Problem> apply_keys() {
    Calibration keys = old;
    keys.params = {};  // modules are not run here
    return apply_calibration(keys, rt::ModuleTypes{}, robot);
  }
};

/// Reads a sensor for so long; false when it stayed silent, failed, or a signal ended it, after that was said.
template <class M, class Each>
bool read_for(hal::Sensor<M>& sensor, hal::Duration length, const std::string& name, const Each& each) {
  hal::Os& os = hal::linux_os();
  const hal::Time begin = os.now();
  hal::Time last = begin;
  std::size_t failed = 0;
  while (os.now() - begin < length || last == begin) {
    if (hal::stop_requested()) return fail("ended by a signal", kFailed), false;
    M sample;
    const auto got = sensor.read(sample);
    if (got && *got) {
      last = os.now();
      each(sample);
      continue;
    }
    if (!got) ++failed;
    if (os.now() - last > kSilent)
      return fail(fmt::format("device '{}': nothing came for {} s{}", name, kSilent.count() / 1'000'000'000,
                              failed ? fmt::format(", {} reads failed", failed) : ""),
                  kFailed),
             false;
    os.sleep_until(os.now() + 1ms);
  }
  return true;
}

bool rest_for(hal::Imu& imu, const CalibrateOptions& o, ImuRest& rest) {
  const auto length = hal::Duration{static_cast<std::int64_t>(o.seconds * 1e9)};
  if (!read_for<msg::ImuSample>(imu, length, o.device, [&](const msg::ImuSample& s) { rest.add(s); })) return false;
  if (const std::string why = rest.moved(); !why.empty()) return fail(why, kFailed), false;
  std::printf("%zu samples: rates %.5f %.5f %.5f rad/s, accelerations %.4f %.4f %.4f m/s^2\n", rest.count(),
              rest.gyro_mean_radps().x, rest.gyro_mean_radps().y, rest.gyro_mean_radps().z, rest.accel_mean_mps2().x,
              rest.accel_mean_mps2().y, rest.accel_mean_mps2().z);
  return true;
}

std::vector<std::string> imu_keys() {
  std::vector<std::string> keys{"mount_roll_deg", "mount_pitch_deg", "mount_yaw_deg"};
  for (const char axis : {'x', 'y', 'z'})
    for (const char* key : {"gyro_bias_{}_radps", "accel_bias_{}_mps2", "gyro_scale_{}", "accel_scale_{}"})
      keys.push_back(fmt::format(fmt::runtime(key), axis));
  return keys;
}

int calibrate_imu(const CalibrateOptions& o) {
  Bench bench;
  if (!bench.open(o, imu_keys())) return kNotBegun;
  auto imu = bench.board->board().sensor<msg::ImuSample>(o.device);
  if (!imu) return fail(bench.board->problem());
  std::vector<msg::Vec3> means;
  ImuRest rest;
  for (int position = 0; position < (o.six ? 6 : 1); ++position) {
    if (o.six) {
      std::printf("position %d of 6: lay another side of the IMU down, then press Enter\n", position + 1);
      std::fflush(stdout);
      std::string line;
      if (!std::getline(std::cin, line)) return fail("no more input", kFailed);
      msg::ImuSample stale;
      while (true) {  // what was measured before
        const auto got = (*imu)->read(stale);
        if (!got || !*got) break;
      }
    }
    rest = ImuRest();
    if (!rest_for(**imu, o, rest)) return kFailed;
    means.push_back(rest.accel_mean_mps2());
  }
  const msg::Vec3 bias = rest.gyro_mean_radps();
  bench.set(o.device, "", "gyro_bias_x_radps", bias.x);
  bench.set(o.device, "", "gyro_bias_y_radps", bias.y);
  bench.set(o.device, "", "gyro_bias_z_radps", bias.z);
  if (o.six) {
    std::string why;
    const auto accel = six_positions(means, o.gravity_mps2, why);
    if (!accel) return fail(why, kFailed);
    bench.set(o.device, "", "accel_bias_x_mps2", accel->bias_mps2.x);
    bench.set(o.device, "", "accel_bias_y_mps2", accel->bias_mps2.y);
    bench.set(o.device, "", "accel_bias_z_mps2", accel->bias_mps2.z);
    bench.set(o.device, "", "accel_scale_x", accel->scale.x);
    bench.set(o.device, "", "accel_scale_y", accel->scale.y);
    bench.set(o.device, "", "accel_scale_z", accel->scale.z);
  }
  return bench.write(o.dry);
}

int calibrate_joint(const CalibrateOptions& o) {
  Bench bench;
  if (!bench.open(o, {})) return kNotBegun;
  const drivers::DeviceSpec* group = nullptr;
  for (const auto& d : bench.robot.devices.devices)
    if (d.name == o.device) group = &d;
  if (!group) return fail(fmt::format("{}: there is no [device.{}]", o.robot, o.device));
  std::size_t channel = 0;
  std::string known;
  while (channel < group->joints.size() && group->joints[channel].name != o.joint) {
    known += (known.empty() ? "" : ", ") + group->joints[channel].name;
    ++channel;
  }
  if (channel == group->joints.size() || channel >= msg::kMaxChannels)
    return fail(fmt::format("[device.{}] has no joint '{}'; it has: {}", o.device, o.joint, known));
  auto joints = bench.board->board().sensor<msg::JointState>(o.device);
  if (!joints || !bench.board->start()) return fail(bench.board->problem());
  double sum = 0;
  std::size_t count = 0;
  const auto length = hal::Duration{static_cast<std::int64_t>(o.seconds * 1e9)};
  const auto take = [&](const msg::JointState& s) {
    if (s.measured[channel].ns == 0 || !(s.position_rad[channel] == s.position_rad[channel])) return;
    sum += s.position_rad[channel], ++count;
  };
  if (!read_for<msg::JointState>(**joints, length, o.device, take)) return kFailed;
  if (count == 0) return fail(fmt::format("joint '{}' of '{}' does not answer", o.joint, o.device), kFailed);
  double zero_rad = 0;
  if (const auto it = group->joints[channel].keys.find("zero_rad"); it != group->joints[channel].keys.end()) {
    if (const auto* real = std::get_if<double>(&it->second.value)) zero_rad = *real;
    if (const auto* whole = std::get_if<std::int64_t>(&it->second.value)) zero_rad = static_cast<double>(*whole);
  }
  const double reads_rad = sum / static_cast<double>(count);
  std::printf("%zu samples: the joint reads %.5f rad and is at %.5f rad\n", count, reads_rad, o.at_rad);
  bench.set(o.device, o.joint, "zero_rad", zero_rad + reads_rad - o.at_rad);
  return bench.write(o.dry);
}

CLI::App& calibrate(CLI::App& parent, CommandContext& context, const char* name, const char* text,
                    int (*run)(const CalibrateOptions&), const std::shared_ptr<CalibrateOptions>& o) {
  CLI::App& app = *parent.add_subcommand(name, text);
  app.add_option("robot", o->robot, "robot file; the robot is not running")->required()->type_name(kRobotFileHint);
  app.add_option("--seconds", o->seconds, "how long it is measured (each time)")
      ->check(number(0.1, 3600))
      ->type_name("S");
  app.add_option("--file", o->file, "calibration file; default: robot.calibration")->type_name(kFileHint);
  app.add_flag("--dry", o->dry, "print what would be written");
  app.callback([&context, o, run] { context.action = [o, run] { return run(*o); }; });
  return app;
}

}  // namespace

void add_calibrate_command(CLI::App& app, CommandContext& context) {
  CLI::App& parent = *app.add_subcommand("calibrate", "measure what one robot differs in, into its calibration file");
  parent.require_subcommand(1);
  const auto imu_options = std::make_shared<CalibrateOptions>();
  CLI::App& imu = calibrate(parent, context, "imu", "biases of an IMU that lies still; with --six also its scales",
                            calibrate_imu, imu_options);
  imu_options->device = "imu";
  imu.add_option("--device", imu_options->device, "which one")->capture_default_str();
  imu.add_flag("--six", imu_options->six, "six positions, each axis once up and once down: asks for each");
  imu.add_option("--gravity", imu_options->gravity_mps2, "where you are, m/s^2")->check(number(9.7, 9.9));

  const auto joint_options = std::make_shared<CalibrateOptions>();
  joint_options->seconds = 1;
  CLI::App& joint = calibrate(parent, context, "joint", "zero of a joint that stands where it is said to stand",
                              calibrate_joint, joint_options);
  joint.add_option("--device", joint_options->device, "the actuator group")->required();
  joint.add_option("--joint", joint_options->joint, "its joint")->required();
  joint.add_option("--at", joint_options->at_rad, "where it stands, rad")->check(number(-1000, 1000))->type_name("RAD");
}

}  // namespace sinew::app
