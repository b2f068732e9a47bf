#pragma once
// Time-outs of a robot file against how often what they wait for comes at most.
#include <vector>

#include "apps/robot_file/robot_file.hpp"
#include "rt/graph.hpp"

namespace sinew::app {

/// Time-outs that would run out between two messages with nothing wrong: a failsafe's silent_ms, an actuator's
/// lease_ms. A topic comes no oftener than the thread of its module is released (by its period, or by topics that have
/// one), a camera's not oftener than its rate_hz, joints' and setpoints of joints not oftener than the tick of their
/// bus (both on the board `linux`). Rates of other devices are not known here. Graph and devices without problems of
/// their own.
std::vector<rt::Problem> check_paces(const RobotFile& robot, const rt::Graph& graph);

}  // namespace sinew::app
