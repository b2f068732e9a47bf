// list, status, stop, arm, disarm, module, thread: a running robot as a whole.
#include <fmt/format.h>

#include <cstdio>

#include "apps/live/commands.hpp"
#include "apps/live/live_command.hpp"
#include "apps/live/status_text.hpp"
#include "apps/view/graph_text.hpp"
#include "apps/view/reference_text.hpp"
#include "hal/did_you_mean.hpp"
#include "rt/module_types.hpp"

namespace sinew::app {
namespace {

struct ModuleOptions : LiveOptions {
  std::string module;
};

struct ModuleInfoOptions {
  std::string type;
  bool json = false;
};

struct PeriodOptions : LiveOptions {
  std::string thread;
  double period_us = 0;
};

int list_robots(const LiveOptions& options) {
  std::string why;
  const auto all = tap::running(why);
  if (!all) return fail(why);
  Json json = Json::array();
  std::string text = fmt::format("{:<24} {:>8}  {}\n", "robot", "process", "socket");
  for (const auto& r : *all) {
    json.push_back({{"robot", r.robot}, {"pid", r.pid}, {"socket", r.path}});
    text += fmt::format("{:<24} {:>8}  {}\n", r.robot, r.pid, r.path);
  }
  if (options.json)
    std::printf("%s", to_line({{"robots", json}}).c_str());
  else if (all->empty())
    std::printf("no robot runs\n");
  else
    std::printf("%s", text.c_str());
  return kDone;
}

int status(const LiveOptions& options) {
  auto robot = LiveRobot::find(options);
  if (!robot) return kNotBegun;
  const auto hello = robot->ask("hello");
  const auto reply = hello ? robot->ask("status") : std::nullopt;
  if (!reply) return kFailed;
  Json all = *hello;
  all.update(*reply);
  all.erase("ok");
  std::printf("%s", (options.json ? to_line(all) : status_text(all)).c_str());
  return kDone;
}

// The step from which a change takes effect, as text.
std::string effect_text(const Json& reply) {
  const auto step = reply.find("step");
  if (step == reply.end()) return {};
  return step->is_number() ? fmt::format(", from step {} on", step->dump()) : ", as soon as its thread runs";
}

// Requests a change; prints the reply as JSON, or `done` and when it takes effect.
int change(const LiveOptions& options, const char* request, const Json& arguments, const std::string& done) {
  auto robot = LiveRobot::find(options);
  if (!robot) return kNotBegun;
  auto reply = robot->ask(request, arguments);
  if (!reply) return kFailed;
  reply->erase("ok");
  if (options.json)
    std::printf("%s", to_line(*reply).c_str());
  else
    std::printf("%s: %s%s\n", robot->name().c_str(), done.c_str(), effect_text(*reply).c_str());
  return kDone;
}

int stop(const LiveOptions& o) { return change(o, "stop", Json::object(), "ends its run"); }
int arm(const LiveOptions& o) { return change(o, "arm", Json::object(), "armed"); }
int disarm(const LiveOptions& o) { return change(o, "disarm", Json::object(), "disarmed"); }

int enable(const ModuleOptions& o) {
  return change(o, "module.enable", {{"module", o.module}}, "module " + o.module + " enabled");
}

int disable(const ModuleOptions& o) {
  return change(o, "module.disable", {{"module", o.module}}, "module " + o.module + " disabled");
}

int period(const PeriodOptions& o) {
  return change(o, "thread.period", {{"thread", o.thread}, {"period_us", o.period_us}},
                fmt::format("thread {} every {} us", o.thread, o.period_us));
}

int list_modules(const LiveOptions& options) {
  auto robot = LiveRobot::find(options);
  if (!robot) return kNotBegun;
  const auto reply = robot->ask("status");
  if (!reply) return kFailed;
  if (options.json)
    std::printf("%s", to_line({{"modules", reply->at("modules")}}).c_str());
  else
    std::printf("%s", module_table(*reply).c_str());
  return kDone;
}

/// The type that is meant: its whole name, or the part behind "::" if only one type ends so. Empty: none or several.
std::string type_named(const std::vector<std::string>& all, const std::string& name) {
  std::string found;
  for (const std::string& type : all) {
    if (type == name) return type;
    if (!type.ends_with("::" + name)) continue;
    if (!found.empty()) return {};
    found = type;
  }
  return found;
}

int module_info(const rt::ModuleTypes& types, const ModuleInfoOptions& options) {
  const auto all = types.names();
  if (options.type.empty()) {
    if (options.json) {
      Json modules = Json::array();
      for (const std::string& type : all) modules.push_back(module_json(type, *declaration_of(types, type)));
      std::printf("%s", to_line({{"modules", modules}}).c_str());
    }
    for (const std::string& type : all)
      if (!options.json) std::printf("%s\n", type.c_str());
    return kDone;
  }
  const std::string type = type_named(all, options.type);
  const auto declaration = declaration_of(types, type);
  if (!declaration)
    return fail(options.type + ": no such type of module; `module info` lists them" +
                hal::did_you_mean(options.type, all));
  std::printf(
      "%s", options.json ? to_line(module_json(type, *declaration)).c_str() : module_text(type, *declaration).c_str());
  return kDone;
}

}  // namespace

void add_live_commands(CLI::App& app, CommandContext& context) {
  live_command(app, context, "list", "the robots that run on this machine", list_robots);
  live_command(app, context, "status", "the state of a running robot", status);
  live_command(app, context, "stop", "end its run, as Ctrl-C would", stop);
  live_command(app, context, "arm", "permit its actuators to move; prints every reason against it", arm);
  live_command(app, context, "disarm", "stop its actuators", disarm);

  CLI::App& module = *app.add_subcommand("module", "modules of a running robot, and types of modules");
  module.require_subcommand(1);
  const auto about = std::make_shared<ModuleInfoOptions>();
  CLI::App& info =
      *module.add_subcommand("info", "ports and parameters of a type of module, or all types; no robot runs");
  info.add_option("type", about->type, "e.g. control::PositionControl")->type_name("TYPE");
  info.add_flag("--json", about->json, "as JSON");
  info.callback(
      [&context, about] { context.action = [&types = context.types, about] { return module_info(types, *about); }; });
  live_command(module, context, "list", "what each module did so far", list_modules);
  auto on = live_command(module, context, "enable", "reset it, and step it again", enable);
  on.app.add_option("module", on.options.module)->required()->type_name(kModuleHint);
  auto off = live_command(module, context, "disable", "stop stepping it", disable);
  off.app.add_option("module", off.options.module)->required()->type_name(kModuleHint);

  CLI::App& thread = *app.add_subcommand("thread", "threads of a running robot");
  thread.require_subcommand(1);
  auto command = live_command(thread, context, "period", "change the period of a periodic thread", period);
  command.app.add_option("thread", command.options.thread)->required()->type_name(kThreadHint);
  command.app.add_option("period_us", command.options.period_us, "microseconds")->required()->type_name("US");
}

}  // namespace sinew::app
