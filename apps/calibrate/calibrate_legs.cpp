// calibrate legs: zeros of the joints of legs and head and the soles of a humanoid, from a recording in which it stood
// before a board on the ground.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "apps/bag/bag_file.hpp"
#include "apps/calibrate/calibration_output.hpp"
#include "apps/calibrate/lens_command.hpp"
#include "apps/calibrate/recorded_stand.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "apps/robot_file/calibration.hpp"
#include "rt/parameters.hpp"
#include "vision/pinhole.hpp"

namespace sinew::app {
namespace {

constexpr double kDegrees = 180 / math::kPi;

/// The camera's numbers of the module that sees the topic: as the robot file has them, `calibration` over them, the
/// module's defaults below. False, after printing: no module has them.
bool camera_of(RobotFile& robot, const Calibration& calibration, const rt::ModuleTypes& types,
               const RecordedBoards& boards, identify::LensCamera& camera) {
  for (rt::ModuleSpec& m : robot.graph.modules) {
    bool sees = false;
    for (const auto& [port, of] : m.in) sees = sees || of.value == boards.topic;
    const auto made = sees ? types.make(m.type) : nullptr;
    if (!made) continue;
    for (const OverlayParam& p : calibration.params.params)
      if (p.module == m.name) m.params[p.param] = {p.value, 0};
    rt::Declaration declaration;
    made->declare(declaration);
    const auto number = [&](const char* name) {
      const auto* declared = rt::find_param(declaration, name);
      if (!declared) return 0.0;
      const auto given = m.params.find(name);
      const rt::ParamValue& value = given == m.params.end() ? declared->default_value : given->second.value;
      if (const auto* real = std::get_if<double>(&value)) return *real;
      if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
      return 0.0;
    };
    if (!rt::find_param(declaration, "fx_px")) continue;
    vision::Pinhole pinhole{number("fx_px"), number("fy_px"), number("cx_px"), number("cy_px")};
    if (const double fov = number("fov_y_rad"); fov > 0)
      pinhole = vision::Pinhole::from_fov(fov, boards.width, boards.height).or_given(pinhole);
    camera = {pinhole.fx_px,
              pinhole.fy_px,
              pinhole.cx_px,
              pinhole.cy_px,
              {number("k1"), number("k2"), number("p1"), number("p2"), 0}};
    return camera.fx_px > 0 && camera.fy_px > 0;
  }
  return false;
}

/// What other programs and the robot file take of it.
Calibration zeros_for(const RobotFile& robot, const identify::StandFit& fit, Calibration all) {
  for (const drivers::DeviceSpec& device : robot.devices.devices)
    for (const drivers::DeviceSpec& joint : device.joints)
      for (const identify::StandEstimate& e : fit.estimates) {
        if (e.name != joint.name || !e.shown) continue;
        double old = 0;
        if (const auto it = joint.keys.find("zero_rad"); it != joint.keys.end()) {
          if (const auto* real = std::get_if<double>(&it->second.value)) old = *real;
          if (const auto* whole = std::get_if<std::int64_t>(&it->second.value)) old = static_cast<double>(*whole);
        }
        std::erase_if(all.keys, [&](const CalibratedKey& k) {
          return k.device == device.name && k.joint == joint.name && k.key == "zero_rad";
        });
        all.keys.push_back({device.name, joint.name, "zero_rad", old + e.value, 0});
      }
  return all;
}

bool is_sole(const identify::StandFit& fit, std::size_t i) { return i + 2 >= fit.estimates.size(); }

void tell(const identify::StandFit& fit, const RecordedStand& stand) {
  put_text(fmt::format("stood still {} times; {} poses with both soles flat\n", stand.still, fit.poses));
  for (std::size_t i = 0; i < fit.estimates.size(); ++i) {
    const identify::StandEstimate& e = fit.estimates[i];
    const bool sole = is_sole(fit, i);
    const double unit = sole ? 1000 : kDegrees;
    put_text(fmt::format("  {:<16}{:>9.3f} +- {:<7.3f}{:<4}{}{}\n", e.name, unit * e.value, unit * e.half_width,
                         sole ? "mm" : "deg", sole ? "thicker" : "too much", e.shown ? "" : "  (not shown)"));
  }
  put_text(fmt::format(
      "  the camera's attitude by legs, torso and neck is off by {:.2f} degrees RMS; with these numbers by {:.2f}\n",
      fit.before_rad * kDegrees, fit.after_rad * kDegrees));
  for (const std::string& unknown : fit.unknown) put_text("  not shown: " + unknown + "\n");
}

Json to_json(const identify::StandFit& fit, const RecordedStand& stand) {
  Json json = {{"still", stand.still},
               {"not_flat", stand.not_flat},
               {"poses", fit.poses},
               {"before_rad", fit.before_rad},
               {"after_rad", fit.after_rad}};
  for (std::size_t i = 0; i < fit.estimates.size(); ++i) {
    const identify::StandEstimate& e = fit.estimates[i];
    json[is_sole(fit, i) ? "soles" : "joints"][e.name] = {
        {"value", e.value},
        {"half_width_95", std::isfinite(e.half_width) ? Json(e.half_width) : Json(nullptr)},
        {"unit", is_sole(fit, i) ? "m" : "rad"},
        {"shown", e.shown}};
  }
  json["unknown"] = fit.unknown;
  return json;
}

}  // namespace

int calibrate_legs(const LegsOptions& o, const rt::ModuleTypes& types) {
  const vision::BoardSize size{o.lens.board[0], o.lens.board[1]};
  const std::string& file = o.lens.recording;
  if ((size.columns + size.rows) % 2 == 0)
    return fail(fmt::format("--board {} {}: columns + rows has to be odd, so that the board's ends differ",
                            size.columns, size.rows));
  std::optional<RecordedBoards> boards;
  std::optional<RecordedStand> stand;
  RobotFile robot;
  Calibration camera_file;
  if (!o.camera_file.empty() && !std::filesystem::exists(o.camera_file))
    return fail(o.camera_file + ": there is no such file");
  if (!read_calibration(o.camera_file, camera_file)) return kNotBegun;
  {
    Progress progress("calibrate");
    const auto reader = open_recording(file, progress);
    if (!reader) return kNotBegun;
    const auto text = record::read_attachment(*reader, "robot.toml");
    if (!text) return fail(file + ": it has no robot file");
    robot = parse_robot(*text, "robot.toml").robot;
    std::string why;
    boards = read_boards(*reader, o.lens.topic, size, why);
    if (boards) stand = read_stand(*reader, robot, *boards, o.lens.square_m, size.columns, why);
    if (!stand) return fail(file + ": " + why);
  }
  const kinematics::Body& body = *robot.body.body;
  identify::StandRecord record;
  record.body = &body;
  const kinematics::Place* place = body.find_place(o.place);
  if (!place) return fail(fmt::format("{}: the body has no place '{}'", file, o.place));
  record.camera_place = *place;
  if (!camera_of(robot, camera_file, types, *boards, record.camera))
    return fail(fmt::format("{}: no module of its robot file sees {} and has a camera's numbers", file, boards->topic));
  record.poses = stand->poses;
  const identify::StandFit fit = identify::fit_stand(record);
  if (!fit.problem.empty())
    return fail(fmt::format("{}: {} (it stood still {} times; {} times a sole was not flat)", file, fit.problem,
                            stand->still, stand->not_flat),
                kFailed);
  if (o.lens.json)
    std::printf("%s\n", to_json(fit, *stand).dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  else
    tell(fit, *stand);
  Calibration old;
  if (!read_calibration(o.lens.file, old)) return kNotBegun;
  const Calibration all = zeros_for(robot, fit, old);
  if (all.keys.empty()) {
    if (!o.lens.json) put_text("  no device of the robot file has joints of these names: nothing to write\n");
    return kDone;
  }
  return write_calibration(o.lens.file, robot.graph.robot, all, o.lens.json);
}

}  // namespace sinew::app
