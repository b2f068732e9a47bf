#pragma once
// The few rotations that the plant needs.
#include "msg/geometry.hpp"

namespace sinew::plant {

inline msg::Vec3 add(const msg::Vec3& a, const msg::Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline msg::Vec3 sub(const msg::Vec3& a, const msg::Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline msg::Vec3 scale(const msg::Vec3& a, double s) { return {a.x * s, a.y * s, a.z * s}; }

inline msg::Quat mul(const msg::Quat& a, const msg::Quat& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

/// Rotation matrix of a unit quaternion, by rows.
struct Rotation {
  double m[9];

  explicit Rotation(const msg::Quat& q) {
    const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z,
                 wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
    m[0] = 1 - 2 * (yy + zz), m[1] = 2 * (xy - wz), m[2] = 2 * (xz + wy);
    m[3] = 2 * (xy + wz), m[4] = 1 - 2 * (xx + zz), m[5] = 2 * (yz - wx);
    m[6] = 2 * (xz - wy), m[7] = 2 * (yz + wx), m[8] = 1 - 2 * (xx + yy);
  }
  msg::Vec3 apply(const msg::Vec3& v) const {
    return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
            m[6] * v.x + m[7] * v.y + m[8] * v.z};
  }
  msg::Vec3 inverse(const msg::Vec3& v) const {
    return {m[0] * v.x + m[3] * v.y + m[6] * v.z, m[1] * v.x + m[4] * v.y + m[7] * v.z,
            m[2] * v.x + m[5] * v.y + m[8] * v.z};
  }
};

}  // namespace sinew::plant
