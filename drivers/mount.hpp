#pragma once
#include <array>

#include "msg/geometry.hpp"

namespace sinew::drivers {

/// How a chip sits in the robot: turned from the base frame by yaw about z, then pitch about y, then roll about x (the
/// axes as turned so far). A chip with its x axis to the left of the robot: yaw 90.
struct MountAngles {
  double roll_deg = 0, pitch_deg = 0, yaw_deg = 0;
};

/// Takes vectors from the chip's axes to the base frame. Multiples of 90 degrees are exact.
class Mount {
 public:
  Mount() = default;
  explicit Mount(const MountAngles& angles);
  msg::Vec3 to_base(const msg::Vec3& v) const noexcept {
    const auto row = [&](std::size_t i) { return m_[3 * i] * v.x + m_[3 * i + 1] * v.y + m_[3 * i + 2] * v.z; };
    return {row(0), row(1), row(2)};
  }

 private:
  std::array<double, 9> m_{1, 0, 0, 0, 1, 0, 0, 0, 1};
};

}  // namespace sinew::drivers
