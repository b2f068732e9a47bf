#pragma once
// The guardian's state in words, for the command line.
#include <string>
#include <vector>

#include "rt/graph_spec.hpp"

namespace sinew::rt {

/// A condition as the robot file has it: "camera.raw silent for 500 ms: land, stop after 20 s".
std::string to_string(const FailsafeSpec& failsafe);

/// Why a condition acted: "camera.raw silent for 500 ms", "battery.raw.voltage_v is 12.9 (at least 13.2)".
/// `measured`: SafetyState::measured of it.
std::string cause_text(const FailsafeSpec& failsafe, double measured);

/// Everything that keeps the robot from being armed, one reason each ("camera_lost: camera.raw has been silent for
/// 512 ms (at most 500 ms)"); empty when it is permitted or would be.
std::vector<std::string> not_ready(const GraphSpec& spec, const msg::SafetyState& state);

}  // namespace sinew::rt
