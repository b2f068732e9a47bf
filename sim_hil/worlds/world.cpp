#include "sim_hil/worlds/world.hpp"

#include <algorithm>

namespace sinew::plant {

std::string_view to_string(Part part) {
  constexpr std::string_view kNames[] = {"imu", "range", "baro", "camera", "actuators", "battery", "joints"};
  return kNames[static_cast<std::size_t>(part)];
}

const WorldDevice* WorldInfo::find(Part part) const {
  const auto it = std::ranges::find(devices, part, &WorldDevice::part);
  return it == devices.end() ? nullptr : &*it;
}

bool WorldInfo::has(FaultDevice device) const {
  return device == FaultDevice::link || std::ranges::find(devices, device, &WorldDevice::fault) != devices.end();
}

double WorldType::value(const WorldValues& values, std::string_view option) const {
  if (const auto it = values.find(option); it != values.end()) return it->second;
  const auto own = std::ranges::find(options, option, &WorldOption::name);
  return own == options.end() ? 0 : own->value;
}

}  // namespace sinew::plant
