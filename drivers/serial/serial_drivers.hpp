#pragma once
#include <span>

#include "drivers/driver.hpp"

namespace sinew::drivers {

/// Sensors and receivers on serial lines.
std::span<const DriverKind> serial_drivers();

}  // namespace sinew::drivers
