#pragma once
#include <vector>

#include "apps/parent/parent.hpp"
#include "apps/run/run_setup.hpp"

namespace sinew::app {

/// Adds the parent's own ways to the CAN buses and serial lines of actuators on the board "linux", if there are such.
/// If a connection to a CAN bus fails, prints on standard error what stops those joints instead. `prepared` outlives
/// `stops`.
void add_stops_of_linux_devices(const Prepared& prepared, std::vector<StopWay>& stops);

}  // namespace sinew::app
