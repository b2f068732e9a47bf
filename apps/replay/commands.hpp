#pragma once
#include "apps/command/command.hpp"
#include "apps/replay/commands.hpp"

namespace sinew::app {

void add_replay_command(CLI::App& app, CommandContext& context);
void add_tune_command(CLI::App& app, CommandContext& context);

}  // namespace sinew::app
