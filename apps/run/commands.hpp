#pragma once
#include "apps/command/command.hpp"
#include "apps/run/commands.hpp"

namespace sinew::app {

void add_robot_commands(CLI::App& app, CommandContext& context);  // run, check, graph
void add_devices_command(CLI::App& app, CommandContext& context);
void add_servo_command(CLI::App& app, CommandContext& context);

}  // namespace sinew::app
