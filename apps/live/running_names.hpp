#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace sinew::app {

/// Names of one kind (a hint of apps/command/command.hpp) in the robots that run on this machine: robots, topics,
/// modules, ... `robot` is the value of --robot, or empty. Empty when no robot runs.
std::vector<std::string> running_names(std::string_view hint, const std::string& robot);

}  // namespace sinew::app
