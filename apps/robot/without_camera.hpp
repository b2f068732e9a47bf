#pragma once
#include <string>
#include <vector>

#include "rt/graph_spec.hpp"

namespace sinew::app {

/// Takes the camera, what needs it, and threads that become empty out of a graph; the names of the modules left out.
std::vector<std::string> leave_out_camera(rt::GraphSpec& graph);

}  // namespace sinew::app
