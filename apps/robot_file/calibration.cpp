#include "apps/robot_file/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "apps/toml/toml_reader.hpp"
#include "hal/did_you_mean.hpp"
#include "rt/parameters.hpp"

namespace sinew::app {
namespace {

constexpr std::string_view kNameLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";

// A name as a key in a TOML header.
std::string toml_key(const std::string& name) {
  return name.empty() || name.find_first_not_of(kNameLetters) != std::string::npos ? '"' + name + '"' : name;
}

void read_device_keys(const std::string& device, const std::string& joint, TomlReader& r, Calibration& out) {
  for (const auto& [key, node] : r.raw()) {
    if (joint.empty() && key.str() == "joint") continue;
    r.take(key.str());
    CalibratedKey k{device, joint, std::string(key.str()), {}, line_of(node)};
    if (read_param_value(node, k.value))
      out.keys.push_back(std::move(k));
    else
      r.problem(node, key.str(), "a boolean, a number or a string");
  }
}

void read_module(const std::string& module, TomlReader& r, Calibration& out) {
  for (const auto& [key, node] : r.raw()) {
    r.take(key.str());
    OverlayParam p{module, std::string(key.str()), {}, line_of(node)};
    if (read_param_value(node, p.value))
      out.params.params.push_back(std::move(p));
    else
      r.problem(node, key.str(), "a boolean, a number or a string");
  }
}

drivers::DeviceSpec* find(std::vector<drivers::DeviceSpec>& all, const std::string& name) {
  const auto it = std::find_if(all.begin(), all.end(), [&](const auto& d) { return d.name == name; });
  return it == all.end() ? nullptr : &*it;
}

std::string path_of(const CalibratedKey& k) {
  return "device." + k.device + (k.joint.empty() ? "" : ".joint." + k.joint) + '.' + k.key;
}

std::string names_for(const std::string& asked, const std::vector<drivers::DeviceSpec>& all) {
  std::string text;
  std::vector<std::string> names;
  for (const auto& d : all) text += (text.empty() ? "" : ", ") + d.name, names.push_back(d.name);
  return text.empty() ? "it has none" : "one of " + text + hal::did_you_mean(asked, names);
}

}  // namespace

Calibration parse_calibration(std::string_view text, const std::string& path) {
  Calibration c;
  const auto parsed = parse_toml(text, path, c.problems);
  if (!parsed) return c;
  TomlReader root(*parsed, "", c.problems);
  root.tables_by_name("device", [&](const std::string& device, TomlReader& r) {
    read_device_keys(device, "", r, c);
    r.tables_by_name("joint", [&](const std::string& joint, TomlReader& j) { read_device_keys(device, joint, j, c); });
  });
  root.tables_by_name("module", [&](const std::string& module, TomlReader& r) { read_module(module, r, c); });
  root.finish();
  const auto by_line = [](const auto& a, const auto& b) { return a.line < b.line; };  // toml++ sorts tables by name
  std::stable_sort(c.keys.begin(), c.keys.end(), by_line);
  std::stable_sort(c.params.params.begin(), c.params.params.end(), by_line);
  return c;
}

int Calibration::line_of(std::string_view path) const {
  for (const CalibratedKey& k : keys) {
    if (path == path_of(k)) return k.line;
  }
  return 0;
}

std::vector<rt::Problem> apply_calibration(const Calibration& calibration, const rt::ModuleTypes& types,
                                           RobotFile& robot) {
  std::vector<rt::Problem> problems = calibration.problems;
  for (const CalibratedKey& k : calibration.keys) {
    const std::string path = path_of(k), value = rt::to_string(k.value);
    drivers::DeviceSpec* device = find(robot.devices.devices, k.device);
    if (!device) {
      problems.push_back(
          {k.line, path, value, "a key of a device of the robot file: " + names_for(k.device, robot.devices.devices)});
      continue;
    }
    drivers::DeviceSpec* target = k.joint.empty() ? device : find(device->joints, k.joint);
    if (!target) {
      problems.push_back(
          {k.line, path, value, "a key of a joint of this device: " + names_for(k.joint, device->joints)});
      continue;
    }
    target->keys[k.key] = {k.value, k.line};
  }
  for (rt::Problem& p : apply_overlay(calibration.params, types, robot.graph)) {
    p.key = "module." + p.key;
    problems.push_back(std::move(p));
  }
  return problems;
}

std::string calibration_path(const RobotFile& robot) {
  if (robot.calibration.value.empty()) return {};
  const std::filesystem::path file(robot.calibration.value);
  return file.is_absolute() ? file.string() : (std::filesystem::path(robot.path).parent_path() / file).string();
}

std::string calibration_text(std::string_view robot, const Calibration& calibration) {
  std::string text =
      fmt::format("# Calibration of one {}: `robot.calibration` of its robot file names this file.\n", robot);
  std::string header;
  const auto put = [&](const std::string& section, const std::string& key, const rt::ParamValue& value) {
    if (section != header) text += fmt::format("\n[{}]\n", header = section);
    text += fmt::format("{} = {}\n", toml_key(key), toml_value(value));
  };
  auto keys = calibration.keys;
  std::stable_sort(keys.begin(), keys.end(), [](const auto& a, const auto& b) {
    return std::tie(a.device, a.joint) < std::tie(b.device, b.joint);
  });
  for (const CalibratedKey& k : keys)
    put("device." + toml_key(k.device) + (k.joint.empty() ? "" : ".joint." + toml_key(k.joint)), k.key, k.value);
  auto params = calibration.params.params;
  std::stable_sort(params.begin(), params.end(), [](const auto& a, const auto& b) { return a.module < b.module; });
  for (const OverlayParam& p : params) put("module." + toml_key(p.module), p.param, p.value);
  return text;
}

}  // namespace sinew::app
