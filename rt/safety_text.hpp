#pragma once
// The guardian's state in words, for the command line.
#include <string>
#include <vector>

#include "rt/graph_spec.hpp"

namespace sinew::rt {

/// A condition as the robot file has it: "camera.raw silent for 500 ms: land, stop after 20 s".
std::string to_string(const FailsafeSpec& failsafe);

/// Everything that keeps the robot from being armed, one reason each ("camera_lost: camera.raw has been silent for
/// 512 ms (at most 500 ms)"); empty when it is permitted or would be.
std::vector<std::string> not_ready(const GraphSpec& spec, const msg::SafetyState& state);

}  // namespace sinew::rt
