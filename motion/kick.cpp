#include "motion/kick.hpp"

#include <algorithm>

namespace sinew::motion {

std::array<FootPlace, 8> Kick::way() const {
  const KickParams& p = params();
  const bool ahead = way_ == KickWay::forward;
  const auto at = [&](double along_m, double up_m, double tip_rad) {
    return FreeFoot{.over = 1,
                    .from_place_m = along_m * (ahead ? Vec2{1, 0} : Vec2{0, sign(foot_)}),
                    .up_m = up_m,
                    .pitch_rad = ahead ? tip_rad : 0,
                    .roll_rad = ahead ? 0 : -tip_rad,
                    .lean_back_rad = ahead ? p.lean_back_rad : 0,
                    .lean_away_rad = ahead ? 0 : p.lean_back_rad,
                    .tall = 1};
  };
  const FreeFoot back = at(-p.back_m, p.lift_m, p.back_tip_rad);
  const FreeFoot struck = at(p.strike_m, p.strike_lift_m, -p.strike_tip_rad);
  return {{{p.shift_s, at(0, 0, 0)},
           {p.lift_s, back},
           {p.still_s, back},
           {p.strike_s, struck, true},
           {p.follow_s, struck},
           {p.return_s, at(0, p.lift_m, 0)},
           {p.lower_s, at(0, 0, 0)},
           {p.shift_s, {}}}};
}

void Kick::start(Side foot, KickWay way) {
  foot_ = foot;
  way_ = way;
  time_s_ = 0;
  active_ = true;
  stand_.start();
}

void Kick::step(const math::Quat& q_world_torso, const math::Vec3& rate_radps, double dt_s,
                std::span<double> targets_rad) {
  time_s_ += dt_s;
  if (time_s_ >= lasts_s()) active_ = false;
  FreeFoot foot = along_way(way(), time_s_);
  const bool ahead = way_ == KickWay::forward;
  const double along_m = ahead ? foot.from_place_m.x : sign(foot_) * foot.from_place_m.y;
  foot.arms_rad = params().arm_swing_rad * std::max(0.0, along_m) / params().strike_m;
  stand_.step(foot_, foot, balance_of(params()), q_world_torso, rate_radps, dt_s, targets_rad);
}

}  // namespace sinew::motion
