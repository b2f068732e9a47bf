#include "robots/kid/kick_plan.hpp"

namespace sinew::kid {

using namespace std::chrono_literals;
using msg::MissionPhase;

namespace {

constexpr std::uint32_t kRequest = 1;
constexpr double kGetsUp_s = 8;  // a robot that fell at the kick has the time to rise
constexpr double kLookAhead_m = 0.25, kBallRadius_m = 0.07;

}  // namespace

void KickPlan::declare(rt::Declaration& d) {
  d.in("gait", gait_, {.max_age = 500ms});
  d.in("safety", safety_, {.optional = true, .supervises = true});
  d.out("velocity", velocity_);
  d.out("kick", kick_);
  d.out("gaze", gaze_);
  d.out("mission", mission_);
  d.state(in_phase_s_, since_, phase_, asked_);
  d.param("motion", motion_,
          {.min = 0, .max = 2, .doc = "0: a kick forward, 1: outward, 2: stop of a ball that rolls"});
  d.param("foot", foot_, {.min = 0, .max = 1, .doc = "0: the left one, 1: the right one"});
  d.param("in_walk", in_walk_, {.doc = "a kick within a step"});
  d.param("at_s", at_s_, {.unit = "s", .min = 0.5, .max = 600, .doc = "when it asks, from when it was on its feet"});
  d.param("forward_mps", forward_mps_,
          {.unit = "m/s", .min = -1, .max = 1, .doc = "how fast it walks until then; 0: it stands"});
  d.param("after_s", after_s_, {.unit = "s", .min = 0, .max = 60, .doc = "how long it stands at the end"});
}

void KickPlan::reset() {
  in_phase_s_ = 0;
  since_ = {};
  phase_ = MissionPhase::wait;
  asked_ = 0;
}

void KickPlan::enter(MissionPhase phase, rt::Time now) {
  phase_ = phase;
  in_phase_s_ = 0;
  since_ = now;
}

/// wait: it is not on its feet yet; approach: it stands or walks until it is time; hold: it has asked; then done.
rt::StepStatus KickPlan::step(const rt::Step& step) noexcept {
  const msg::GaitState* gait = gait_.fresh(step.now);
  if (!gait) return rt::StepStatus::stale;
  in_phase_s_ += msg::seconds(step.dt);
  const msg::SafetyState* safety = safety_.get();
  const bool calm = !safety || safety->action == msg::FailsafeAction::none;
  const bool upright = gait->mode == msg::GaitMode::stand || gait->mode == msg::GaitMode::walk;
  const bool is_mine = asked_ != 0 && gait->request == kRequest;
  if (phase_ == MissionPhase::wait && upright) enter(MissionPhase::approach, step.now);
  if (phase_ == MissionPhase::abort && in_phase_s_ >= kGetsUp_s) enter(MissionPhase::done, step.now);
  if (phase_ == MissionPhase::approach && in_phase_s_ >= at_s_) {
    enter(MissionPhase::hold, step.now);
    msg::KickRequest& kick = kick_.loan();
    kick.stamp = gait->stamp;
    kick.id = kRequest;
    kick.motion = static_cast<msg::BallMotion>(motion_);
    kick.foot = static_cast<msg::Foot>(foot_);
    kick.in_walk = in_walk_ ? 1 : 0;
    asked_ = 1;
  } else if (phase_ == MissionPhase::hold) {
    if (is_mine && gait->progress == msg::RequestProgress::done && gait->mode == msg::GaitMode::stand) {
      if (msg::seconds(step.now - gait->mode_since) >= after_s_) enter(MissionPhase::done, step.now);
    } else if (!calm || gait->refused == kRequest || (is_mine && gait->progress == msg::RequestProgress::broken_off)) {
      enter(MissionPhase::abort, step.now);
    }
  }

  msg::VelocityCommand& velocity = velocity_.loan();
  velocity.stamp = gait->stamp;
  if (phase_ == MissionPhase::approach && calm) velocity.linear_mps.x = forward_mps_;
  msg::GazeCommand& gaze = gaze_.loan();
  gaze.stamp = gait->stamp;
  gaze.aim = msg::GazeAim::point;
  gaze.frame = msg::GazeFrame::robot;
  gaze.to = {kLookAhead_m, 0, kBallRadius_m};
  msg::MissionState& mission = mission_.loan();
  mission.stamp = step.now;
  mission.phase_since = since_;
  mission.phase = phase_;
  return rt::StepStatus::ok;
}

}  // namespace sinew::kid
