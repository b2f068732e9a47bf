#pragma once
#include "apps/run_setup.hpp"

namespace sinew::app {

/// Runs a prepared robot on a recorded folder, in virtual or real time, and compares its attitude with the ground truth
/// that lies there. The exit code of `sinew run`.
int run_on_dataset(Prepared& prepared, const RunOptions& options);

/// Takes the camera, what needs it, and threads that become empty out of a graph; the names of the modules left out.
std::vector<std::string> leave_out_camera(rt::GraphSpec& graph);

}  // namespace sinew::app
