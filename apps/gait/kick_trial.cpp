#include "apps/gait/kick_trial.hpp"

#include <algorithm>

#include "math/random.hpp"
#include "motion/kick.hpp"

namespace sinew::gait {
namespace {

constexpr double kBeforeKick_s = 1.5, kAfterKick_s = 3, kMostKick_s = 12;
constexpr double kGap_m = 0.02;      // between foot and ball of a kick from a stand
constexpr double kStepGap_m = 0.02;  // of a kick within a step, at the place where the foot would land
constexpr double kTouch_mps = 0.05;

}  // namespace

std::optional<KickResult> run_kick(const GaitSetup& setup, const KickTrial& trial, std::string& why) {
  const auto rig = Rig::create(setup, trial.seed, why, {}, true);
  if (!rig) return std::nullopt;
  math::Random random(trial.seed, 0xba11);
  motion::Walk walk = rig->make_walk();
  motion::Kick kick(rig->figure(), setup.book.walk, setup.book.rest_rad);
  kick.forward = setup.book.kick_forward;
  kick.outward = setup.book.kick_outward;
  walk.reset(rig->sense());
  const plant::BallSize ball_size;
  const motion::LegOfFigure& leg = rig->figure().leg(trial.foot);
  const double toward = motion::sign(trial.foot);

  KickResult out;
  math::Vec3 ball_m;
  double heading = 0, begin_s = -1;
  bool was_kicking = false;
  for (int tick = 0;; ++tick) {
    const double t_s = tick * kControl_s - kBeforeKick_s;
    if ((begin_s >= 0 && t_s > begin_s + kAfterKick_s) || t_s > kMostKick_s) break;
    const motion::Sensed sensed = rig->sense();
    const plant::BodyTruth& truth = rig->truth();
    const auto lay_ball = [&](const math::Vec3& foot_m, double gap_m) {
      // Foot: middle of the sole, in the frame of the heading.
      const double aside = random.uniform(-0.01, 0.01), before = random.uniform(0, 0.01);
      motion::Vec2 at{foot_m.x, foot_m.y};
      if (trial.way == motion::KickWay::forward)
        at = at + motion::turned({0.5 * leg.sole_length_m + ball_size.radius_m + gap_m + before, aside}, heading);
      else
        at = at +
             motion::turned({aside, toward * (0.5 * leg.sole_width_m + ball_size.radius_m + gap_m + before)}, heading);
      ball_m = {at.x, at.y, ball_size.radius_m};
      rig->pitch().place_ball(ball_m);
      begin_s = t_s;
    };
    const auto sole = [&](motion::Side side) { return (truth.link[rig->figure().leg(side).foot] * leg.sole).p_m; };
    if (trial.walking) {
      const bool go = t_s >= 0 && (begin_s < 0 || t_s < begin_s + 1);
      if (t_s >= 2 && begin_s < 0 && !walk.kicks()) walk.kick(trial.foot, trial.way);
      walk.step({.forward_mps = go ? 0.1 : 0, .walk = go}, sensed, kControl_s, rig->targets());
      if (walk.kicks() && walk.support() != trial.foot && begin_s < 0 && walk.phase() == motion::WalkPhase::step &&
          t_s > 2 && walk.kicking()) {
        // The kicking step begins: the ball is before the place where this foot will land.
        const motion::Side support = motion::other(trial.foot);
        const kinematics::Pose& foot = truth.link[rig->figure().leg(support).foot];
        heading = foot.q.yaw();
        const math::Vec3 at = sole(support);
        const motion::Vec2 landing = motion::turned(walk.landing().at_m, heading);
        lay_ball({at.x + landing.x, at.y + landing.y, 0}, kStepGap_m);
      }
    } else if (t_s < 0) {
      walk.step({}, sensed, kControl_s, rig->targets());
    } else {
      if (begin_s < 0) {
        heading = truth.torso.q.yaw();
        lay_ball(sole(trial.foot), kGap_m);
        kick.start(trial.foot, trial.way);
      }
      if (kick.active()) {
        walk.sense_only(sensed, kControl_s);
        kick.step(walk.q_world_torso(), walk.tilt.rate_radps(), kControl_s, rig->targets());
        was_kicking = true;
      } else {
        if (was_kicking) walk.take_over(sensed), was_kicking = false;
        walk.step({}, sensed, kControl_s, rig->targets());
      }
    }
    rig->act(rig->targets());
    if (truth.fallen || truth.body_down) out.fell = true;
    if (begin_s < 0) continue;
    const plant::BallTruth& ball = rig->pitch().ball();
    const double speed = math::hypot(ball.v_mps.x, ball.v_mps.y);
    if (speed > kTouch_mps) out.touched = true;
    out.speed_mps = std::max(out.speed_mps, speed);
    const double wanted = heading + (trial.way == motion::KickWay::forward ? 0 : toward * 0.5 * math::kPi);
    const motion::Vec2 way{ball.p_m.x - ball_m.x, ball.p_m.y - ball_m.y};
    out.rolls_m = motion::norm(way);
    if (out.rolls_m > 0.02) out.direction_deg = math::wrap_pi(math::atan2(way.y, way.x) - wanted) * 180 / math::kPi;
    if (out.fell) break;
  }
  return out;
}

}  // namespace sinew::gait
