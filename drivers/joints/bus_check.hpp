#pragma once
#include <string>
#include <vector>

#include "drivers/device_spec.hpp"

namespace sinew::drivers {

/// Finds conflicts between the joints of a robot file, and with their buses: names that are there twice in a group,
/// numbers that clash on a bus, more load than max_load_percent. An open bus is planned by the same functions
/// (drivers/joints/bus_plan.hpp). `specs` have no problems of form. Each problem has the line of the later joint, or of
/// the bus's key.
std::vector<rt::Problem> check_buses(const DeviceSpecs& specs);

/// What a cycle of each serial line with servos takes, one a line: "bus legs: 20 servos at 100 Hz need 8 of 10 ms:
/// ...". `specs` have no problems.
std::vector<std::string> describe_buses(const DeviceSpecs& specs);

}  // namespace sinew::drivers
