#pragma once
// What motions need to know of a body with two legs: which joints are legs, arms and head, where soles and IMU are.
#include <array>
#include <optional>
#include <span>
#include <string>

#include "kinematics/body.hpp"
#include "kinematics/leg.hpp"

namespace sinew::motion {

inline constexpr std::size_t kMaxJoints = kinematics::kMaxLinks - 1;
using JointAngles = std::array<double, kMaxJoints>;  // rad, in the order of the body's joints

enum class Side : std::uint8_t { left, right };
inline constexpr std::array kSides{Side::left, Side::right};
constexpr std::size_t index(Side side) { return static_cast<std::size_t>(side); }
constexpr Side other(Side side) { return side == Side::left ? Side::right : Side::left; }
/// +1 for the left: y is to the left.
constexpr double sign(Side side) { return side == Side::left ? 1 : -1; }

/// Forces on the four corners of a sole, N: front left, front right, back left, back right.
using SoleForces = std::array<double, 4>;
constexpr double sum(const SoleForces& sole) { return sole[0] + sole[1] + sole[2] + sole[3]; }

/// What a body measures in one step of its motions. Axes are the torso's: x forward, y left, z up.
/// Owner:   the spans live for the call.
struct Sensed {
  std::span<const double> joints_rad;  // one for each joint
  math::Vec3 gyro_radps, accel_mps2;   // specific force: +9.81 along z when upright at rest
  std::array<SoleForces, 2> soles_n{};
};

struct LegOfFigure {
  kinematics::Leg leg;
  std::size_t foot = 0;   // its link
  kinematics::Pose sole;  // the middle of the sole in the foot's link
  double sole_length_m = 0, sole_width_m = 0;
};

/// Thread:  any.   RT: yes, after make().
/// Owner:   the body lives as long.
class Figure {
 public:
  /// The legs end in the links of the places l_sole and r_sole. Joints of arms and head are found by their names
  /// (l_shoulder_pitch and so on; head_pan or head_yaw, head_tilt or head_pitch); those that are missing are not moved.
  /// Errors: nothing, and `why`.
  static std::optional<Figure> make(const kinematics::Body& body, std::string& why);

  const kinematics::Body& body() const { return *body_; }
  std::size_t joints() const { return body_->joints(); }
  const LegOfFigure& leg(Side side) const { return legs_[index(side)]; }
  /// Joint numbers; kinematics::kNone: there is none.
  std::size_t shoulder_pitch(Side side) const { return shoulder_pitch_[index(side)]; }
  std::size_t head_pan() const { return head_pan_; }
  std::size_t head_tilt() const { return head_tilt_; }
  std::size_t find_joint(std::string_view name) const;
  double mass_kg() const { return mass_kg_; }

  /// The angles of a leg whose sole is there in link 0's frame, written into `joints_rad`. False: out of reach, the
  /// nearest was taken.
  bool place_sole(Side side, const kinematics::Pose& sole, std::span<double> joints_rad) const;
  /// Where a sole's middle is in the frame that `pose` was set in.
  kinematics::Pose sole(const kinematics::BodyPose& pose, Side side) const {
    return pose.link(leg(side).foot) * leg(side).sole;
  }
  void limit(std::span<double> joints_rad) const;

 private:
  Figure() = default;
  const kinematics::Body* body_ = nullptr;
  std::array<LegOfFigure, 2> legs_;
  std::array<std::size_t, 2> shoulder_pitch_{};
  std::size_t head_pan_ = kinematics::kNone, head_tilt_ = kinematics::kNone;
  double mass_kg_ = 0;
};

}  // namespace sinew::motion
