// param list, get, set, save.
#include <fmt/format.h>

#include <cstdio>
#include <fstream>

#include "apps/live/commands.hpp"
#include "apps/live/live_command.hpp"
#include "apps/robot_file/param_overlay.hpp"
#include "apps/robot_file/param_value.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "hal/did_you_mean.hpp"

namespace sinew::app {
namespace {

struct ListOptions : LiveOptions {
  std::string module;
};

struct ParamOptions : LiveOptions {
  std::string param, value;
};

struct SaveOptions : LiveOptions {
  std::string file;
};

// Splits "module.param"; false after printing that it has another form.
bool split(const std::string& name, std::string& module, std::string& param) {
  const auto dot = name.find('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == name.size()) {
    fail(name + ": MODULE.PARAM");
    return false;
  }
  module = name.substr(0, dot), param = name.substr(dot + 1);
  return true;
}

std::string value_text(const Json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

std::string param_name(const Json& p) { return p.value("module", "") + "." + p.value("param", ""); }

int list_params(const ListOptions& options) {
  auto robot = LiveRobot::find(options);
  if (!robot) return kNotBegun;
  const auto reply = robot->ask("params", options.module.empty() ? Json::object() : Json{{"module", options.module}});
  if (!reply) return kFailed;
  if (options.json) {
    std::printf("%s", to_line({{"params", reply->at("params")}}).c_str());
    return kDone;
  }
  std::printf("%s", fmt::format("{:<32} {:>12} {:<8} {}\n", "parameter", "value", "unit", "allowed").c_str());
  for (const Json& p : reply->at("params"))
    std::printf("%s", fmt::format("{:<32} {:>12} {:<8} {}\n", param_name(p), value_text(p.value("value", Json())),
                                  p.value("unit", ""), p.value("allowed", ""))
                          .c_str());
  return kDone;
}

// One parameter of a robot; nothing after printing why.
std::optional<Json> find_param(LiveRobot& robot, const std::string& module, const std::string& param) {
  const auto reply = robot.ask("params", {{"module", module}});
  if (!reply) return std::nullopt;
  std::string known;
  std::vector<std::string> names;
  for (const Json& p : reply->at("params")) {
    if (p.value("param", "") == param) return p;
    names.push_back(p.value("param", ""));
    known += " " + names.back();
  }
  fail("robot " + robot.name() + ": module " + module + " has no parameter " + param +
       (known.empty() ? "; it has none" : "; it has" + known + hal::did_you_mean(param, names)));
  return std::nullopt;
}

int get(const ParamOptions& options) {
  std::string module, param;
  if (!split(options.param, module, param)) return kNotBegun;
  auto robot = LiveRobot::find(options);
  if (!robot) return kNotBegun;
  const auto found = find_param(*robot, module, param);
  if (!found) return kFailed;
  std::printf("%s",
              options.json ? to_line(*found).c_str() : (value_text(found->value("value", Json())) + "\n").c_str());
  return kDone;
}

int set(const ParamOptions& options) {
  std::string module, param;
  if (!split(options.param, module, param)) return kNotBegun;
  auto robot = LiveRobot::find(options);
  if (!robot) return kNotBegun;
  const Json value = std::visit([](const auto& v) { return Json(v); }, param_value(options.value));
  auto reply = robot->ask("param.set", {{"module", module}, {"param", param}, {"value", value}});
  if (!reply) return kFailed;
  reply->erase("ok");
  const Json step = reply->value("step", Json());
  if (options.json)
    std::printf("%s", to_line(*reply).c_str());
  else if (step.is_number())
    std::printf("%s = %s from step %s of %s on\n", options.param.c_str(), options.value.c_str(), step.dump().c_str(),
                module.c_str());
  else
    std::printf("%s = %s as soon as the thread of %s runs\n", options.param.c_str(), options.value.c_str(),
                module.c_str());
  return kDone;
}

// The value of a parameter by the robot file; the default where the file does not set it.
Json value_in_file(const RobotFile& file, const Json& p) {
  for (const auto& m : file.graph.modules) {
    if (m.name != p.value("module", "")) continue;
    const auto at = m.params.find(p.value("param", ""));
    if (at != m.params.end()) return std::visit([](const auto& v) { return Json(v); }, at->second.value);
  }
  return p.value("default", Json());
}

rt::ParamValue value_of(const Json& p) {
  const Json& v = p.at("value");
  const std::string type = p.value("type", "");
  if (v.is_boolean()) return v.get<bool>();
  if (v.is_string()) return v.get<std::string>();
  if (type == "integer") return v.get<std::int64_t>();
  return v.get<double>();
}

int save(const SaveOptions& options) {
  auto robot = LiveRobot::find(options);
  if (!robot) return kNotBegun;
  const auto hello = robot->ask("hello");
  const auto reply = hello ? robot->ask("params") : std::nullopt;
  if (!reply) return kFailed;
  const std::string robot_file = hello->value("robot_file", "");
  const LoadedRobot file = load_robot(robot_file);
  if (!file.problems.empty())
    return fail(to_string(file.problems.front(), file.robot) + "; without its robot file it is not known what differs",
                kFailed);
  std::vector<OverlayParam> differing;
  for (const Json& p : reply->at("params"))
    if (p.at("value") != value_in_file(file.robot, p))
      differing.push_back({p.value("module", ""), p.value("param", ""), value_of(p)});
  std::ofstream out(options.file, std::ios::binary);
  out << overlay_text(robot->name(), differing);
  out.close();
  if (!out) return fail(options.file + ": cannot be written", kFailed);
  if (options.json)
    std::printf("%s",
                to_line({{"file", options.file}, {"robot_file", robot_file}, {"params", differing.size()}}).c_str());
  else
    std::printf("%s: %zu parameter%s differ%s from %s\n", options.file.c_str(), differing.size(),
                differing.size() == 1 ? "" : "s", differing.size() == 1 ? "s" : "", robot_file.c_str());
  return kDone;
}

}  // namespace

void add_param_commands(CLI::App& app, CommandContext& context) {
  CLI::App& param = *app.add_subcommand("param", "parameters of a running robot");
  param.require_subcommand(1);
  auto list = live_command(param, context, "list", "all, or those of one module", list_params);
  list.app.add_option("module", list.options.module)->type_name(kModuleHint);

  auto one = live_command(param, context, "get", "the present value", get);
  one.app.add_option("param", one.options.param)->required()->type_name(kParamHint);

  auto change = live_command(param, context, "set", "change it; prints the step from which it holds", set);
  change.app.add_option("param", change.options.param)->required()->type_name(kParamHint);
  change.app.add_option("value", change.options.value, "true, 3, 0.5 or a text")->required()->type_name("VALUE");

  auto keep = live_command(param, context, "save", "write what differs from the robot file, for run --params", save);
  keep.app.add_option("file", keep.options.file)->required()->type_name(kFileHint);
}

}  // namespace sinew::app
