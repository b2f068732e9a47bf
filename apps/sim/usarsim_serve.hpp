#pragma once
#include <string>

#include "apps/sim/sim_options.hpp"

namespace sinew::plant {

/// Serves the world as USARSim until a signal comes or the duration is over, and prints what clients did. `report`
/// becomes the same as one JSON object. Returns an exit code.
int serve_usarsim(const SimulatorOptions& options, std::string& report);

}  // namespace sinew::plant
