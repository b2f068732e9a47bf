#pragma once
// Shared by all commands. Each room of commands adds its commands to the CLI::App (commands.hpp of that room); the
// command that the user chose sets `action`.
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

/// The type name of an argument or option says how the shell completes it: kFileHint with a file, and so on. Choices
/// are written as "{one,two}".
inline constexpr const char *kRobotFileHint = "FILE.toml", *kFileHint = "FILE", *kFolderHint = "DIR";
inline constexpr const char *kRobotHint = "ROBOT", *kTopicHint = "TOPIC", *kExternalHint = "EXTERNAL",
                            *kModuleHint = "MODULE", *kParamHint = "MODULE.PARAM", *kThreadHint = "THREAD";

/// Version of this Sinew: "0.1.0".
std::string version();

/// Prints why on standard error; returns `code`.
int fail(const std::string& why, int code = kNotBegun);

}  // namespace sinew::app
