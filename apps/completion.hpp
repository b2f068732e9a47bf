#pragma once
// Candidates that the shell offers after TAB. They come from the description of the commands, so they are always
// current.
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace sinew::app {

/// The hidden command that the shell's function calls: `sinew complete WORD...`; the last word is the unfinished one.
inline constexpr std::string_view kCompleteCommand = "complete";

/// Names of one kind (a hint of apps/command/command.hpp) in a running robot; `robot` is the value of --robot, or
/// empty.
using NamesOf = std::function<std::vector<std::string>(std::string_view hint, const std::string& robot)>;

/// Candidates for the last word; or ":file", ":file .toml" or ":folder", which asks the shell to complete paths.
std::vector<std::string> completions(const CLI::App& app, const std::vector<std::string>& words,
                                     const NamesOf& names_of);

/// The script for `source <(sinew completion bash)`, for a program of this name.
std::string bash_completion(const std::string& program);

}  // namespace sinew::app
