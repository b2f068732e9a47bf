#pragma once
#include "apps/command/command.hpp"

namespace sinew::app {

void add_match_command(CLI::App& app, CommandContext& context);

}  // namespace sinew::app
