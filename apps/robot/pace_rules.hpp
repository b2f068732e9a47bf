#pragma once
// Checks time-outs of a robot file against the highest rate of what they wait for.
#include <vector>

#include "apps/robot_file/robot_file.hpp"
#include "rt/graph.hpp"

namespace sinew::app {

/// Time-outs that would run out between two messages although nothing is wrong: a failsafe's silent_ms, an actuator's
/// lease_ms. A topic comes at most as often as the thread of its module is released (by its period, or by topics that
/// have one), a camera's topic at most with its rate_hz, joint states and setpoints at most once each tick of their bus
/// (both on the board `linux`). Rates of other devices are not known here. Graph and devices must have no problems of
/// their own.
std::vector<rt::Problem> check_paces(const RobotFile& robot, const rt::Graph& graph);

}  // namespace sinew::app
