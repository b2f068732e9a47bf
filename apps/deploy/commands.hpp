#pragma once
#include "apps/command/command.hpp"
#include "apps/deploy/commands.hpp"

namespace sinew::app {

void add_deploy_command(CLI::App& app, CommandContext& context);

}  // namespace sinew::app
