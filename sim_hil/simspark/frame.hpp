#pragma once
#include "math/linear.hpp"

namespace sinew::simspark {

/// SimSpark's bodies have x to the right, y ahead, z up; ours x ahead, y left, z up.
inline math::Vec3 to_spark(const math::Vec3& v) { return {-v.y, v.x, v.z}; }
inline math::Vec3 from_spark(const math::Vec3& v) { return {v.y, -v.x, v.z}; }

inline constexpr double kDegrees = 180 / math::kPi;
inline constexpr double kCycle_s = 0.02;  // of the server
inline constexpr std::int64_t kCycleNs = 20'000'000;

}  // namespace sinew::simspark
