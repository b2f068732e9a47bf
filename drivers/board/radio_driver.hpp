#pragma once
#include "drivers/driver.hpp"

namespace sinew::drivers {

/// driver = "udp": a radio of datagrams (hal::RadioSpec).
DriverKind udp_radio_driver();

/// driver = "dds": a radio that the program `sinew net` beside the robot is.
DriverKind dds_radio_driver();

}  // namespace sinew::drivers
