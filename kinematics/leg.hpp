#pragma once
// Inverse kinematics of a leg with six joints, in closed form.
#include <array>
#include <cstdint>
#include <string>

#include "kinematics/body.hpp"

namespace sinew::kinematics {

inline constexpr std::size_t kLegJoints = 6;

/// The angles that bring a foot somewhere.
struct LegAngles {
  std::array<double, kLegJoints> rad{};  // from the hip down, within their limits
  bool reached = true;                   // false: too far, too near or beyond a limit: the nearest that was found
};

/// A leg whose first three axes meet in the hip and whose last two in the ankle: first joint about z or about a line in
/// the y-z plane (NAO's coupled hip), then x, y, knee about y, ankle about y and x, as the legs of OP3, DARwIn-OP and
/// NAO are. Axes may have either sign, and links may be bent in the x-z plane. Thread:  any.   RT: yes, after make().
/// Source:  S. Kajita and others, Introduction to Humanoid Robotics (2014), 2.5.2; coupled hips: C. Graf, A. Haertl,
///          T. Roefer, T. Laue, A robust closed-loop gait for the Standard Platform League humanoid (2009).
class Leg {
 public:
  /// The leg that ends with this link. Errors: nothing, and `why` says which joint is not where it has to be.
  static std::optional<Leg> make(const Body& body, std::size_t foot, std::string& why);

  /// The foot link's pose in link 0's frame, as BodyPose::link() has it.
  LegAngles solve(const Pose& foot) const;
  /// The links of its joints, from the hip down.
  const std::array<std::size_t, kLegJoints>& links() const { return link_; }
  math::Vec3 hip_m() const { return hip_m_; }
  /// From hip to ankle with the knee as straight as it goes.
  double longest_m() const { return longest_m_; }

 private:
  std::array<std::size_t, kLegJoints> link_{};
  std::array<double, kLegJoints> sign_{}, least_rad_{}, most_rad_{};
  double tilt_rad_ = 0;                                               // of the first axis from z, about x
  math::Vec3 hip_m_;                                                  // in link 0's frame
  math::Vec3 ankle_m_;                                                // in the foot link's frame
  double thigh_m_ = 0, shank_m_ = 0, thigh_rad_ = 0, shank_rad_ = 0;  // lengths, and directions from -z about y
  double longest_m_ = 0;
};

}  // namespace sinew::kinematics
