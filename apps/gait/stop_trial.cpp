#include "apps/gait/stop_trial.hpp"

#include <algorithm>

#include "math/random.hpp"
#include "motion/ball_stop.hpp"

namespace sinew::gait {
namespace {

constexpr double kBeforeStop_s = 1.5, kRollsAlone_m = 0.3, kAfter_s = 1;
constexpr double kMostBeside_m = 0.02, kMostTurn_rad = 2 * math::kPi / 180;

}  // namespace

std::optional<StopResult> run_stop(const GaitSetup& setup, const StopTrial& trial, std::string& why) {
  const auto rig = Rig::create(setup, trial.seed, why, {}, true);
  if (!rig) return std::nullopt;
  math::Random random(trial.seed, 0x57a9);
  motion::Walk walk = rig->make_walk();
  motion::BallStop stop(rig->figure(), setup.book.walk, setup.book.rest_rad);
  stop.params = setup.book.stop;
  walk.reset(rig->sense());
  const plant::BallSize ball_size;
  const motion::LegOfFigure& leg = rig->figure().leg(trial.foot);

  StopResult out;
  const double ready_s = stop.ready_s(), end_s = stop.lasts_s() + kAfter_s;
  const double start_mps =
      math::sqrt(trial.speed_mps * trial.speed_mps + 2 * setup.ground.ball_deceleration_mps2 * kRollsAlone_m);
  bool was_stopping = false, rolls = false;
  motion::Planar stood;  // when it was asked to stop the ball: from there its line is measured
  for (int tick = 0;; ++tick) {
    const double t_s = tick * kControl_s - kBeforeStop_s;
    if (t_s > end_s) break;
    const motion::Sensed sensed = rig->sense();
    const plant::BodyTruth& truth = rig->truth();
    if (t_s >= 0 && !was_stopping && t_s < kControl_s && trial.stops) {
      stop.start(trial.foot);
      was_stopping = true;
    }
    if (t_s < kControl_s) stood = {{truth.torso.p_m.x, truth.torso.p_m.y}, truth.torso.q.yaw()};
    if (!rolls && t_s >= ready_s) {  // now it waits
      rolls = true;
      const double heading = stood.yaw_rad, turn = random.uniform(-kMostTurn_rad, kMostTurn_rad);
      const double aside = motion::sign(trial.foot) * trial.aside_m + random.uniform(-kMostBeside_m, kMostBeside_m);
      const motion::Vec2 toes =
          stood.at_m + motion::turned({0.5 * leg.sole_length_m + ball_size.radius_m, aside}, heading);
      const motion::Vec2 from = toes + motion::turned({kRollsAlone_m, 0}, heading + turn);
      const motion::Vec2 speed = motion::turned({-start_mps, 0}, heading + turn);
      rig->pitch().place_ball({from.x, from.y, ball_size.radius_m}, {speed.x, speed.y, 0});
    }
    if (was_stopping && stop.active()) {
      walk.sense_only(sensed, kControl_s);
      stop.step(walk.q_world_torso(), walk.tilt.rate_radps(), kControl_s, rig->targets());
    } else {
      if (was_stopping) walk.take_over(sensed), was_stopping = false;
      walk.step({}, sensed, kControl_s, rig->targets());
    }
    const plant::BallTruth before = rig->pitch().ball();
    rig->act(rig->targets());
    if (truth.fallen || truth.body_down) out.fell = true;
    const plant::BallTruth& ball = rig->pitch().ball();
    if (rolls && !out.touched && ball.touched_by >= 0) {
      out.touched = true;
      out.touch_mps = math::hypot(before.v_mps.x, before.v_mps.y);
    }
    out.speed_mps = math::hypot(ball.v_mps.x, ball.v_mps.y);
    out.away_m = math::hypot(ball.p_m.x - truth.torso.p_m.x, ball.p_m.y - truth.torso.p_m.y);
    if (out.fell) break;
  }
  return out;
}

}  // namespace sinew::gait
