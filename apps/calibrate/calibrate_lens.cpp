// calibrate camera: the numbers of a camera and its lens, from a recording.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "apps/bag/bag_file.hpp"
#include "apps/calibrate/calibration_output.hpp"
#include "apps/calibrate/lens_command.hpp"
#include "apps/calibrate/lens_picture.hpp"
#include "apps/calibrate/recorded_boards.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "apps/robot_file/calibration.hpp"
#include "rt/parameters.hpp"

namespace sinew::app {
namespace {

using identify::CameraFit;
using identify::kCameraNumbers;

constexpr double kLonger = 10;  // residuals in the picture

std::vector<identify::PlaneView> views_of(const std::vector<SeenBoard>& boards, std::uint32_t columns,
                                          double square_m) {
  std::vector<identify::PlaneView> views;
  for (const SeenBoard& b : boards) {
    identify::PlaneView view;
    for (std::size_t i = 0; i < b.corners.size(); ++i)
      view.push_back({static_cast<double>(i % columns) * square_m, static_cast<double>(i / columns) * square_m,
                      b.corners[i].u_px, b.corners[i].v_px});
    views.push_back(std::move(view));
  }
  return views;
}

/// Names of a module's parameters for a camera; "k1" has no unit, "fx_px" has.
std::string param_of(std::size_t number) {
  const auto& text = identify::camera_numbers()[number];
  return std::string(text.name) + (text.unit == "px" ? "_px" : "");
}

/// What each module that sees this topic takes of the camera. `without_lens`: those that know no distortion.
std::vector<OverlayParam> params_for(const RobotFile& robot, const rt::ModuleTypes& types, const std::string& topic,
                                     const CameraFit& fit, std::vector<std::string>& without_lens) {
  std::vector<OverlayParam> params;
  each_reader(robot, types, topic, [&](const std::string& module, const rt::Declaration& declaration) {
    if (!rt::find_param(declaration, "fx_px")) return;
    bool lens = false;
    for (std::size_t i = 0; i < kCameraNumbers; ++i) {
      if (!rt::find_param(declaration, param_of(i))) continue;
      params.push_back({module, param_of(i), fit.estimates[i].value, 0});
      lens = lens || i >= 4;
    }
    if (!lens) without_lens.push_back(module);
  });
  return params;
}

/// How far a pinhole without distortion is off at the outermost corner of the picture.
double bent_px(const CameraFit& fit, const RecordedBoards& boards) {
  double most = 0;
  for (const double u : {0.0, boards.width - 1.0})
    for (const double v : {0.0, boards.height - 1.0}) {
      const auto& c = fit.camera;
      math::LensDistortion::Xy at{(u - c.cx_px) / c.fx_px, (v - c.cy_px) / c.fy_px};
      if (!c.lens.straighten(at)) return std::numeric_limits<double>::infinity();
      most = std::max(most, std::hypot(c.cx_px + c.fx_px * at.x - u, c.cy_px + c.fy_px * at.y - v));
    }
  return most;
}

Json to_json(const CameraFit& fit, const RecordedBoards& boards) {
  const auto finite = [](double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); };
  Json json = {{"topic", boards.topic},
               {"width_px", boards.width},
               {"height_px", boards.height},
               {"pictures", boards.pictures},
               {"boards", boards.boards.size()},
               {"views", fit.views},
               {"points", fit.points},
               {"rms_px", fit.rms_px},
               {"held_out_rms_px", finite(fit.held_out_rms_px)},
               {"tilt_deg", fit.tilt_deg},
               {"reach", fit.reach}};
  for (std::size_t i = 0; i < kCameraNumbers; ++i) {
    const auto& text = identify::camera_numbers()[i];
    json["camera"][std::string(text.name)] = {{"value", fit.estimates[i].value},
                                              {"half_width_95", finite(fit.estimates[i].half_width)},
                                              {"unit", std::string(text.unit)},
                                              {"shown", fit.estimates[i].shown}};
  }
  json["unknown"] = fit.unknown;
  return json;
}

void tell(const CameraFit& fit, const RecordedBoards& boards) {
  put_text(fmt::format("{}: {} pictures of {} x {}, the board in {}; {} views that differ, {} corners\n", boards.topic,
                       boards.pictures, boards.width, boards.height, boards.boards.size(), fit.views, fit.points));
  for (std::size_t i = 0; i < kCameraNumbers; ++i) {
    const auto& text = identify::camera_numbers()[i];
    const auto& e = fit.estimates[i];
    if (e.shown)
      put_text(
          fmt::format("  {:<4}{:>11.5g} +- {:<9.3g}{:<4} {}\n", text.name, e.value, e.half_width, text.unit, text.doc));
  }
  put_text(fmt::format("  off by {:.3f} px RMS; in views that were not fitted by {:.3f} px\n", fit.rms_px,
                       fit.held_out_rms_px));
  for (const std::string& unknown : fit.unknown) put_text("  not shown: " + unknown + "\n");
}

}  // namespace

int calibrate_lens(const LensOptions& o, const rt::ModuleTypes& types) {
  const vision::BoardSize size{o.board[0], o.board[1]};
  std::optional<RecordedBoards> boards;
  RobotFile robot;
  {
    Progress progress("calibrate");
    const auto reader = open_recording(o.recording, progress);
    if (!reader) return kNotBegun;
    std::string why;
    boards = read_boards(*reader, o.topic, size, why);
    if (!boards) return fail(o.recording + ": " + why);
    if (const auto text = record::read_attachment(*reader, "robot.toml"))
      robot = parse_robot(*text, "robot.toml").robot;
  }
  const std::vector<SeenBoard> chosen = choose_boards(boards->boards, o.views);
  if (chosen.size() < 3)
    return fail(
        fmt::format("{}: a board of {} x {} inner corners is whole in {} of {} pictures, in {} that differ; at "
                    "least 3 are needed, 20 are good",
                    o.recording, size.columns, size.rows, boards->boards.size(), boards->pictures, chosen.size()),
        kFailed);
  const auto views = views_of(chosen, size.columns, o.square_m);
  const CameraFit fit = identify::fit_camera(
      views, {.width_px = static_cast<double>(boards->width), .height_px = static_cast<double>(boards->height)});
  if (!fit.problem.empty()) return fail(o.recording + ": " + fit.problem, kFailed);
  Json json = to_json(fit, *boards);
  if (!o.json) tell(fit, *boards);
  bool shown = true;
  for (std::size_t i = 0; i < 4; ++i) shown = shown && fit.estimates[i].shown;
  std::vector<std::string> without_lens;
  const auto params = params_for(robot, types, boards->topic, fit, without_lens);
  if (!without_lens.empty()) {
    const std::string said =
        fmt::format("{} of the robot file {} no distortion: off by up to {:.1f} px at the picture's corners",
                    fmt::join(without_lens, ", "), without_lens.size() > 1 ? "take" : "takes", bent_px(fit, *boards));
    json["remark"] = said;
    if (!o.json) put_text("  " + said + "\n");
  }
  if (params.empty() && !o.json)
    put_text("  no module of the robot file sees this topic and takes a camera's numbers\n");
  if (!o.picture.empty())
    if (const std::string why = draw_lens(o.picture, *boards, views, fit, kLonger); !why.empty())
      return fail(o.picture + ": " + why, kFailed);
  if (o.json) std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  if (!shown) return fail("focal lengths and centre are not all shown: nothing is written", kFailed);
  return write_params({o.file, o.params, o.json}, robot.graph.robot, params);
}

}  // namespace sinew::app
