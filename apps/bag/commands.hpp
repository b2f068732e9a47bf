#pragma once
#include "apps/bag/commands.hpp"
#include "apps/command/command.hpp"

namespace sinew::app {

void add_bag_commands(CLI::App& app, CommandContext& context);  // bag info, check, cat, ...: recorded files

}  // namespace sinew::app
