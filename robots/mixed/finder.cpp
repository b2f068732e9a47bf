#include "robots/mixed/finder.hpp"

#include "math/elementary.hpp"
#include "robots/gripper/delivery.hpp"

namespace sinew::mixed {

using namespace std::chrono_literals;
using msg::MissionPhase;

namespace {

constexpr double kRounds = 1.5;     // it looks from side to side so often before it turns
constexpr double kTurn_s = 2.4;     // then for so long
constexpr double kAside_rad = 0.7;  // an object further aside makes it turn
constexpr double kBrought_s = 1.5;
constexpr double kBall_m = 0.07;

}  // namespace

void Finder::declare(rt::Declaration& d) {
  d.in("gait", gait_, {.max_age = 200ms});
  d.in("ball", ball_, {.max_age = 1s, .optional = true});
  d.in("team", team_, {.max_age = 2s, .optional = true});
  d.in("safety", safety_, {.optional = true, .supervises = true});
  d.out("velocity", velocity_);
  d.out("gaze", gaze_);
  d.out("mission", mission_);
  d.param("goal_x_m", goal_x_m_,
          {.unit = "m", .min = -10, .max = 10, .doc = "where the object is to be: along the field"});
  d.param("goal_y_m", goal_y_m_, {.unit = "m", .min = -10, .max = 10, .doc = "and across the field"});
  d.param("goal_within_m", goal_within_m_, {.unit = "m", .min = 0.05, .max = 2, .doc = "so near to it is there"});
  d.param("look_s", look_s_,
          {.unit = "s", .min = 1, .max = 60, .doc = "it looks from side to side and back in this time"});
  d.param("look_rad", look_rad_, {.unit = "rad", .min = 0, .max = 2, .doc = "so far to each side"});
  d.param("down_rad", down_rad_, {.unit = "rad", .min = -0.5, .max = 1.2, .doc = "and so far down"});
  d.param("turn_radps", turn_radps_, {.unit = "rad/s", .min = 0.05, .max = 1, .doc = "where it sees nothing"});
  d.param("stand_s", stand_s_, {.unit = "s", .min = 0, .max = 60, .doc = "before it begins"});
  d.param("least_confidence", least_confidence_, {.min = 0.05, .max = 1, .doc = "of an object that it has found"});
  d.state(in_phase_s_, look_now_s_, brought_s_, since_, phase_);
}

void Finder::reset() {
  in_phase_s_ = look_now_s_ = brought_s_ = 0;
  since_ = {};
  phase_ = MissionPhase::wait;
}

void Finder::enter(MissionPhase phase, rt::Time now) {
  if (phase == phase_) return;
  phase_ = phase;
  in_phase_s_ = 0;
  since_ = now;
}

bool Finder::is_brought(rt::Time now) {
  const msg::TeamModel* team = team_.fresh(now);
  return team && gripper::lies_at(*team, {goal_x_m_, goal_y_m_}, goal_within_m_, now);
}

rt::StepStatus Finder::step(const rt::Step& step) noexcept {
  const msg::GaitState* gait = gait_.fresh(step.now);
  if (!gait) return rt::StepStatus::stale;
  const double dt_s = msg::seconds(step.dt);
  in_phase_s_ += dt_s;
  look_now_s_ += dt_s;
  const msg::BallModel* ball = ball_.fresh(step.now);
  const bool sees = ball && ball->gone == 0 && ball->confidence >= least_confidence_;
  const msg::SafetyState* safety = safety_.get();
  brought_s_ = is_brought(step.now) ? brought_s_ + dt_s : 0;
  if (phase_ != MissionPhase::done) {
    if ((safety && safety->action != msg::FailsafeAction::none) || brought_s_ > kBrought_s)
      enter(MissionPhase::done, step.now);
    else if (phase_ == MissionPhase::wait && in_phase_s_ >= stand_s_ && msg::on_its_feet(gait->mode))
      enter(MissionPhase::search, step.now);
    else if (phase_ == MissionPhase::search && sees)
      enter(MissionPhase::hold, step.now);
    else if (phase_ == MissionPhase::hold && !sees)
      enter(MissionPhase::search, step.now);
  }

  msg::VelocityCommand& velocity = velocity_.loan();
  velocity.stamp = gait->stamp;
  msg::GazeCommand& gaze = gaze_.loan();
  gaze.stamp = gait->stamp;
  if (phase_ == MissionPhase::hold && ball) {
    gaze.aim = msg::GazeAim::point;
    gaze.frame = msg::GazeFrame::robot;
    gaze.to = {ball->x_m, ball->y_m, kBall_m};
    const double aside = math::atan2(ball->y_m, ball->x_m);
    if (math::fabs(aside) > kAside_rad) velocity.angular_radps.z = aside > 0 ? turn_radps_ : -turn_radps_;
  } else {
    const math::SinCos side = math::sincos(look_rad_ * math::sin(2 * math::kPi * look_now_s_ / look_s_));
    const math::SinCos down = math::sincos(down_rad_);
    gaze.aim = msg::GazeAim::direction;
    gaze.frame = msg::GazeFrame::robot;
    gaze.to = {down.cos * side.cos, down.cos * side.sin, -down.sin};
    const double looks_s = kRounds * look_s_, round_s = looks_s + kTurn_s;
    const double in_round_s = in_phase_s_ - round_s * math::floor(in_phase_s_ / round_s);
    if (phase_ == MissionPhase::search && in_round_s > looks_s) velocity.angular_radps.z = turn_radps_;
  }
  msg::MissionState& mission = mission_.loan();
  mission.stamp = step.now;
  mission.phase_since = since_;
  mission.phase = phase_;
  if (ball) mission.target_world_m = {ball->field_x_m, ball->field_y_m, kBall_m};
  return rt::StepStatus::ok;
}

}  // namespace sinew::mixed
