#pragma once
// The worlds of sinew-sim and the devices in them, for whoever reads a robot file; tests/plant holds it against the
// worlds.
#include <array>
#include <span>
#include <string_view>

#include "sim_hil/protocol.hpp"

namespace sinew::sim_hil {

struct WorldPart {
  DeviceKind kind;
  std::string_view name;
  std::uint32_t channels;  // of actuators and joints
};

inline constexpr std::array<std::string_view, 2> kWorlds{"quad", "desk_head"};

/// Empty: there is no such world.
inline std::span<const WorldPart> parts_of_world(std::string_view world) {
  static constexpr WorldPart kQuad[] = {{DeviceKind::imu, "imu", 0},          {DeviceKind::range, "range", 0},
                                        {DeviceKind::baro, "baro", 0},        {DeviceKind::camera, "camera", 0},
                                        {DeviceKind::actuators, "motors", 4}, {DeviceKind::battery, "battery", 0}};
  static constexpr WorldPart kDeskHead[] = {{DeviceKind::imu, "imu", 0},
                                            {DeviceKind::joints, "joints", 2},
                                            {DeviceKind::camera, "camera", 0},
                                            {DeviceKind::actuators, "head", 2}};
  if (world == kWorlds[0]) return kQuad;
  if (world == kWorlds[1]) return kDeskHead;
  return {};
}

}  // namespace sinew::sim_hil
