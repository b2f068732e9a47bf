#pragma once
#include <string>

#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// A verdict as it stands in reports: docs/sinew-sim.md.
std::string verdict_json(const Verdict& verdict);

}  // namespace sinew::plant
