#pragma once
// The groups of commands, for command_line.cpp only. Each adds its subcommands; the one that was asked for sets
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
  std::function<int()> action{};  // called when the whole command line has been understood
};

void add_robot_commands(CLI::App& app, CommandContext& context);    // run, check, graph
void add_project_commands(CLI::App& app, CommandContext& context);  // new, completion

/// The type name that an argument or option declares says what completes it: kFileHint a file, and so on. Choices are
/// written as "{one,two}".
inline constexpr const char *kRobotFileHint = "FILE.toml", *kFileHint = "FILE", *kFolderHint = "DIR";

/// Says why on standard error; answers `code`.
int fail(const std::string& why, int code = kNotBegun);

}  // namespace sinew::app
