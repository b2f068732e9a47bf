#pragma once
#include <span>

#include "drivers/device_board.hpp"

namespace sinew::drivers {

/// Sensors and cameras that have their driver in the kernel: iio, v4l2, libcamera.
std::span<const DriverKind> kernel_drivers();

}  // namespace sinew::drivers
