#include "kinematics/leg.hpp"

#include <algorithm>

namespace sinew::kinematics {
namespace {

using math::Mat3;
using math::Quat;
using math::Vec3;

constexpr double kSame_m = 1e-4;
constexpr double kSameDirection = 1e-6;

Quat about_x(double rad) { return Quat::from_axis_angle({1, 0, 0}, rad); }
Quat about_y(double rad) { return Quat::from_axis_angle({0, 1, 0}, rad); }

/// Sign of an axis along one of the coordinates; 0: it is not along it.
double sign_along(const Vec3& axis, const Vec3& coordinate) {
  const double along = dot(axis, coordinate);
  if (math::fabs(along) < 1 - kSameDirection) return 0;
  return along > 0 ? 1 : -1;
}

}  // namespace

std::optional<Leg> Leg::make(const Body& body, std::size_t foot, std::string& why) {
  Leg leg;
  const BodyPose at_zero(body);
  std::size_t link = foot;
  for (std::size_t i = kLegJoints; i-- > 0; link = body.links[link].parent) {
    if (link == 0 || link == kNone || link >= body.links.size()) {
      why = "a leg has six joints between link 0 and its foot";
      return std::nullopt;
    }
    leg.link_[i] = link;
    leg.least_rad_[i] = body.links[link].least_rad;
    leg.most_rad_[i] = body.links[link].most_rad;
  }
  const auto at = [&](std::size_t i) { return at_zero.link(leg.link_[i]).p_m; };
  const auto axis = [&](std::size_t i) { return body.links[leg.link_[i]].axis; };
  const auto refuse = [&](std::size_t i, const char* what) {
    why = body.links[leg.link_[i]].name + ": " + what;
    return std::nullopt;
  };
  static constexpr Vec3 kAlong[kLegJoints] = {{}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {1, 0, 0}};
  for (std::size_t i = 1; i < kLegJoints; ++i) {
    leg.sign_[i] = sign_along(axis(i), kAlong[i]);
    if (leg.sign_[i] == 0)
      return refuse(i, i == 1 || i == 5 ? "its axis has to be along x" : "its axis has to be along y");
  }
  const Vec3 first = axis(0);
  if (math::fabs(first.x) > kSameDirection || math::fabs(first.z) < 0.5)
    return refuse(0, "its axis has to be in the y-z plane, at most 60 degrees from z");
  leg.sign_[0] = first.z > 0 ? 1 : -1;
  leg.tilt_rad_ = math::atan2(-first.y * leg.sign_[0], first.z * leg.sign_[0]);

  leg.hip_m_ = {at(2).x, at(1).y, at(1).z};
  if (math::fabs(at(2).z - at(1).z) > kSame_m) return refuse(2, "its axis has to meet that of the joint before it");
  if (norm(cross(first, leg.hip_m_ - at(0))) > kSame_m)
    return refuse(0, "its axis has to go through the point where those of the next two joints meet");
  const Vec3 ankle{at(4).x, at(5).y, at(4).z};
  if (math::fabs(at(5).z - at(4).z) > kSame_m) return refuse(5, "its axis has to meet that of the joint before it");
  if (math::fabs(ankle.y - leg.hip_m_.y) > kSame_m) return refuse(5, "its axis has to be straight below the hip");
  leg.ankle_m_ = ankle - at(5);
  const Vec3 thigh = at(3) - leg.hip_m_, shank = ankle - at(3);
  leg.thigh_m_ = math::hypot(thigh.x, thigh.z);
  leg.shank_m_ = math::hypot(shank.x, shank.z);
  if (!(leg.thigh_m_ > kSame_m && leg.shank_m_ > kSame_m)) return refuse(3, "thigh and shank need a length");
  leg.thigh_rad_ = math::atan2(-thigh.x, -thigh.z);
  leg.shank_rad_ = math::atan2(-shank.x, -shank.z);
  // Of the knee's two ways the one that takes the shank backwards.
  const double least = leg.sign_[3] > 0 ? leg.least_rad_[3] : -leg.most_rad_[3];
  const double bent = std::max(0.0, least - (leg.thigh_rad_ - leg.shank_rad_));
  leg.longest_m_ = math::sqrt(leg.thigh_m_ * leg.thigh_m_ + leg.shank_m_ * leg.shank_m_ +
                              2 * leg.thigh_m_ * leg.shank_m_ * math::cos(bent));
  return leg;
}

LegAngles Leg::solve(const Pose& foot) const {
  LegAngles out;
  const Vec3 ankle = foot.of(ankle_m_);
  const Vec3 r = foot.q.conjugate().rotate(hip_m_ - ankle);  // from the ankle to the hip, in the foot's axes
  const double d2 = squared_norm(r), d = math::sqrt(d2);
  const double bend = thigh_rad_ - shank_rad_;
  const double c = (d2 - thigh_m_ * thigh_m_ - shank_m_ * shank_m_) / (2 * thigh_m_ * shank_m_);
  const double knee = bend + math::atan2(math::sqrt(std::max(0.0, 1 - c * c)), c < -1 ? -1 : (c > 1 ? 1 : c));
  out.reached = c >= -1 && c <= 1;

  // Of the two ways the one that rolls the ankle by at most 90 degrees.
  const double side = r.z < 0 ? -1 : 1;
  const double roll = math::atan2(side * r.y, side * r.z);
  const double over = side * math::hypot(r.y, r.z);
  // From the ankle to the hip in the shank's axes, turned back by the knee; then the ankle's pitch is what is missing.
  const Vec3 up{thigh_m_ * math::sin(thigh_rad_ - knee) + shank_m_ * math::sin(shank_rad_), 0,
                thigh_m_ * math::cos(thigh_rad_ - knee) + shank_m_ * math::cos(shank_rad_)};
  const double pitch = math::atan2(up.x, up.z) - math::atan2(r.x, over);

  const Quat hip = foot.q * about_x(-roll) * about_y(-pitch - knee);
  const Mat3 m = (about_x(-tilt_rad_) * hip).matrix();
  const double angles[kLegJoints] = {math::atan2(-m(0, 1), m(1, 1)),
                                     math::atan2(m(2, 1), math::hypot(m(2, 0), m(2, 2))) + tilt_rad_,
                                     math::atan2(-m(2, 0), m(2, 2)),
                                     knee,
                                     pitch,
                                     roll};
  if (!(d > 0)) out.reached = false;
  for (std::size_t i = 0; i < kLegJoints; ++i) {
    double rad = sign_[i] * angles[i];
    if (!math::is_finite(rad)) rad = 0, out.reached = false;
    if (rad > math::kPi) rad -= 2 * math::kPi;
    if (rad < -math::kPi) rad += 2 * math::kPi;
    const double within = std::clamp(rad, least_rad_[i], most_rad_[i]);
    if (math::fabs(within - rad) > 1e-9) out.reached = false;
    out.rad[i] = within;
  }
  return out;
}

}  // namespace sinew::kinematics
