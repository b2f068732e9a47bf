#include "sim_hil/worlds/world.hpp"

#include <algorithm>
#include <cstdio>

#include "math/random.hpp"

namespace sinew::plant {

std::string_view to_string(Part part) {
  constexpr std::string_view kNames[kParts] = {"imu",     "range",  "baro",  "camera", "actuators",
                                               "battery", "joints", "soles", "referee"};
  return kNames[static_cast<std::size_t>(part)];
}

const WorldDevice* WorldInfo::find(Part part) const {
  const auto it = std::ranges::find(devices, part, &WorldDevice::part);
  return it == devices.end() ? nullptr : &*it;
}

std::size_t WorldInfo::count(Part part) const {
  return static_cast<std::size_t>(std::ranges::count(devices, part, &WorldDevice::part));
}

std::uint32_t WorldInfo::channels(Part part) const {
  std::uint32_t all = 0;
  for (const WorldDevice& device : devices) all += device.part == part ? device.channels : 0;
  return all;
}

bool WorldInfo::has(FaultDevice device) const {
  if (device == FaultDevice::radio) return has_radio();
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

WorldValues WorldChoice::values_of(std::size_t robot) const {
  if (robot >= robots.size()) return values;
  WorldValues all = robots[robot].values;
  all.insert(values.begin(), values.end());
  return all;
}

WorldInfo WorldChoice::info_of(std::size_t robot) const { return type->info.of(values_of(robot)); }

std::vector<WorldValues> WorldChoice::all_values() const {
  std::vector<WorldValues> all;
  for (std::size_t i = 0; i < robot_count(); ++i) all.push_back(values_of(i));
  return all;
}

const kinematics::Body* WorldChoice::body_of(std::size_t robot) const {
  const bool own = robot < robots.size() && robots[robot].body;
  return own ? robots[robot].body.get() : body.get();
}

hal::Result<std::unique_ptr<World>> WorldChoice::create(std::uint64_t seed) const { return type->create(*this, seed); }

std::uint64_t seed_of_robot(std::uint64_t seed, std::size_t robot) {
  constexpr std::uint32_t kStream = 0x726f626f;
  return robot == 0 ? seed : math::Random(seed, kStream, robot).next_u64();
}

}  // namespace sinew::plant
