#pragma once
// The joints of a humanoid by the limb that they move.
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "kinematics/body.hpp"

namespace sinew::kinematics {

enum class Limb : std::uint8_t { head, left_arm, right_arm, left_leg, right_leg };
inline constexpr std::size_t kLimbs = 5;
/// "left_arm".
std::string_view to_string(Limb limb);

/// Joints by their numbers in the body, from the torso outwards.
struct Limbs {
  std::array<std::vector<std::size_t>, kLimbs> joints{};

  const std::vector<std::size_t>& of(Limb limb) const { return joints[static_cast<std::size_t>(limb)]; }
  /// The legs are what ends in the places "l_sole" and "r_sole"; arms begin with a link named "l_..." or "r_..."; the
  /// rest is the head.
  static Limbs of(const Body& body);
};

}  // namespace sinew::kinematics
