#pragma once
// What all commands share. Each room of commands adds its own (commands.hpp of that room) to the CLI::App; the one that
// the user asked for sets `action`.
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

/// The type name that an argument or option declares says what completes it: kFileHint a file, and so on. Choices are
/// written as "{one,two}".
inline constexpr const char *kRobotFileHint = "FILE.toml", *kFileHint = "FILE", *kFolderHint = "DIR";
inline constexpr const char *kRobotHint = "ROBOT", *kTopicHint = "TOPIC", *kExternalHint = "EXTERNAL",
                            *kModuleHint = "MODULE", *kParamHint = "MODULE.PARAM", *kThreadHint = "THREAD";

/// Of this Sinew: "0.1.0".
std::string version();

/// Says why on standard error; answers `code`.
int fail(const std::string& why, int code = kNotBegun);

}  // namespace sinew::app
