#include "robots/quad/pilot_switch.hpp"

#include "control/limits.hpp"
#include "control/plausible.hpp"

namespace sinew::control {

using namespace std::chrono_literals;

namespace {
constexpr double kOn = 0.5;  // of a switch: two positions are -1 and 1, three have 0
constexpr double kGravity_mps2 = 9.80665;
}  // namespace

void PilotSwitch::declare(rt::Declaration& d) {
  d.in("rc", rc_);
  d.in("state", nav_, {.max_age = 20ms});
  d.in("mission", mission_, {.max_age = 100ms});
  d.out("switches", switches_);
  d.out("attitude", attitude_);
  d.state(state_);
  const auto number = [&](const char* name, std::int64_t& v, const char* doc) {
    d.param(name, v, {.unit = "1", .min = 1, .max = 16, .doc = doc});
  };
  number("roll_channel", roll_channel_, "right is positive");
  number("pitch_channel", pitch_channel_, "forward is positive");
  number("throttle_channel", throttle_channel_, "up is positive; the middle carries the weight");
  number("yaw_channel", yaw_channel_, "clockwise is positive");
  number("take_over_channel", take_over_channel_, "above 0.5: the sticks fly");
  number("kill_channel", kill_channel_, "above 0.5: kill");
  d.param("lost_after_s", lost_after_s_, {.unit = "s", .min = 0.02, .max = 10, .doc = "without a sample"});
  d.param("tilt_rad", tilt_rad_, {.unit = "rad", .min = 0.05, .max = 1.0, .doc = "of a stick's full way"});
  d.param("yaw_radps", yaw_radps_, {.unit = "rad/s", .min = 0.1, .max = 6, .doc = "of a stick's full way"});
  d.param("dead_band", dead_band_, {.unit = "1", .min = 0, .max = 0.3, .doc = "around the middle of yaw and throttle"});
  d.param("mass_kg", mass_kg_,
          {.unit = "kg", .min = 0.05, .max = 50, .doc = "of the vehicle: the throttle's middle carries its weight"});
  d.param("thrust_min_n", thrust_min_n_, {.unit = "N", .min = 0.01, .max = 500, .doc = "at the throttle's lower end"});
  d.param("thrust_max_n", thrust_max_n_, {.unit = "N", .min = 0.1, .max = 2000, .doc = "at the throttle's upper end"});
}

double PilotSwitch::channel(const msg::RcSample& rc, std::int64_t number) const {
  const auto i = static_cast<std::size_t>(number - 1);
  const double v = i < rc.count && i < rc.channel.size() ? rc.channel[i] : 0;
  return v >= -2 && v <= 2 ? clamp(v, -1, 1) : 0;  // not a number, too
}

void PilotSwitch::look(const msg::RcSample* rc, msg::Time now) {
  msg::PilotSwitches& s = state_.switches;
  s.stamp = now;
  s.lost = !rc || rc->lost || msg::seconds(now - rc->stamp) > lost_after_s_ ? 1 : 0;
  s.link_quality = s.lost ? 0 : rc->link_quality;
  if (!s.lost) s.kill = channel(*rc, kill_channel_) > kOn ? 1 : 0;
  s.take_over = !s.lost && channel(*rc, take_over_channel_) > kOn ? 1 : 0;
}

msg::AttitudeSetpoint PilotSwitch::by_hand(const msg::RcSample& rc, const msg::NavState& nav, double dt_s) {
  const auto calm = [this](double v) { return v > -dead_band_ && v < dead_band_ ? 0 : v; };
  state_.yaw_rad -= calm(channel(rc, yaw_channel_)) * yaw_radps_ * dt_s;
  const double throttle = calm(channel(rc, throttle_channel_)), weight_n = mass_kg_ * kGravity_mps2;
  const double to_end_n = throttle > 0 ? thrust_max_n_ - weight_n : weight_n - thrust_min_n_;
  msg::AttitudeSetpoint out;
  out.stamp = nav.stamp;
  // Forward leans the nose down, which is positive about y; right leans right, positive about x.
  const math::YawPitchRoll angles{state_.yaw_rad, channel(rc, pitch_channel_) * tilt_rad_,
                                  channel(rc, roll_channel_) * tilt_rad_};
  out.q_world_base = math::Quat::from_yaw_pitch_roll(angles).to<msg::Quat>();
  out.thrust_n = clamp(weight_n + throttle * to_end_n, thrust_min_n_, thrust_max_n_);
  out.armed = state_.armed;
  return out;
}

rt::StepStatus PilotSwitch::step(const rt::Step& step) noexcept {
  const msg::RcSample* rc = rc_.get();
  const msg::NavState* nav = nav_.fresh(step.now);
  const msg::AttitudeSetpoint* mission = mission_.fresh(step.now);
  look(rc, step.now);
  switches_.loan() = state_.switches;
  const bool flies = state_.switches.take_over && nav && plausible(*nav) && nav->attitude_valid;
  if (flies && !state_.by_hand) {
    state_.yaw_rad = math::Quat(nav->q_world_base).yaw();
    state_.armed = mission && mission->armed ? 1 : 0;
  }
  state_.by_hand = flies ? 1 : 0;
  if (flies)
    attitude_.loan() = by_hand(*rc, *nav, step_seconds(step.dt));
  else if (mission && !state_.switches.take_over)
    attitude_.loan() = *mission;
  return rt::StepStatus::ok;
}

}  // namespace sinew::control
