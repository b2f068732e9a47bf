// From the plan of the walk to angles of joints.
#include "motion/walk.hpp"

#include <algorithm>

#include "motion/posture.hpp"

namespace sinew::motion {
namespace {

constexpr double kGravity_mps2 = 9.81;
constexpr double kMostLevel_m = 0.02, kMostLevel_rad = 0.25, kMostAnkle_rad = 0.25;
constexpr double kMostTip_m = 0.04;
constexpr double kCarry_s = 0.03;  // weight goes from sole to sole in such a time

}  // namespace

double Walk::torso_yaw() const {
  if (phase_ != WalkPhase::step) return yaw0_rad_;
  const double at = std::clamp(time_s_ / end_s_, 0.0, 1.0);
  return yaw0_rad_ + (0.5 * landing_.yaw_rad - yaw0_rad_) * at;
}

/// Where the kicking foot is beside its way to the next place: first back, then as fast as it can beyond, then there.
Walk::KickOffset Walk::kick_offset() const {
  if (!kicking_) return {};
  struct Point {
    double at, along, up;  // parts of the step, of the strike, of the lift
  };
  const StepKickParams& p = kick_params();
  const double back = -p.back_m / p.strike_m, held_to = std::min(p.hit_at + p.hold, 0.98);
  const std::array<Point, 5> points{
      {{0.05, 0, 0}, {p.back_at, back, 1}, {std::max(p.hit_at, p.back_at + 0.02), 1, 1}, {held_to, 1, 1}, {1, 0, 0}}};
  const double at = time_s_ / end_s_;
  Point before{0, 0, 0}, now{1, 0, 0};
  for (const Point& to : points) {
    if (at < to.at) {
      const double part = (at - before.at) / (to.at - before.at);
      now = {at, before.along + part * (to.along - before.along), before.up + part * (to.up - before.up)};
      break;
    }
    before = to;
  }
  const double along_m = now.along * p.strike_m, tip_rad = p.tip_rad * now.along, up_m = now.up * p.lift_m;
  const double lean_rad = p.lean_back_rad * now.along;
  const auto about = [](const math::Vec3& axis, double rad) { return math::Quat::from_axis_angle(axis, rad); };
  const double side = sign(kick_foot_);
  const bool ahead = kick_way_ == KickWay::forward;
  const math::Vec3 axis =
      ahead ? math::Vec3{0, -1, 0} : math::Vec3{side, 0, 0};  // a turn about it swings a leg to the ball
  const math::Vec3 way = ahead ? math::Vec3{1, 0, 0} : math::Vec3{0, side, 0};
  const math::Quat aim = about({0, 0, 1}, -side * p.aim_rad * now.along);
  return {aim.rotate(along_m * way) + math::Vec3{0, 0, up_m}, aim * about(axis, tip_rad), about(axis, lean_rad)};
}

void Walk::write(double dt_s, std::span<double> targets_rad) {
  std::copy_n(rest_rad_.begin(), figure_->joints(), targets_rad.begin());
  const double yaw = torso_yaw();
  const KickOffset kick = kick_offset();
  const math::Vec3 com_from_torso = kick.lean.rotate(com_in_torso_);
  const Vec2 torso_at = Vec2{plan_.x.com_m, plan_.y.com_m} - turned(Vec2{com_from_torso.x, com_from_torso.y}, yaw);
  const math::Quat q_support_torso =
      math::Quat::from_axis_angle({0, 0, 1}, yaw) * kick.lean * math::Quat::from_axis_angle({0, 1, 0}, params.lean_rad);
  const double torso_z_m = params.height_m + torso_over_hips_m_ + com_in_torso_.z - com_from_torso.z;
  const kinematics::Pose torso{{torso_at.x, torso_at.y, torso_z_m}, q_support_torso};
  const kinematics::Pose to_torso = torso.inverse();

  const Lean lean = lean_beside(q_now_, q_support_torso);
  const double pitch = lean.pitch_rad, roll = lean.roll_rad;
  const double ankle_pitch =
      std::clamp(params.gyro_pitch_s * rate_.y + params.tilt_pitch * pitch, -kMostAnkle_rad, kMostAnkle_rad);
  const double ankle_roll =
      std::clamp(params.gyro_roll_s * rate_.x + params.tilt_roll * roll, -kMostAnkle_rad, kMostAnkle_rad);

  const bool both = phase_ != WalkPhase::step;
  const double share_y = foot_.at_m.y != 0 ? std::clamp(cop_m_.y / foot_.at_m.y, 0.0, 1.0) : 0.5;
  const double share = both ? share_y : 0;  // of the other foot
  std::array<LegLoad, 2> loads{};
  for (const Side side : kSides) {
    const bool carries = side == support_;
    double& carried = carried_[index(side)];
    carried += ((carries ? 1 - share : share) - carried) * (dt_s / (dt_s + kCarry_s));
    const Planar at = carries ? Planar{} : foot_;
    double z = carries ? support_z_m_ : foot_z_m_, turn_pitch = ankle_pitch, turn_roll = ankle_roll;
    if (!carries && !both) {
      turn_pitch = -std::clamp(params.level_swing * pitch, -kMostLevel_rad, kMostLevel_rad);
      turn_roll = -std::clamp(params.level_swing * roll, -kMostLevel_rad, kMostLevel_rad);
      z -= std::clamp(params.level_height * (roll * at.at_m.y - pitch * at.at_m.x), -kMostLevel_m, kMostLevel_m);
      const double late = std::clamp(2 * time_s_ / end_s_ - 1.5, 0.0, 1.0);  // from three quarters of the step on
      z -= std::min(late * params.tip_height * stance().raised_m[index(support_)], kMostTip_m);
    }
    const math::Quat q_support_sole = math::Quat::from_axis_angle({0, 0, 1}, at.yaw_rad) *
                                      math::Quat::from_axis_angle({0, 1, 0}, turn_pitch) *
                                      math::Quat::from_axis_angle({1, 0, 0}, turn_roll);
    kinematics::Pose sole{{at.at_m.x, at.at_m.y, z}, q_support_sole};
    if (!carries) {
      sole.p_m += kick.at_m;
      sole.q = sole.q * kick.turn;
    }
    figure_->place_sole(side, to_torso * sole, targets_rad);
    const Vec2 push = both ? at.at_m : (carries ? cop_m_ : foot_.at_m);
    loads[index(side)] = {to_torso.q.rotate({0, 0, carried * figure_->mass_kg() * kGravity_mps2}),
                          to_torso.of({push.x, push.y, z})};
  }
  // Each arm swings with the other leg.
  for (const Side side : kSides) {
    const std::size_t shoulder = figure_->shoulder_pitch(side);
    if (shoulder == kinematics::kNone) continue;
    const Planar leg = other(side) == support_ ? Planar{} : foot_;
    const double ahead_m = turned(leg.at_m - torso_at, -yaw).x;
    targets_rad[shoulder] -= params.arm_swing * math::atan2(ahead_m, params.height_m);
  }
  lead_.step({params.lead_s, params.servo_gain_per_rad, params.weight_ahead, params.play_rad}, loads, dt_s,
             targets_rad.first(figure_->joints()));
  figure_->limit(targets_rad);
}

}  // namespace sinew::motion
