#pragma once
#include "apps/run_setup.hpp"

namespace sinew::app {

/// Runs a prepared robot on the sim board, in virtual or real time. The exit code of `sinew run`.
int run_on_sim(Prepared& prepared, const RunOptions& options);

}  // namespace sinew::app
