#pragma once
// What the shell offers behind TAB. All of it comes from the description of the commands, so it is never out of date.
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace sinew::app {

/// The hidden command that the shell's function calls: `sinew complete WORD...`, the last word being the unfinished
/// one.
inline constexpr std::string_view kCompleteCommand = "complete";

/// The names that a running robot has of a kind (a hint of commands.hpp); `robot` is what --robot said, or empty.
using NamesOf = std::function<std::vector<std::string>(std::string_view hint, const std::string& robot)>;

/// Candidates for the last word, or one of ":file", ":file .toml", ":folder", which ask the shell to complete paths.
std::vector<std::string> completions(const CLI::App& app, const std::vector<std::string>& words,
                                     const NamesOf& names_of);

/// The script for `source <(sinew completion bash)`, for a program of this name.
std::string bash_completion(const std::string& program);

}  // namespace sinew::app
