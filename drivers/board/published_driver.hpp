#pragma once
#include "drivers/driver.hpp"

namespace sinew::drivers {

/// driver = "published": actuators that are not here. Their setpoints are what the guardian publishes as guardian.NAME,
/// for a program beside the robot that hands them on (docs/ros2.md).
DriverKind published_driver();

}  // namespace sinew::drivers
