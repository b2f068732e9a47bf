#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace sinew::app {

/// The names that robots running on this machine have of a kind (a hint of apps/command/command.hpp): robots, topics,
/// modules, ... `robot` is what --robot said, or empty. No robot, no names.
std::vector<std::string> running_names(std::string_view hint, const std::string& robot);

}  // namespace sinew::app
