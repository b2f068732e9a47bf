#pragma once
#include <functional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/driver.hpp"

namespace sinew::drivers {

/// Robots and simulators that take text commands and answer text (docs/text-robots.md):
/// - driver = "text": the link to one robot with its drives, commands and messages. It is the group of the drives, and
///   the sensor of all values.
/// - driver = "text_commands": a group of some of its commands.
/// - driver = "text_imu", "text_range", ...: values of a link as what the house calls them.
std::span<const DriverKind> text_drivers();

/// The tables of a device with driver = "text", for the page of keys.
std::vector<std::pair<std::string_view, std::function<void(DeviceKeys&)>>> text_tables();

}  // namespace sinew::drivers
