#include "apps/command_line.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <variant>

#include "apps/bag/commands.hpp"
#include "apps/bag/recorded_names.hpp"
#include "apps/calibrate/commands.hpp"
#include "apps/command/usage_error.hpp"
#include "apps/completion.hpp"
#include "apps/deploy/commands.hpp"
#include "apps/grab/grab_command.hpp"
#include "apps/identify/commands.hpp"
#include "apps/live/commands.hpp"
#include "apps/live/running_names.hpp"
#include "apps/match/commands.hpp"
#include "apps/monitor/monitor_options.hpp"
#include "apps/net/net_command.hpp"
#include "apps/project_commands.hpp"
#include "apps/replay/commands.hpp"
#include "apps/run/commands.hpp"
#include "apps/sweep_runs/commands.hpp"
#include "apps/team/commands.hpp"

namespace sinew::app {

namespace {

/// The action of the command line, or else the exit code. Frees its description of all commands on return, since a
/// robot locks its memory.
std::variant<std::function<int()>, int> understood(int argc, char** argv, const rt::ModuleTypes& types) {
  const std::string path = argc > 0 ? argv[0] : "sinew";
  CLI::App app("Sinew: an embedded real-time runtime for the onboard computers of humanoids and UAVs.",
               path.substr(path.rfind('/') + 1));
  app.require_subcommand(1);
  app.set_version_flag("--version", version());
  app.footer("Exit codes: 0 done, 1 failed, 2 could not begin.");
  CommandContext context{types};
  add_robot_commands(app, context);
  add_live_commands(app, context);
  add_top_command(app, context);
  add_topic_commands(app, context);
  add_param_commands(app, context);
  add_record_commands(app, context);
  add_bag_commands(app, context);
  add_monitor_command(app, context);
  add_net_command(app, context);
  add_grab_command(app, context);
  add_replay_command(app, context);
  add_tune_command(app, context);
  add_identify_command(app, context);
  add_sweep_commands(app, context);
  add_team_command(app, context);
  add_match_command(app, context);
  add_calibrate_command(app, context);
  add_devices_command(app, context);
  add_servo_command(app, context);
  add_deploy_command(app, context);
  add_project_commands(app, context);
  if (argc > 1 && std::string_view(argv[1]) == kCompleteCommand) {
    const auto names = [](std::string_view hint, const NamedBefore& before) {
      if (hint == kSettingHint) return running_names(hint, before.first);
      return before.file.empty() ? running_names(hint, before.robot) : recorded_names(hint, before.file, before.topic);
    };
    for (const auto& line : completions(app, {argv + 2, argv + argc}, names)) std::printf("%s\n", line.c_str());
    return kDone;
  }
  if (argc > 1 && argv[1][0] != '-' &&
      app.get_subcommands([&](CLI::App* c) { return c->get_name() == argv[1]; }).empty())
    return fail(no_such_command(app, argv[1]));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) return fail(usage_error(app, e));
    app.exit(e);  // prints the help
    return kDone;
  }
  return context.action;
}

}  // namespace

int command_line(int argc, char** argv, const rt::ModuleTypes& types, const Place& place) {
  set_place(place);
  const auto asked = understood(argc, argv, types);
  if (const int* code = std::get_if<int>(&asked)) return *code;
  return std::get<0>(asked)();
}

}  // namespace sinew::app
