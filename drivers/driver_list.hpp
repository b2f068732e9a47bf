#pragma once
#include <span>

#include "drivers/device_board.hpp"

namespace sinew::drivers {

/// Every driver of the house, in the order of docs/devices.md.
std::span<const DriverKind> all_drivers();

/// Whether devices of this driver give `what`, e.g. "imu".
bool gives(const DriverKind& driver, std::string_view what);

}  // namespace sinew::drivers
