#pragma once
#include "apps/run/commands.hpp"
#include "apps/command/command.hpp"

namespace sinew::app {

void add_robot_commands(CLI::App& app, CommandContext& context);  // run, check, graph
void add_devices_command(CLI::App& app, CommandContext& context);

}  // namespace sinew::app
