#pragma once
// Describes the options of commands for a running robot.
#include <CLI/CLI.hpp>

#include "apps/command/command.hpp"
#include "apps/command/number_check.hpp"
#include "apps/live/live_robot.hpp"

namespace sinew::app {

/// A command of `parent` whose options are an O (LiveOptions and more), with --robot and --json. `run` gets the options
/// after the whole command line was parsed; add further arguments to the result.
template <class O>
struct LiveCommand {
  CLI::App& app;
  O& options;
};

template <class O>
LiveCommand<O> live_command(CLI::App& parent, CommandContext& context, const char* name, const char* text,
                            int (*run)(const O&)) {
  const auto options = std::make_shared<O>();
  CLI::App& app = *parent.add_subcommand(name, text);
  app.add_option("--robot", options->robot, "which one; needed when several run")->type_name(kRobotHint);
  app.add_option("--wait", options->wait_s, "wait for it to run, at most so long")->check(number(0))->type_name("S");
  app.add_flag("--json", options->json, "as JSON");
  app.callback([&context, options, run] { context.action = [options, run] { return run(*options); }; });
  return {app, *options};
}

}  // namespace sinew::app
