#include "robots/quad/mission.hpp"

#include "control/limits.hpp"
#include "control/plausible.hpp"

namespace sinew::control {

using namespace std::chrono_literals;

void Mission::declare(rt::Declaration& d) {
  d.in("state", state_, {.max_age = 20ms});
  d.in("safety", safety_, {.optional = true, .supervises = true});
  d.in("pilot", pilot_, {.optional = true, .previous = true, .supervises = true});
  d.in("ahead", ahead_, {.optional = true});
  d.in("told_pad", told_pad_, {.optional = true});
  d.in("guide", guide_, {.max_age = 300ms, .optional = true});
  d.out("setpoint", setpoint_);
  d.out("mission", mission_);
  d.state(plan_);
  MissionParams& p = plan_.params;
  const auto seconds = [&](const char* name, double& v, const char* doc) {
    d.param(name, v, {.unit = "s", .min = 0, .max = 3600, .doc = doc});
  };
  const auto metres = [&](const char* name, double& v, const char* doc) {
    d.param(name, v, {.unit = "m", .min = 0.01, .max = 100, .doc = doc});
  };
  const auto speed = [&](const char* name, double& v, const char* doc) {
    d.param(name, v, {.unit = "m/s", .min = 0.01, .max = 20, .doc = doc});
  };
  seconds("settle_s", p.settle_s, "of valid estimate before arming");
  seconds("spin_up_s", p.spin_up_s, "motors idle before the climb");
  metres("search_height_m", p.search_height_m, "above ground");
  metres("approach_height_m", p.approach_height_m, "above the pad");
  speed("climb_mps", p.climb_mps, "of the climb to the search height");
  speed("speed_mps", p.speed_mps, "horizontal");
  d.param("accel_mps2", p.accel_mps2,
          {.unit = "m/s^2", .min = 0.05, .max = 20, .doc = "horizontal and vertical, from point to point"});
  metres("search_spacing_m", p.search_spacing_m, "of the turns of the spiral");
  metres("search_radius_m", p.search_radius_m, "the spiral ends there; then it begins again");
  metres("arrived_m", p.arrived_m, "off the place by less, and twice as much in height: arrived");
  speed("arrived_mps", p.arrived_mps, "and slower than this");
  seconds("look_s", p.look_s, "hovering before the search");
  seconds("hold_s", p.hold_s, "hovering above the pad");
  speed("sink_fast_mps", p.sink_fast_mps, "of the descent");
  speed("sink_slow_mps", p.sink_slow_mps, "near the ground");
  metres("slow_below_m", p.slow_below_m, "height of the last, slow part of the descent");
  metres("centred_m", p.centred_m, "off the pad by more: sinking pauses");
  d.param("centred_per_m", p.centred_per_m, {.unit = "1", .min = 0, .max = 2, .doc = "more of that per height"});
  metres("commit_below_m", p.commit_below_m, "lands without further sightings");
  seconds("pad_lost_s", p.pad_lost_s, "without a sighting");
  metres("feet_below_base_m", p.feet_below_base_m, "height of the base while it stands");
  metres("touch_margin_m", p.touch_margin_m, "higher than that by less counts as low");
  speed("touch_mps", p.touch_mps, "vertical; less counts as slow");
  seconds("touch_s", p.touch_s, "low and slow for this long is the ground");
  speed("stuck_mps", p.stuck_mps, "slower than this although sinking is wanted");
  seconds("stuck_s", p.stuck_s, "for this long is the ground");
  seconds("stuck_high_s", p.stuck_high_s, "the same where the range finder says otherwise");
  metres("slow_unseen_m", p.slow_unseen_m, "sinks slowly from so much higher without range finder");
  seconds("timeout_s", p.timeout_s, "of the flight");
  seconds("climb_limit_s", p.climb_limit_s, "of the climb; then it aborts");
  seconds("hold_limit_s", p.hold_limit_s, "above the pad; then it descends though it moves");
  seconds("abort_limit_s", p.abort_limit_s, "sinking after an abort before disarming");
  speed("fall_mps", p.fall_mps, "sinking faster is falling: it aborts");
  seconds("felt_s", p.felt_s, "not sinking in the descent for this long: lands without further sightings");
  seconds("blind_s", p.blind_s, "sinking without height before disarming");
  seconds("estimate_lost_s", p.estimate_lost_s, "before it aborts");
  d.param("land_x_m", p.land_x_m,
          {.unit = "m", .min = -100, .max = 100, .doc = "where it lands, from the pad's centre"});
  d.param("land_y_m", p.land_y_m, {.unit = "m", .min = -100, .max = 100, .doc = "likewise"});
  d.param("after_mate", after_mate_, {.doc = "starts when the mate of `ahead` has landed"});
  d.param("guided", guided_, {.doc = "the velocity in `guide` flies the landing, from the search on"});
  metres("told_std_m", p.told_std_m, "a told pad that is less sure is not believed, 1 sigma");
  seconds("ahead_silent_s", p.ahead_silent_s, "a mate ahead that is not heard for so long is waited for no more");
  d.param("retries", p.retries, {.unit = "1", .min = 0, .max = 100, .doc = "lost pads before it aborts"});
}

rt::StepStatus Mission::step(const rt::Step& step) noexcept {
  const msg::NavState* state = state_.fresh(step.now);
  if (!state) return rt::StepStatus::stale;
  if (!plausible(*state)) return rt::StepStatus::fault;
  if (const msg::SafetyState* safety = safety_.get()) plan_.set_safety({safety->permitted, safety->action});
  const double dt_s = step_seconds(step.dt);
  if (after_mate_) {
    const msg::MissionState* ahead = ahead_.get();
    plan_.set_ahead(ahead ? &ahead->phase : nullptr, dt_s);
  }
  if (const msg::PlaceEstimate* told = told_pad_.get()) {
    const double most = plan_.params.told_std_m * plan_.params.told_std_m;
    if (told->covariance_m2[0] <= most && told->covariance_m2[4] <= most) plan_.set_told_pad(math::Vec3(told->p_m));
  }
  if (guided_) {
    const msg::FlightSetpoint* guide = guide_.fresh(step.now);
    const math::Vec3 v = guide ? math::Vec3(guide->v_world_mps) : math::Vec3{};
    plan_.set_guide(guide && plausible(*guide) ? &v : nullptr);
  }
  if (const msg::PilotSwitches* pilot = pilot_.get(); pilot && pilot->take_over)
    plan_.stand_by(step.now, *state);
  else
    plan_.step(step.now, *state, dt_s);
  setpoint_.loan() = plan_.setpoint();
  mission_.loan() = plan_.state();
  return rt::StepStatus::ok;
}

}  // namespace sinew::control
