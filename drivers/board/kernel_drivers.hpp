#pragma once
#include <span>

#include "drivers/driver.hpp"

namespace sinew::drivers {

/// Sensors and cameras that have their driver in the kernel: iio, v4l2, libcamera.
std::span<const DriverKind> kernel_drivers();

/// What a table of a camera asks for, with the defaults; its problems have been told.
hal::CameraSpec camera_of(const DeviceSpec& spec);

}  // namespace sinew::drivers
