#pragma once
#include "apps/command/command.hpp"
#include "apps/live/commands.hpp"

namespace sinew::app {

void add_live_commands(CLI::App& app, CommandContext& context);  // list, status, stop, arm, disarm, module, thread
void add_top_command(CLI::App& app, CommandContext& context);
void add_topic_commands(CLI::App& app, CommandContext& context);
void add_param_commands(CLI::App& app, CommandContext& context);
void add_record_commands(CLI::App& app, CommandContext& context);  // record start, stop, status, snapshot

}  // namespace sinew::app
