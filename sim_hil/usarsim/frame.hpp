#pragma once
#include "math/linear.hpp"

namespace sinew::usarsim {

/// Sinew's world (x east, y north, z up; REP-103 angles) as USARSim counts. Unreal's own axes are x east, y to the
/// right of it, z up, yaw clockwise, pitch upwards, roll to the right. UDK's `RightHand` turns z, and nothing else.
/// Source:  robocup-usarsim, UnitsConverter.uc (LengthVectorFromUU, AngleVectorFromUU).
struct Frame {
  bool z_down = false;

  /// Positions and velocities; the same both ways. 0 - x: zeros have no sign, which would be written.
  math::Vec3 turned(const math::Vec3& v) const { return {v.x, 0 - v.y, z_down ? 0 - v.z : v.z}; }
  /// Roll, pitch, yaw.
  static math::Vec3 angles(const math::YawPitchRoll& a) { return {a.roll, 0 - a.pitch, 0 - a.yaw}; }
  static math::YawPitchRoll angles(const math::Vec3& rpy) { return {0 - rpy.z, 0 - rpy.y, rpy.x}; }
};

/// As the captured session writes angles: from 0 to 2 pi.
inline double positive_turn(double rad) {
  const double a = math::wrap_pi(rad);
  return a < 0 ? a + 2 * math::kPi : a;
}
inline math::Vec3 positive_turns(const math::Vec3& a) {
  return {positive_turn(a.x), positive_turn(a.y), positive_turn(a.z)};
}

}  // namespace sinew::usarsim
