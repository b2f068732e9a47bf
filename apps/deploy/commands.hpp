#pragma once
#include "apps/deploy/commands.hpp"
#include "apps/command/command.hpp"

namespace sinew::app {

void add_deploy_command(CLI::App& app, CommandContext& context);

}  // namespace sinew::app
