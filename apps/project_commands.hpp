#pragma once
#include "apps/command/command.hpp"

namespace sinew::app {

void add_project_commands(CLI::App& app, CommandContext& context);  // new, completion

}  // namespace sinew::app
