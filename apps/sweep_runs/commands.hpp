#pragma once
#include "apps/command/command.hpp"

namespace sinew::app {

void add_sweep_commands(CLI::App& app, CommandContext& context);  // sweep, merge

}  // namespace sinew::app
