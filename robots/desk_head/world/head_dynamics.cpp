#include "robots/desk_head/world/head_dynamics.hpp"

namespace sinew::plant {
namespace {

using math::cross;
using math::SinCos;
using math::Vec3;
using Pair = std::array<double, kHeadJoints>;

struct Turned {
  SinCos pan, tilt;
  // Base coordinates to yoke's, yoke's to head's, and back.
  Vec3 to_yoke(const Vec3& v) const { return {pan.cos * v.x + pan.sin * v.y, pan.cos * v.y - pan.sin * v.x, v.z}; }
  Vec3 to_head(const Vec3& v) const { return {tilt.cos * v.x - tilt.sin * v.z, v.y, tilt.sin * v.x + tilt.cos * v.z}; }
  Vec3 from_head(const Vec3& v) const {
    return {tilt.cos * v.x + tilt.sin * v.z, v.y, tilt.cos * v.z - tilt.sin * v.x};
  }
};

Vec3 at(const LinkMotion& m, const Vec3& p) {
  return m.a_mps2 + cross(m.dw_radps2, p) + cross(m.w_radps, cross(m.w_radps, p));
}

struct Load {
  Vec3 force_n, torque_nm;  // that the link needs, at its origin
};
Load load(const LinkInertia& body, const LinkMotion& m) {
  const Vec3 f = body.mass_kg * at(m, body.centre_m);
  const auto inertia = [&](const Vec3& v) {
    return Vec3{body.inertia_kgm2.x * v.x, body.inertia_kgm2.y * v.y, body.inertia_kgm2.z * v.z};
  };
  return {f, inertia(m.dw_radps2) + cross(m.w_radps, inertia(m.w_radps)) + cross(body.centre_m, f)};
}

struct Result {
  HeadMotion motion;
  Pair torque_nm;
};

/// Torques for given accelerations of the joints.
Result inverse(const LinkMotion& base, const Turned& t, const Pair& v, const Pair& accel) {
  Result r;
  LinkMotion& yoke = r.motion.yoke;
  yoke.w_radps = t.to_yoke(base.w_radps);
  yoke.dw_radps2 = t.to_yoke(base.dw_radps2) + cross(yoke.w_radps, {0, 0, v[0]}) + Vec3{0, 0, accel[0]};
  yoke.w_radps.z += v[0];
  yoke.a_mps2 = t.to_yoke(at(base, kPBaseYoke));
  LinkMotion& head = r.motion.head;
  head.w_radps = t.to_head(yoke.w_radps);
  head.dw_radps2 = t.to_head(yoke.dw_radps2) + cross(head.w_radps, {0, v[1], 0}) + Vec3{0, accel[1], 0};
  head.w_radps.y += v[1];
  head.a_mps2 = t.to_head(at(yoke, kPYokeHead));
  const Load of_head = load(kHead, head), of_yoke = load(kYoke, yoke);
  const Vec3 force = t.from_head(of_head.force_n);
  const Vec3 torque = of_yoke.torque_nm + t.from_head(of_head.torque_nm) + cross(kPYokeHead, force);
  r.torque_nm = {torque.z, of_head.torque_nm.y};
  return r;
}

}  // namespace

HeadMotion head_motion(const LinkMotion& base, const Pair& q, const Pair& v, const Pair& torque_nm,
                       const Pair& armature_kgm2) {
  const Turned t{math::sincos(q[0]), math::sincos(q[1])};
  const Pair bias = inverse(base, t, v, {0, 0}).torque_nm;
  const Pair first = inverse(base, t, v, {1, 0}).torque_nm, second = inverse(base, t, v, {0, 1}).torque_nm;
  const double m00 = first[0] - bias[0] + armature_kgm2[0], m01 = second[0] - bias[0], m10 = first[1] - bias[1],
               m11 = second[1] - bias[1] + armature_kgm2[1];
  const double e0 = torque_nm[0] - bias[0], e1 = torque_nm[1] - bias[1], det = m00 * m11 - m01 * m10;
  const Pair accel{(m11 * e0 - m01 * e1) / det, (m00 * e1 - m10 * e0) / det};
  HeadMotion motion = inverse(base, t, v, accel).motion;
  motion.accel_radps2 = accel;
  return motion;
}

}  // namespace sinew::plant
