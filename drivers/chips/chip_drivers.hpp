#pragma once
#include <span>

#include "drivers/driver.hpp"

namespace sinew::drivers {

/// Our own drivers of chips on I2C and SPI.
std::span<const DriverKind> chip_drivers();

}  // namespace sinew::drivers
