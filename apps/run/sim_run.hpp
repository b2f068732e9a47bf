#pragma once
#include "apps/run/run_setup.hpp"

namespace sinew::app {

/// Runs a prepared robot on the sim board, in virtual or real time; in real time in a process of its own beside a
/// parent, unless there is nothing to stop or the options say otherwise. The exit code of `sinew run`.
int run_on_sim(Prepared& prepared, const RunOptions& options);

}  // namespace sinew::app
