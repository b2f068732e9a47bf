#pragma once
#include <vector>

#include "apps/robot_file/robot_file.hpp"
#include "rt/graph.hpp"

namespace sinew::app {

/// `[ros2]` against the robot's topics and their types; a graph without problems of its own.
std::vector<rt::Problem> check_ros2(const RobotFile& robot, const rt::Graph& graph);

}  // namespace sinew::app
