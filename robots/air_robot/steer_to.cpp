#include "robots/air_robot/steer_to.hpp"

#include "control/limits.hpp"
#include "control/plausible.hpp"

namespace sinew::air_robot {

using namespace std::chrono_literals;

void SteerTo::declare(rt::Declaration& d) {
  d.in("state", state_, {.max_age = 500ms});
  d.in("head", head_, {.max_age = 500ms});
  d.in("safety", safety_, {.optional = true, .supervises = true});
  d.out("velocity", velocity_);
  d.out("mission", mission_);
  d.state(law_);
  SteerToParams& p = law_.params;
  const auto metres = [&](const char* name, double& v, double least, double most, const char* doc) {
    d.param(name, v, {.unit = "m", .min = least, .max = most, .doc = doc});
  };
  const auto speed = [&](const char* name, double& v, const char* doc) {
    d.param(name, v, {.unit = "m/s", .min = 0.01, .max = 20, .doc = doc});
  };
  metres("height_m", p.height_m, 0.3, 50, "of the flight, over the ground");
  metres("target_height_m", p.target_height_m, 0, 20, "of the target's middle, over the ground");
  metres("camera_x_m", p.camera_x_m, -2, 2, "in base, from where the head looks: forward");
  metres("camera_z_m", p.camera_z_m, -2, 2, "in base, from where the head looks: up");
  speed("speed_mps", p.speed_mps, "towards the target, at most");
  speed("climb_mps", p.climb_mps, "up and down, at most");
  d.param("turn_radps", p.turn_radps, {.unit = "rad/s", .min = 0.01, .max = 5, .doc = "at most"});
  d.param("accel_mps2", p.accel_mps2, {.unit = "m/s^2", .min = 0.05, .max = 50, .doc = "change of the velocity"});
  d.param("gain_per_s", p.gain_per_s, {.unit = "1/s", .min = 0.05, .max = 5, .doc = "velocity for each m"});
  d.param("learn_per_s2", p.learn_per_s2,
          {.unit = "1/s^2", .min = 0, .max = 5, .doc = "velocity a second for each m: wind, a target that moves"});
  metres("learn_within_m", p.learn_within_m, 0, 20, "of the target; farther away nothing is learned");
  d.param("learn_most_mps", p.learn_most_mps, {.unit = "m/s", .min = 0, .max = 10, .doc = "of what is learned"});
  d.param("height_per_s", p.height_per_s, {.unit = "1/s", .min = 0.05, .max = 5, .doc = "climb for each m"});
  d.param("turn_per_s", p.turn_per_s, {.unit = "1/s", .min = 0.05, .max = 5, .doc = "turn for each rad"});
  metres("turn_from_m", p.turn_from_m, 0, 20, "nearer to the target it does not turn towards it");
  metres("arrived_m", p.arrived_m, 0.05, 5, "horizontally: over the target");
  metres("farthest_m", p.farthest_m, 1, 1000, "a target is no farther away");
  d.param("level_rad", p.level_rad,
          {.unit = "rad", .min = 0.005, .max = 0.5, .doc = "a target is at least so far below the horizon"});
  d.param("stay_s", p.stay_s, {.unit = "s", .min = 0, .max = 600, .doc = "over the target; then the mission is done"});
  metres("landed_m", p.landed_m, -5, 5, "lower is on the ground");
}

rt::StepStatus SteerTo::step(const rt::Step& step) noexcept {
  const msg::NavState* nav = state_.fresh(step.now);
  const msg::HeadState* head = head_.fresh(step.now);
  if (!nav || !head || nav->attitude_valid == 0 || nav->height_valid == 0) return rt::StepStatus::stale;
  if (!control::is_rotation(nav->q_world_base) || !control::within(nav->p_world_m, control::kMostAway_m) ||
      !control::within({head->azimuth_rad, head->elevation_rad, 0}, 10))
    return rt::StepStatus::fault;
  if (const msg::SafetyState* safety = safety_.get()) law_.set_safety(*safety);
  law_.step(step.now, *nav, *head, control::step_seconds(step.dt));
  msg::VelocityCommand& out = velocity_.loan();
  out.stamp = nav->stamp;
  out.linear_mps = law_.velocity_mps().to<msg::Vec3>();
  out.angular_radps.z = law_.turn_radps();
  mission_.loan() = law_.mission();
  return rt::StepStatus::ok;
}

}  // namespace sinew::air_robot
