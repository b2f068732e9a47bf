#include "motion/ball_stop.hpp"

namespace sinew::motion {

std::array<FootPlace, 10> BallStop::way() const {
  const BallStopParams& p = params;
  const auto at = [&](double over, Vec2 from_place_m, double up_m) {
    return FreeFoot{.over = over,
                    .from_place_m = {from_place_m.x, sign(foot_) * from_place_m.y},
                    .up_m = up_m,
                    .torso_down_m = from_place_m.y > 0 ? p.torso_down_m : 0,
                    .tall = 1};
  };
  const Vec2 place{}, aside{0, p.aside_m};
  return {{{p.shift_s, at(1, place, 0)},
           {p.out_s, at(1, aside, p.lift_m)},
           {p.down_s, at(1, aside, 0)},
           {p.settle_s, at(p.over, aside, 0)},
           {p.hold_s, at(p.over, aside, 0)},
           {p.settle_s, at(1, aside, 0)},
           // Behind the ball, which lies at the toes.
           {p.down_s, at(1, {-p.back_m, p.aside_m}, p.lift_m)},
           {p.out_s, at(1, {-p.back_m, 0}, p.lift_m)},
           {p.down_s, at(1, place, 0)},
           {p.shift_s, {}}}};
}

void BallStop::start(Side foot) {
  foot_ = foot;
  time_s_ = 0;
  active_ = true;
  stand_.start();
}

void BallStop::step(const math::Quat& q_world_torso, const math::Vec3& rate_radps, double dt_s,
                    std::span<double> targets_rad) {
  time_s_ += dt_s;
  if (time_s_ >= lasts_s()) active_ = false;
  const FreeFoot foot = along_way(way(), time_s_);
  // Feet that are far apart hold the body by themselves; ankles that answer its roll, too, make it rock.
  OneFootBalance balance = balance_of(params);
  balance.gyro_roll_s *= foot.over;
  balance.tilt_roll *= foot.over;
  stand_.step(foot_, foot, balance, q_world_torso, rate_radps, dt_s, targets_rad);
}

}  // namespace sinew::motion
