#include "motion/stance.hpp"

namespace sinew::motion {

void StanceSense::step(const Sensed& sensed, const math::Quat& q_level_torso, double cell_inset_m) {
  pose_.set(sensed.joints_rad, {{}, q_level_torso});
  const math::Vec3 com = pose_.centre_of_mass(), torso = pose_.link(0).p_m;
  const math::Vec3 ahead_of_torso = q_level_torso.rotate({1, 0, 0});
  const double torso_yaw_rad = math::atan2(ahead_of_torso.y, ahead_of_torso.x);
  std::array<Planar, 2> soles;
  for (const Side side : kSides) {
    const std::size_t i = index(side);
    const kinematics::Pose sole = figure_->sole(pose_, side);
    const math::Vec3 ahead = sole.q.rotate({1, 0, 0});
    const double yaw_rad = math::atan2(ahead.y, ahead.x);
    soles[i] = {{sole.p_m.x, sole.p_m.y}, yaw_rad};
    const Planar to_sole = soles[i].inverse();
    const Vec2 planar = to_sole.of({com.x, com.y});
    stance_.com_m[i] = {planar.x, planar.y, com.z - sole.p_m.z};
    const LegOfFigure& leg = figure_->leg(side);
    const math::Vec3 along = sole.q.rotate({leg.sole_length_m, 0, 0}), across = sole.q.rotate({0, leg.sole_width_m, 0});
    stance_.raised_m[i] = 0.5 * (math::fabs(along.z) + math::fabs(across.z));
    stance_.height_m[i] = torso.z - sole.p_m.z + stance_.raised_m[i];
    stance_.torso[i] = to_sole * Planar{{torso.x, torso.y}, torso_yaw_rad};

    const SoleForces& n = sensed.soles_n[i];
    const double total_n = sum(n);
    stance_.load[i] = total_n / (figure_->mass_kg() * 9.81);
    const double x = 0.5 * leg.sole_length_m - cell_inset_m, y = 0.5 * leg.sole_width_m - cell_inset_m;
    stance_.cop_m[i] = {};
    if (total_n > 0.5)
      stance_.cop_m[i] = {x * (n[0] + n[1] - n[2] - n[3]) / total_n, y * (n[0] - n[1] + n[2] - n[3]) / total_n};
  }
  stance_.right_to_left = soles[index(Side::right)].inverse() * soles[index(Side::left)];
  stance_.right_to_left.yaw_rad = math::wrap_pi(stance_.right_to_left.yaw_rad);
}

}  // namespace sinew::motion
