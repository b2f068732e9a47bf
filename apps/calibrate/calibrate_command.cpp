// calibrate imu, joint, mag, camera, legs, camera-offset: measures how one robot differs, and writes it to its
// calibration file.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <iostream>

#include "apps/calibrate/calibration_bench.hpp"
#include "apps/calibrate/commands.hpp"
#include "apps/calibrate/imu_rest.hpp"
#include "apps/calibrate/lens_command.hpp"
#include "apps/calibrate/mag_command.hpp"
#include "apps/command/number_check.hpp"

namespace sinew::app {
namespace {

bool rest_for(hal::Imu& imu, const CalibrateOptions& o, ImuRest& rest) {
  const auto length = hal::Duration{static_cast<std::int64_t>(o.seconds * 1e9)};
  if (!read_for<msg::ImuSample>(imu, length, o.device, [&](const msg::ImuSample& s) { rest.add(s); })) return false;
  if (const std::string why = rest.moved(); !why.empty()) {
    fail(why, kFailed);
    return false;
  }
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
  CalibrationBench bench;
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
      while (true) {  // drops samples from before
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
  CalibrationBench bench;
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
                    const std::function<int(const CalibrateOptions&)>& run,
                    const std::shared_ptr<CalibrateOptions>& o) {
  CLI::App& app = *parent.add_subcommand(name, text);
  app.add_option("robot", o->robot, "robot file; the robot is not running")->required()->type_name(kRobotFileHint);
  app.add_option("--seconds", o->seconds, "how long it is measured (each time)")
      ->check(number(0.1, 3600))
      ->type_name("S");
  app.add_option("--file", o->file, "calibration file; default: robot.calibration")->type_name(kFileHint);
  app.add_option("--set", o->set, "device.NAME.KEY=VALUE or bus.NAME.KEY=VALUE, for this time; may be repeated")
      ->allow_extra_args(false);
  app.add_flag("--dry", o->dry, "print what would be written");
  app.callback([&context, o, run] { context.action = [o, run] { return run(*o); }; });
  return app;
}

/// What commands have in common that look at a board in a recording.
CLI::App& add_board_command(CLI::App& parent, const char* name, const char* text, LensOptions& o) {
  CLI::App& app = *parent.add_subcommand(name, text);
  app.add_option("recording", o.recording, "with pixels: `sinew run --record-images`")
      ->required()
      ->type_name(kFileHint);
  app.add_option("--square", o.square_m, "side of one square of the board, m")
      ->check(number(1e-4, 10))
      ->type_name("M")
      ->required();
  app.add_option("--board", o.board, "its inner corners, across and down [9 6]")
      ->expected(2)
      ->check(whole(3, 32))
      ->type_name("COLUMNS ROWS");
  app.add_option("--topic", o.topic, "of the pictures, if there are several")->type_name("TOPIC");
  app.add_option("--file", o.file, "calibration file to write to; default: it is printed")->type_name(kFileHint);
  app.add_flag("--json", o.json, "as one JSON object");
  return app;
}

}  // namespace

void add_calibrate_command(CLI::App& app, CommandContext& context) {
  CLI::App& parent =
      *app.add_subcommand("calibrate", "measure how one robot differs, and write it to its calibration file");
  parent.require_subcommand(1);
  const auto imu_options = std::make_shared<CalibrateOptions>();
  CLI::App& imu = calibrate(parent, context, "imu", "biases of an IMU that lies still; with --six also its scales",
                            calibrate_imu, imu_options);
  imu_options->device = "imu";
  imu.add_option("--device", imu_options->device, "which one")->capture_default_str();
  imu.add_flag("--six", imu_options->six, "six positions, each axis once up and once down: asks for each");
  imu.add_option("--gravity", imu_options->gravity_mps2, "local gravity, m/s^2")->check(number(9.7, 9.9));

  const auto joint_options = std::make_shared<CalibrateOptions>();
  joint_options->seconds = 1;
  CLI::App& joint = calibrate(parent, context, "joint", "zero of a joint that stands at a known angle", calibrate_joint,
                              joint_options);
  joint.add_option("--device", joint_options->device, "the actuator group")->required();
  joint.add_option("--joint", joint_options->joint, "its joint")->required();
  joint.add_option("--at", joint_options->at_rad, "where it stands, rad")
      ->check(number(-1000, 1000))
      ->type_name("RAD")
      ->required();

  const auto mag_options = std::make_shared<MagOptions>();
  CLI::App& mag = *parent.add_subcommand(
      "mag", "hard and soft iron of a magnetometer, from a recording in which the vehicle was turned about all axes");
  mag.add_option("recording", mag_options->recording, "far from iron and from currents that change")
      ->required()
      ->type_name(kFileHint);
  mag.add_option("--topic", mag_options->topic, "of the readings, if there are several")->type_name("TOPIC");
  const auto field = mag.add_option("--field", mag_options->field_ut, "strength of the earth's field there, uT")
                         ->check(number(15, 80))
                         ->type_name("UT");
  mag.add_option("--at", mag_options->at_deg, "or where it was, degrees; default: the first GNSS fix of the recording")
      ->expected(2)
      ->check(number(-180, 180))
      ->type_name("LATITUDE LONGITUDE")
      ->excludes(field);
  mag.add_option("--year", mag_options->year, "and when, as 2026.9; default: when it was recorded")
      ->check(number(1900, 2100))
      ->type_name("YEAR")
      ->excludes(field);
  mag.add_option("--file", mag_options->file, "calibration file to write to; default: it is printed")
      ->type_name(kFileHint);
  mag.add_option("--params", mag_options->params, "write the numbers for `sinew run --params`, too")
      ->type_name(kFileHint);
  mag.add_flag("--json", mag_options->json, "as one JSON object");
  mag.callback([&context, mag_options] {
    context.action = [mag_options, &types = context.types] { return calibrate_mag(*mag_options, types); };
  });

  const auto lens_options = std::make_shared<LensOptions>();
  CLI::App& lens = add_board_command(
      parent, "camera",
      "focal lengths, centre and distortion of a camera, from a recording that shows a printed chessboard",
      *lens_options);
  lens.add_option("--views", lens_options->views, "at most so many are fitted, those that differ most [40]")
      ->check(whole(3, 200))
      ->type_name("N");
  lens.add_option("--picture", lens_options->picture, "PNG of all corners and of how far the camera is off at each")
      ->type_name("FILE");
  lens.add_option("--params", lens_options->params, "write the numbers for `sinew run --params`, too")
      ->type_name(kFileHint);
  lens.callback([&context, lens_options] {
    context.action = [lens_options, &types = context.types] { return calibrate_lens(*lens_options, types); };
  });

  const auto legs_options = std::make_shared<LegsOptions>();
  CLI::App& legs = add_board_command(
      parent, "legs",
      "zeros of the joints of legs and head, and soles, from a recording in which a humanoid stood in poses before a "
      "chessboard on the ground",
      legs_options->lens);
  legs.add_option("--camera", legs_options->camera_file,
                  "the camera's numbers, as `calibrate camera --file` wrote them")
      ->type_name(kFileHint);
  legs.add_option("--place", legs_options->place, "of the camera in the body [camera]")->type_name("NAME");
  legs.callback([&context, legs_options] {
    context.action = [legs_options, &types = context.types] { return calibrate_legs(*legs_options, types); };
  });

  const auto camera_options = std::make_shared<CalibrateOptions>();
  camera_options->device = "imu";
  camera_options->seconds = 20;
  CLI::App& camera = calibrate(
      parent, context, "camera-offset",
      "a camera's delay and mount against the IMU, while you turn the robot about all axes",
      [&types = context.types](const CalibrateOptions& o) { return calibrate_camera_offset(o, types); },
      camera_options);
  camera.add_option("--camera", camera_options->camera, "which camera")->capture_default_str();
  camera.add_option("--device", camera_options->device, "which IMU")->capture_default_str();
  camera.add_option("--mount", camera_options->mount,
                    "the module whose camera_qw, camera_qx, camera_qy, camera_qz say how the camera is mounted");
  camera
      .add_option("--fov", camera_options->fov_y_deg,
                  "field of view from top to bottom, deg; default: fov_y_rad of a module")
      ->check(number(5, 150))
      ->type_name("DEG");
}

}  // namespace sinew::app
