#pragma once
#include <span>

#include "drivers/driver.hpp"

namespace sinew::drivers {

/// Sensors and cameras that have their driver in the kernel: iio, v4l2, libcamera; and pictures of other programs:
/// grab, usarsim_images.
std::span<const DriverKind> kernel_drivers();

/// The camera of a table, with the defaults; check_devices() has reported the table's problems.
hal::CameraSpec camera_of(const DeviceSpec& spec);

}  // namespace sinew::drivers
