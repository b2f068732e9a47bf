#pragma once
#include <string>
#include <vector>

#include "rt/graph_spec.hpp"

namespace sinew::app {

/// Removes the camera, what needs it, and threads that become empty from a graph. Returns the removed modules' names.
std::vector<std::string> leave_out_camera(rt::GraphSpec& graph);

}  // namespace sinew::app
