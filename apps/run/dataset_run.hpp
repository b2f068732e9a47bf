#pragma once
#include "apps/run/run_setup.hpp"

namespace sinew::app {

/// Runs a prepared robot on a recorded folder, in virtual or real time, and compares its attitude with the ground truth
/// of that folder. Returns the exit code of `sinew run`.
int run_on_dataset(Prepared& prepared, const RunOptions& options);

}  // namespace sinew::app
