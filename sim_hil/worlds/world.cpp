#include "sim_hil/worlds/world.hpp"

#include <algorithm>
#include <cstdio>

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

const WorldOption* WorldInfo::find_option(std::string_view key) const {
  const auto it = std::ranges::find_if(options, [&](const WorldOption& o) { return key == o.key; });
  return it == options.end() ? nullptr : &*it;
}

std::optional<double> WorldInfo::value(const WorldValues& values, std::string_view key) const {
  if (const auto it = values.find(key); it != values.end()) return it->second;
  const WorldOption* own = find_option(key);
  return own ? own->value : std::nullopt;
}

bool WorldOption::allows(double number) const {
  return number >= least && number <= most && (!whole || number == static_cast<double>(static_cast<int>(number)));
}

std::string WorldOption::allowed() const {
  char text[64];
  std::snprintf(text, sizeof text, "%s from %g to %g", whole ? "an integer" : "a number", least, most);
  return std::string(text) + (*unit ? " " : "") + unit;
}

}  // namespace sinew::plant
