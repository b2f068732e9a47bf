#pragma once
#include <string>
#include <vector>

#include "apps/robot_file/robot_file.hpp"

namespace sinew::app {

/// What a robot says to its mates fits a frame and the budget. The graph has no problems.
std::vector<rt::Problem> check_team(const RobotFile& robot, const rt::Graph& graph);

/// What its words cost at most, a line each, in bytes a second; empty: it has no `[team]`.
std::vector<std::string> describe_team(const RobotFile& robot, const rt::Graph& graph);

}  // namespace sinew::app
