#include "control/head_follower.hpp"

#include "control/limits.hpp"
#include "control/plausible.hpp"

namespace sinew::control {

using namespace std::chrono_literals;

namespace {

constexpr double kMostJoint_rad = 7, kMostJoint_radps = 100;  // a turn and a bit; ten times what a servo does

double known(double radps) { return math::is_nan(radps) ? 0 : radps; }  // NaN: this joint does not tell it

bool plausible(const msg::JointState& s) {
  return s.count == 2 && within({s.position_rad[0], s.position_rad[1], 0}, kMostJoint_rad) &&
         within({known(s.velocity_radps[0]), known(s.velocity_radps[1]), 0}, kMostJoint_radps);
}

/// A unit vector, roughly.
bool plausible(const msg::BallSighting& s) {
  if (!s.found) return true;
  const msg::Vec3& d = s.direction_optical;
  const double n = d.x * d.x + d.y * d.y + d.z * d.z;
  return n > 0.98 && n < 1.02 && s.angular_radius_rad >= 0 && s.angular_radius_rad < 1.6 && s.confidence >= 0 &&
         s.confidence <= 1;
}

}  // namespace

void HeadFollower::declare(rt::Declaration& d) {
  d.in("state", state_, {.max_age = 1s});
  d.in("joints", joints_, {.max_age = 1s});
  d.in("ball", ball_, {.depth = 4});
  d.in("safety", safety_, {.optional = true, .supervises = true});
  d.out("command", command_, {.channels = 2});
  d.out("head", head_);
  d.state(law_);
  HeadParams& p = law_.params;
  const auto angle = [&](const char* name, double& v, const char* doc) {
    d.param(name, v, {.unit = "rad", .min = -3.15, .max = 3.15, .doc = doc});
  };
  const auto seconds = [&](const char* name, double& v, double most, const char* doc) {
    d.param(name, v, {.unit = "s", .min = 0, .max = most, .doc = doc});
  };
  const auto speed = [&](const char* name, double& v, const char* doc) {
    d.param(name, v, {.unit = "rad/s", .min = 0.01, .max = 50, .doc = doc});
  };
  angle("pan_least_rad", p.pan_least_rad, "to the right");
  angle("pan_most_rad", p.pan_most_rad, "to the left");
  angle("tilt_least_rad", p.tilt_least_rad, "up");
  angle("tilt_most_rad", p.tilt_most_rad, "down");
  speed("speed_radps", p.speed_radps, "largest change of a setpoint");
  seconds("lag_s", p.lag_s, 1, "of a servo behind a setpoint that moves");
  seconds("rate_smooth_s", p.rate_smooth_s, 1, "of the base's angular rate");
  seconds("joints_lag_s", p.joints_lag_s, 1, "behind their setpoints, of joints that tell only now and then; 0: often");
  seconds("state_age_s", state_age_s_, 1, "of the state, at most");
  seconds("joints_age_s", joints_age_s_, 1, "of the joints, at most");
  seconds("coast_s", p.coast_s, 60, "unseen for longer: search");
  seconds("blind_s", p.blind_s, 60, "without a picture for longer: hold");
  speed("scan_radps", p.scan_radps, "of the search");
  angle("scan_reach_rad", p.scan_reach_rad, "of the search, to both sides at most");
  d.param("view_rad", p.view_rad,
          {.unit = "rad", .min = 0.01, .max = 1.5, .doc = "half the picture's width, with the whole ball in it"});
  angle("scan_elevation_rad", p.scan_elevation_rad, "of a search of all that it may see");
  d.param("imu_on_base", imu_on_base_, {.doc = "the state is that of the base, not of the head"});
  speed("turn_radps", p.turn_radps, "of the aim when it is not the ball's");
  const rt::ParamOptions turn{.unit = "1", .min = -1, .max = 1, .doc = "unit quaternion, optical frame to head"};
  d.param("camera_qw", p.q_head_optical.w, turn);
  d.param("camera_qx", p.q_head_optical.x, turn);
  d.param("camera_qy", p.q_head_optical.y, turn);
  d.param("camera_qz", p.q_head_optical.z, turn);
  BallTrackParams& t = law_.track.params;
  d.param("ball_accel_radps2", t.accel_radps2, {.unit = "rad/s^2", .min = 0.01, .max = 1000, .doc = "1 sigma"});
  d.param("ball_noise_rad", t.noise_rad, {.unit = "rad", .min = 1e-5, .max = 0.5, .doc = "of a sighting, 1 sigma"});
  d.param("ball_gate", t.gate, {.unit = "1", .min = 1, .max = 1e6, .doc = "largest squared normalised innovation"});
  d.param("ball_refuse", t.refuse, {.unit = "1", .min = 1, .max = 100, .doc = "sightings in a row that begin anew"});
  seconds("ball_anew_s", t.anew_s, 10, "unseen for longer: a sighting says nothing about the speed");
  d.param("ball_below", ball_below_, {.doc = "the ball may pass straight below"});
  seconds("ball_settle_s", t.settle_s, 60, "in which an unseen ball's speed is forgotten");
}

rt::StepStatus HeadFollower::step(const rt::Step& step) noexcept {
  const msg::NavState* nav = state_.fresh(step.now);
  const msg::JointState* joints = joints_.fresh(step.now);
  if (!nav || !joints || !nav->attitude_valid || msg::seconds(step.now - nav->stamp) > state_age_s_ ||
      msg::seconds(step.now - joints->stamp) > joints_age_s_)
    return rt::StepStatus::stale;
  // A joint without a position yet: its drive has no power yet. Not a fault: faults would end the module.
  if (joints->count == 2 && (math::is_nan(joints->position_rad[0]) || math::is_nan(joints->position_rad[1])))
    return rt::StepStatus::stale;
  if (!is_rotation(nav->q_world_base) || !within(nav->gyro_radps, kMostTurn_radps) || !plausible(*joints))
    return rt::StepStatus::fault;
  law_.params.imu_on_base = imu_on_base_ ? 1 : 0;
  law_.track.params.below = ball_below_ ? 1 : 0;
  for (const msg::BallSighting& s : ball_)
    if (plausible(s)) law_.add(s);
  if (const msg::SafetyState* safety = safety_.get()) law_.set_safety(*safety);
  law_.step(step.now, *nav, *joints, step_seconds(step.dt));
  msg::ActuatorCommand& out = command_.loan();
  out.stamp = nav->stamp;
  out.count = 2;
  out.armed = law_.armed();
  out.value[0] = law_.setpoint_rad()[0], out.value[1] = law_.setpoint_rad()[1];
  head_.loan() = law_.state();
  return rt::StepStatus::ok;
}

}  // namespace sinew::control
