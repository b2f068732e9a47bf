#pragma once
#include <string>

#include "apps/sim/sim_options.hpp"

namespace sinew::plant {

/// RoboCup's 3D soccer simulation, until a signal, a monitor or the duration ends it. Its exit code; `report` gets what
/// happened, as JSON.
int serve_simspark(const SimulatorOptions& options, std::string& report);

}  // namespace sinew::plant
