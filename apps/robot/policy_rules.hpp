#pragma once
#include <string>
#include <vector>

#include "apps/robot_file/robot_file.hpp"

namespace sinew::app {

/// Each policy's network can be run, and fits the fields that it observes and commands. The graph has no problems.
std::vector<rt::Problem> check_policies(const RobotFile& robot, const rt::Graph& graph);

/// A line for each policy; none for those that have problems.
std::vector<std::string> describe_policies(const RobotFile& robot);

}  // namespace sinew::app
