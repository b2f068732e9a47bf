#pragma once
#include "apps/toml/toml_reader.hpp"
#include "drivers/device_spec.hpp"

namespace sinew::app {

/// [device.NAME] and [bus.NAME] of a robot file. Only collects the keys; drivers::check_devices() checks them.
void read_device(const std::string& name, TomlReader& r, std::vector<drivers::DeviceSpec>& out);

}  // namespace sinew::app
