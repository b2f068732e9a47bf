#pragma once
#include "apps/sim/sim_options.hpp"
#include "hal/os.hpp"
#include "sim_hil/plant/wire_devices.hpp"

namespace sinew::plant {

/// Opens the buses, folders and nodes that the options put parts of the world at. False after printing why.
bool open_wire(const SimulatorOptions& options, hal::Os& os, WireDevices& wire);

}  // namespace sinew::plant
