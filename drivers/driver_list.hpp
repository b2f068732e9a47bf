#pragma once
#include <span>

#include "drivers/device_board.hpp"

namespace sinew::drivers {

/// Every driver of the house, in the order of docs/devices.md.
std::span<const DriverKind> all_drivers();

}  // namespace sinew::drivers
