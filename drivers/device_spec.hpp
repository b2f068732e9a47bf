#pragma once
#include <map>
#include <string>
#include <vector>

#include "rt/graph_spec.hpp"

namespace sinew::drivers {

/// [device.NAME], [bus.NAME], [[device.NAME.joint]] or another table of a device in a robot file: its keys as they
/// stand there, before anything is checked. Lines are 0 where there is no file.
struct DeviceSpec {
  std::string name{};
  std::string driver{};
  std::map<std::string, rt::Located<rt::ParamValue>> keys{};
  std::vector<DeviceSpec> joints{};  // in the order of the channels
  // [[device.NAME.drive]], [[.command]], [[.message]]: of the driver "text" only
  std::vector<DeviceSpec> drives{}, commands{}, messages{};
  int line = 0;
};

/// A robot's devices on the board `linux`.
struct DeviceSpecs {
  std::vector<DeviceSpec> buses{}, devices{};
};

}  // namespace sinew::drivers
