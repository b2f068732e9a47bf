#pragma once
#include <vector>

#include "apps/parent/parent.hpp"
#include "apps/run/run_setup.hpp"

namespace sinew::app {

/// Adds the parent's own connections to the CAN buses of actuators on the board "linux"; nothing when none is. When one
/// cannot be had, it is said on standard error what stops those joints then. `prepared` outlives `stops`.
void add_stops_of_linux_devices(const Prepared& prepared, std::vector<StopWay>& stops);

}  // namespace sinew::app
