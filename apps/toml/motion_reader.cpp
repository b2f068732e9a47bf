#include "apps/toml/motion_reader.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "apps/toml/toml_guard.hpp"
#include "apps/toml/toml_resolver.hpp"
#include "math/elementary.hpp"

namespace sinew::app {
namespace {

using motion::JointAngles;
using motion::KeyPose;
using motion::MotionBook;
using motion::PoseCheck;

constexpr double kDegrees = math::kPi / 180;
constexpr std::pair<std::string_view, PoseCheck> kChecks[] = {{"none", PoseCheck::none},
                                                              {"upright", PoseCheck::upright},
                                                              {"on_front", PoseCheck::on_front},
                                                              {"on_back", PoseCheck::on_back}};

template <class T>
void read_params(TomlReader& r, std::span<const motion::Param<T>> table, T& out) {
  for (const motion::Param<T>& row : table) r.read(row.name, out.*row.value, row.least, row.most);
  r.finish();
}

/// Angles in degrees by the names of joints.
void read_angles(TomlReader& r, const kinematics::Body& body, JointAngles& out) {
  for (std::size_t j = 0; j < body.joints(); ++j) {
    const kinematics::Link& link = body.links[j + 1];
    const double least = link.least_rad / kDegrees - 1e-9, most = link.most_rad / kDegrees + 1e-9;
    double deg = 0;
    if (link.name.starts_with("l_") || link.name.starts_with("r_"))
      if (r.read(link.name.substr(2), deg, least, most)) out[j] = deg * kDegrees;
    if (r.read(link.name, deg, least, most)) out[j] = deg * kDegrees;
  }
  r.finish();
}

void read_poses(TomlReader& r, const kinematics::Body& body, const JointAngles& rest_rad, std::vector<KeyPose>& out) {
  JointAngles before = rest_rad;
  r.array_of_tables("pose", [&](TomlReader& p) {
    KeyPose pose;
    pose.rad = before;
    p.require("name", pose.name);
    p.read("duration_s", pose.duration_s, 0, 10);
    p.read("hold_s", pose.hold_s, 0, 10);
    p.read_choice("check", pose.check, kChecks);
    p.table("deg", [&](TomlReader& angles) { read_angles(angles, body, pose.rad); });
    p.finish();
    before = pose.rad;
    out.push_back(std::move(pose));
  });
  r.finish();
  if (out.empty()) r.missing("pose", "at least one pose");
}

template <class T>
std::string params_text(std::string_view name, std::span<const motion::Param<T>> table, const T& params) {
  std::string out = fmt::format("\n[{}]\n", name);
  const T standard{};
  for (const motion::Param<T>& row : table)
    if (params.*row.value != standard.*row.value)
      out += fmt::format("{} = {:.6g}  # {}: {}\n", row.name, params.*row.value, row.unit, row.doc);
  return out;
}

/// Joints whose angle differs from `before`, mirrored ones together.
std::string angles_text(const JointAngles& rad, const JointAngles& before, const kinematics::Body& body,
                        std::string_view between) {
  std::string out;
  const auto add = [&](std::string_view name, double value) {
    out += fmt::format("{}{} = {:.2f}", out.empty() ? "" : between, name, value / kDegrees);
  };
  for (std::size_t j = 0; j < body.joints(); ++j) {
    const std::string& name = body.links[j + 1].name;
    const auto mirrored = [&](std::string_view prefix) {
      return body.find_link(std::string(prefix) + name.substr(2)).value_or(0);
    };
    if (name.starts_with("l_") && mirrored("r_") > 0) {
      const std::size_t k = mirrored("r_") - 1;
      if (rad[j] == rad[k]) {
        if (rad[j] != before[j] || rad[k] != before[k]) add(name.substr(2), rad[j]);
        continue;
      }
    } else if (name.starts_with("r_") && mirrored("l_") > 0 && rad[mirrored("l_") - 1] == rad[j]) {
      continue;
    }
    if (rad[j] != before[j]) add(name, rad[j]);
  }
  return out;
}

}  // namespace

void read_motions(TomlReader& root, const kinematics::Body& body, MotionBook& book) {
  root.table("rest_deg", [&](TomlReader& r) { read_angles(r, body, book.rest_rad); });
  root.table("walk", [&](TomlReader& r) { read_params<motion::WalkParams>(r, motion::kWalkParams, book.walk); });
  root.table("fall", [&](TomlReader& r) { read_params<motion::FallParams>(r, motion::kFallParams, book.fall); });
  const auto read_kick = [&](const std::string& name, motion::KickParams& kick, motion::StepKickParams& in_step) {
    root.table(name, [&](TomlReader& r) { read_params<motion::KickParams>(r, motion::kKickParams, kick); });
    root.table("step_" + name,
               [&](TomlReader& r) { read_params<motion::StepKickParams>(r, motion::kStepKickParams, in_step); });
  };
  read_kick("kick_forward", book.kick_forward, book.step_kick_forward);
  read_kick("kick_outward", book.kick_outward, book.step_kick_outward);
  root.table("stop",
             [&](TomlReader& r) { read_params<motion::BallStopParams>(r, motion::kBallStopParams, book.stop); });
  root.table("gaze", [&](TomlReader& r) { read_params<motion::GazeParams>(r, motion::kGazeParams, book.gaze); });
  root.tables_by_name(
      "motion", [&](const std::string& name, TomlReader& r) { read_poses(r, body, book.rest_rad, book.poses[name]); });
  root.finish();
}

LoadedMotions parse_motions(std::string_view text, const std::string& path, const kinematics::Body& body) {
  LoadedMotions loaded;
  const auto parsed = parse_toml(text, path, loaded.problems);
  if (!parsed) return loaded;
  TomlReader root(*parsed, "", loaded.problems);
  read_motions(root, body, loaded.book);
  return loaded;
}

LoadedMotions load_motions(const std::string& path, const kinematics::Body& body) {
  std::ifstream in(path, std::ios::binary);
  if (std::error_code none; !in || std::filesystem::is_directory(path, none)) {
    LoadedMotions loaded;
    loaded.problems.push_back({0, "file", path, "a file of motions that can be read"});
    return loaded;
  }
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const toml::parse_result parsed = line_beyond_ascii(text) == 0 ? toml::parse(text, path) : toml::parse("");
  if (!parsed || !parsed.table().contains("extends")) return parse_motions(text, path, body);
  TomlResolver resolver;
  LoadedMotions loaded;
  if (const auto all = resolver.merged(text, path)) {
    resolver.write(*all, "# " + path + " with all that it extends", path);
    loaded = parse_motions(resolver.result().text, path, body);
  } else {
    loaded.problems = std::move(resolver.result().problems);
  }
  resolver.place_lines(loaded.problems);
  return loaded;
}

std::string motions_text(const MotionBook& book, const kinematics::Body& body, const std::string& about) {
  std::string out = about;
  out += "\n[rest_deg]\n";
  out += angles_text(book.rest_rad, JointAngles{}, body, "\n") + '\n';
  out += params_text<motion::WalkParams>("walk", motion::kWalkParams, book.walk);
  out += params_text<motion::FallParams>("fall", motion::kFallParams, book.fall);
  out += params_text<motion::KickParams>("kick_forward", motion::kKickParams, book.kick_forward);
  out += params_text<motion::KickParams>("kick_outward", motion::kKickParams, book.kick_outward);
  out += params_text<motion::StepKickParams>("step_kick_forward", motion::kStepKickParams, book.step_kick_forward);
  out += params_text<motion::StepKickParams>("step_kick_outward", motion::kStepKickParams, book.step_kick_outward);
  out += params_text<motion::BallStopParams>("stop", motion::kBallStopParams, book.stop);
  out += params_text<motion::GazeParams>("gaze", motion::kGazeParams, book.gaze);
  for (const auto& [name, poses] : book.poses) {
    JointAngles before = book.rest_rad;
    for (const KeyPose& pose : poses) {
      out +=
          fmt::format("\n[[motion.{}.pose]]\nname = \"{}\"\nduration_s = {:.6g}\n", name, pose.name, pose.duration_s);
      if (pose.hold_s > 0) out += fmt::format("hold_s = {:.6g}\n", pose.hold_s);
      for (const auto& [word, check] : kChecks)
        if (pose.check == check && check != PoseCheck::none) out += fmt::format("check = \"{}\"\n", word);
      out += fmt::format("deg = {{ {} }}\n", angles_text(pose.rad, before, body, ", "));
      before = pose.rad;
    }
  }
  return out;
}

}  // namespace sinew::app
