#include "robots/kid/figure_walk.hpp"

#include <array>

#include "math/elementary.hpp"

namespace sinew::kid {

using namespace std::chrono_literals;
using msg::MissionPhase;

void FigureWalk::declare(rt::Declaration& d) {
  d.in("gait", gait_, {.max_age = 500ms});
  d.in("safety", safety_, {.optional = true, .supervises = true});
  d.in("referee", referee_, {.max_age = 3s, .optional = true});
  d.out("velocity", velocity_);
  d.out("mission", mission_);
  d.out("gaze", gaze_);
  d.state(in_phase_s_, look_s_, since_, phase_, leg_);
  d.param("stand_s", stand_s_, {.unit = "s", .min = 0, .max = 60, .doc = "before and after the figure"});
  d.param("leg_s", leg_s_, {.unit = "s", .min = 0.5, .max = 600, .doc = "of each of its straight parts"});
  d.param("forward_mps", forward_mps_, {.unit = "m/s", .min = 0, .max = 1, .doc = "forward, and in the circles"});
  d.param("side_mps", side_mps_, {.unit = "m/s", .min = 0, .max = 1, .doc = "to the left and to the right"});
  d.param("back_mps", back_mps_, {.unit = "m/s", .min = 0, .max = 1, .doc = "backward"});
  d.param("turn_radps", turn_radps_, {.unit = "rad/s", .min = 0.05, .max = 3, .doc = "in the circles"});
  d.param("heed_referee", heed_referee_, {.doc = "walk only while the game is on and it is not penalised"});
  d.param("looks_at_ball", looks_at_ball_, {.doc = "false: straight ahead; so also in the circles"});
  d.param("look_around_s", look_around_s_,
          {.unit = "s", .min = 0, .max = 60, .doc = "time of a look to the left and to the right; 0: it looks ahead"});
  d.param("look_around_rad", look_around_rad_,
          {.unit = "rad", .min = 0, .max = 2, .doc = "how far to either side it looks then"});
  d.param("look_down_rad", look_down_rad_, {.unit = "rad", .min = -0.5, .max = 1.2, .doc = "and how far down"});
  d.param("ball_x_m", ball_x_m_,
          {.unit = "m", .min = -10, .max = 10, .doc = "where the ball lies, in the odometry's frame: ahead"});
  d.param("ball_y_m", ball_y_m_, {.unit = "m", .min = -10, .max = 10, .doc = "to the left"});
  d.param("ball_z_m", ball_z_m_, {.unit = "m", .min = 0, .max = 2, .doc = "and its middle over the ground"});
}

void FigureWalk::reset() {
  in_phase_s_ = look_s_ = 0;
  since_ = {};
  phase_ = MissionPhase::wait;
  leg_ = 0;
}

void FigureWalk::enter(MissionPhase phase, rt::Time now) {
  phase_ = phase;
  in_phase_s_ = 0;
  since_ = now;
}

bool FigureWalk::may_walk(rt::Time now) const {
  if (!heed_referee_) return true;
  const msg::RefereeState* said = referee_.fresh(now);
  return said && said->phase == msg::GamePhase::playing && said->penalty == msg::GamePenalty::none;
}

rt::StepStatus FigureWalk::step(const rt::Step& step) noexcept {
  struct Leg {
    double forward, left, turn;  // shares of the speeds
  };
  static constexpr std::array<Leg, 6> kFigure{{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {1, 0, 1}, {1, 0, -1}}};
  const msg::GaitState* gait = gait_.fresh(step.now);
  if (!gait) return rt::StepStatus::stale;
  const bool may = may_walk(step.now);
  if (may || phase_ == MissionPhase::hold) in_phase_s_ += msg::seconds(step.dt);
  const msg::SafetyState* safety = safety_.get();
  const bool calm = !safety || safety->action == msg::FailsafeAction::none;
  const bool upright = gait->mode == msg::GaitMode::stand || gait->mode == msg::GaitMode::walk;
  if (phase_ == MissionPhase::wait && calm && may && upright && in_phase_s_ >= stand_s_)
    enter(MissionPhase::approach, step.now);
  if (phase_ == MissionPhase::approach && !calm) enter(MissionPhase::hold, step.now);
  if (phase_ == MissionPhase::approach && upright) {
    const bool circle = kFigure[leg_].turn != 0;
    if (in_phase_s_ >= (circle ? 2 * math::kPi / turn_radps_ : leg_s_)) {
      in_phase_s_ = 0;
      if (++leg_ == kFigure.size()) enter(MissionPhase::hold, step.now);
    }
  }
  if (phase_ == MissionPhase::hold && gait->mode == msg::GaitMode::stand && in_phase_s_ >= stand_s_)
    enter(MissionPhase::done, step.now);

  msg::VelocityCommand& velocity = velocity_.loan();
  velocity.stamp = gait->stamp;
  if (phase_ == MissionPhase::approach && may) {
    const Leg& leg = kFigure[leg_];
    velocity.linear_mps.x = leg.forward * (leg.forward < 0 ? back_mps_ : forward_mps_);
    velocity.linear_mps.y = leg.left * side_mps_;
    velocity.angular_radps.z = leg.turn * turn_radps_;
  }
  msg::GazeCommand& gaze = gaze_.loan();
  gaze.stamp = gait->stamp;
  gaze.aim = msg::GazeAim::ahead;
  const bool circles = phase_ == MissionPhase::approach && kFigure[leg_].turn != 0;
  if (looks_at_ball_ && !circles) {  // in a circle the neck does not reach that far round
    gaze.aim = msg::GazeAim::point;
    gaze.to = {ball_x_m_, ball_y_m_, ball_z_m_};
  }
  look_s_ += msg::seconds(step.dt);
  if (look_around_s_ > 0) {
    const double pan = look_around_rad_ * math::sin(2 * math::kPi * look_s_ / look_around_s_);
    const math::SinCos side = math::sincos(pan), down = math::sincos(look_down_rad_);
    gaze.aim = msg::GazeAim::direction;
    gaze.frame = msg::GazeFrame::robot;
    gaze.to = {down.cos * side.cos, down.cos * side.sin, -down.sin};
  }
  msg::MissionState& mission = mission_.loan();
  mission.stamp = step.now;
  mission.phase_since = since_;
  mission.phase = phase_;
  return rt::StepStatus::ok;
}

}  // namespace sinew::kid
