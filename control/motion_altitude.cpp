#include "control/motion_altitude.hpp"

#include "control/limits.hpp"
#include "control/plausible.hpp"

namespace sinew::control {

using namespace std::chrono_literals;

void MotionAltitude::declare(rt::Declaration& d) {
  d.in("state", state_, {.max_age = 20ms});
  d.in("imu", imu_, {.depth = 32});
  d.in("motion", motion_);
  d.in("range", range_, {.optional = true});
  d.in("safety", safety_, {.optional = true, .supervises = true});
  d.out("attitude", attitude_);
  d.out("altitude", altitude_);
  d.state(law_, force_mps2_);
  d.param("height_by", height_by_, {.doc = "motion, or range: the range finder's, to compare with; at the start"});
  declare_params(d);
}

void MotionAltitude::declare_params(rt::Declaration& d) {
  MotionAltitudeParams& p = law_.params;
  const auto gain = [&](const char* name, double& v, const char* unit, const char* doc) {
    d.param(name, v, {.unit = unit, .min = 0, .max = 50, .doc = doc});
  };
  const auto seconds = [&](const char* name, double& v, const char* doc) {
    d.param(name, v, {.unit = "s", .min = 0.01, .max = 600, .doc = doc});
  };
  d.param("mass_kg", p.mass_kg, {.unit = "kg", .min = 0.05, .max = 50, .doc = "of the vehicle"});
  d.param("wanted_motion_radps", p.wanted_motion_radps,
          {.unit = "rad/s", .min = 0.05, .max = 10, .doc = "of the ground below, forward"});
  d.param("speed_mps", p.speed_mps, {.unit = "m/s", .min = 0.2, .max = 20, .doc = "through the air"});
  d.param("drag_n_per_mps", p.drag_n_per_mps,
          {.unit = "N s/m", .min = 1e-3, .max = 10, .doc = "the vehicle's drag along base x and y"});
  d.param("drag_n_per_m2ps2", p.drag_n_per_m2ps2,
          {.unit = "N s^2/m^2", .min = 0, .max = 10, .doc = "of it, with the square of the speed"});
  seconds("settle_s", p.settle_s, "at rest, level, before arming: learns the accelerometer's zero");
  seconds("spin_up_s", p.spin_up_s, "motors idle before the climb");
  d.param("climb_mps", p.climb_mps, {.unit = "m/s", .min = 0.1, .max = 5, .doc = "of the first climb"});
  d.param("accel_mps2", p.accel_mps2, {.unit = "m/s^2", .min = 0.05, .max = 5, .doc = "forward"});
  d.param("follow_share", p.follow_share,
          {.min = 0.1, .max = 1, .doc = "of the speed: from there on the motion holds the height"});
  d.param("observer_radps", p.observer_radps,
          {.unit = "rad/s", .min = 0.1, .max = 20, .doc = "how fast the estimated height follows the motion"});
  gain("kp_height", p.kp_height, "1/s^2", "acceleration for each m off the height");
  gain("kd_height", p.kd_height, "1/s", "acceleration for each m/s of climb over the ground");
  gain("ki_height", p.ki_height, "1/s", "how fast the thrust that is needed is learned");
  d.param("integral_mps2", p.integral_mps2, {.unit = "m/s^2", .min = 0, .max = 10, .doc = "most that is learned"});
  gain("kp_speed", p.kp_speed, "rad s/m", "pitch for each m/s off the airspeed");
  gain("ki_speed", p.ki_speed, "rad/m", "pitch for its sum");
  gain("kp_drift", p.kp_drift, "rad s/m", "roll for each m/s of drift, at the wanted height");
  gain("ki_drift", p.ki_drift, "rad/m", "roll for its sum");
  seconds("airspeed_time_s", p.airspeed_time_s, "low pass of the accelerometer's drag");
  seconds("drift_time_s", p.drift_time_s, "low pass of the motion to the side");
  d.param("tilt_rad", p.tilt_rad, {.unit = "rad", .min = 0.02, .max = 0.6, .doc = "largest pitch and roll"});
  d.param("least_height_share", p.least_height_share,
          {.min = 0.01, .max = 1, .doc = "of the wanted height: lower ones are not believed"});
  d.param("most_height_share", p.most_height_share, {.min = 1, .max = 10, .doc = "likewise, higher ones"});
  d.param("most_step_share", p.most_step_share,
          {.min = 0.05, .max = 10, .doc = "of the wanted height: by more a new height does not correct the estimate"});
  d.param("most_sink_mps", p.most_sink_mps, {.unit = "m/s", .min = 0.05, .max = 5, .doc = "over the ground"});
  d.param("most_climb_mps", p.most_climb_mps, {.unit = "m/s", .min = 0.05, .max = 5, .doc = "over the ground"});
  d.param("thrust_min_n", p.thrust_min_n, {.unit = "N", .min = 0.01, .max = 500, .doc = "least thrust in flight"});
  d.param("thrust_max_n", p.thrust_max_n, {.unit = "N", .min = 0.1, .max = 2000, .doc = "most thrust"});
  seconds("motion_lost_s", p.motion_lost_s, "without motion (or range): neither climbs nor sinks");
  d.param("sink_thrust_share", p.sink_thrust_share,
          {.min = 0.5, .max = 1, .doc = "of the learned thrust, when a failsafe asks for a landing"});
  seconds("sink_s", p.sink_s, "of it before disarming");
  d.param("feet_below_base_m", p.feet_below_base_m, {.unit = "m", .min = 0, .max = 2, .doc = "while it stands"});
  d.param("camera_m", p.camera_m, {.unit = "m", .min = -2, .max = 2, .doc = "camera and range finder, below the base"});
}

hal::Status MotionAltitude::configure(rt::Setup& setup) {
  if (height_by_ != "motion" && height_by_ != "range") {
    setup.explain("height_by: motion or range");
    return hal::Error{hal::Errc::bad_argument, "control::MotionAltitude: height_by"};
  }
  by_range_ = height_by_ == "range";
  return {};
}

void MotionAltitude::reset() {
  law_.reset();
  force_mps2_ = {};
}

rt::StepStatus MotionAltitude::step(const rt::Step& step) noexcept {
  const msg::NavState* state = state_.fresh(step.now);
  if (!state) return rt::StepStatus::stale;
  if (!plausible(*state)) return rt::StepStatus::fault;
  math::Vec3 sum;
  double count = 0;
  for (const msg::ImuSample& s : imu_) {
    if (!within(s.accel_mps2, kMostForce_mps2)) continue;
    sum += math::Vec3(s.accel_mps2);
    count += 1;
  }
  if (count > 0) force_mps2_ = sum / count;
  MotionAltitudeLaw::Input in;
  in.nav = *state;
  in.force_mps2 = force_mps2_;
  if (const msg::GroundMotion* motion = motion_.get(); motion && motion_.updated() && plausible(*motion))
    in.motion = motion;
  in.by_range = by_range_;
  if (const msg::RangeSample* range = range_.get(); by_range_ && range && range_.updated() && range->range_m > 0)
    in.range_m = range->range_m;
  if (const msg::SafetyState* safety = safety_.get()) {
    in.permitted = safety->permitted != 0;
    in.action = safety->action;
  }
  law_.step(in, step.now, step_seconds(step.dt));
  attitude_.loan() = law_.setpoint();
  altitude_.loan() = law_.state();
  return rt::StepStatus::ok;
}

}  // namespace sinew::control
