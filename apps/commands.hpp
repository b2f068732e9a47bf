#pragma once
// The groups of commands, for the files that describe them. Each adds its subcommands; the one that was asked for sets
// `action`.
#include <functional>
#include <string>

#include "rt/module_types.hpp"

namespace CLI {
class App;
}

namespace sinew::app {

inline constexpr int kDone = 0, kFailed = 1, kNotBegun = 2;  // exit codes of every command

struct CommandContext {
  const rt::ModuleTypes& types;
  std::function<int()> action{};  // called when the whole command line has been understood; outlives all CLI::App
};

void add_robot_commands(CLI::App& app, CommandContext& context);    // run, check, graph
void add_project_commands(CLI::App& app, CommandContext& context);  // new, completion
void add_live_commands(CLI::App& app, CommandContext& context);     // list, status, stop, arm, disarm, module, thread
void add_top_command(CLI::App& app, CommandContext& context);
void add_topic_commands(CLI::App& app, CommandContext& context);
void add_param_commands(CLI::App& app, CommandContext& context);
void add_record_commands(CLI::App& app, CommandContext& context);  // record start, stop, status, snapshot
void add_bag_commands(CLI::App& app, CommandContext& context);     // bag info, check, cat, ...: recorded files
void add_replay_command(CLI::App& app, CommandContext& context);
void add_calibrate_command(CLI::App& app, CommandContext& context);  // calibrate imu, joint
void add_devices_command(CLI::App& app, CommandContext& context);
void add_deploy_command(CLI::App& app, CommandContext& context);
void add_tune_command(CLI::App& app, CommandContext& context);

/// The type name that an argument or option declares says what completes it: kFileHint a file, and so on. Choices are
/// written as "{one,two}".
inline constexpr const char *kRobotFileHint = "FILE.toml", *kFileHint = "FILE", *kFolderHint = "DIR";
inline constexpr const char *kRobotHint = "ROBOT", *kTopicHint = "TOPIC", *kExternalHint = "EXTERNAL",
                            *kModuleHint = "MODULE", *kParamHint = "MODULE.PARAM", *kThreadHint = "THREAD";

/// Says why on standard error; answers `code`.
int fail(const std::string& why, int code = kNotBegun);

}  // namespace sinew::app
