#pragma once
#include <vector>

#include "drivers/device_spec.hpp"

namespace sinew::drivers {

/// What the joints of a robot file mean to each other and to their buses, by the functions that an open bus is planned
/// with (drivers/joints/bus_plan.hpp): names that are there twice in a group, numbers that clash on a bus, more load
/// than max_load_percent. `specs` are without problems of form. Each problem stands at the line of the later joint, or
/// of the bus's key.
std::vector<rt::Problem> check_buses(const DeviceSpecs& specs);

}  // namespace sinew::drivers
