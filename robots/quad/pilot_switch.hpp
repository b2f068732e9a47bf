#pragma once
#include "math/linear.hpp"
#include "msg/flight.hpp"
#include "msg/pilot.hpp"
#include "msg/sensors.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// Lets a pilot with a radio control stop the robot and fly it by hand. It sits between the source of the attitude
/// setpoint and the attitude controller.
/// - `switches` says every step whether the link is lost and what the switches want; [[failsafe]] conditions on it stop
///   or land (docs/safety.md). It is published even when everything else is missing.
/// - `attitude` is that of `mission` unchanged, or the pilot's after a take-over: tilt by two sticks, turning by the
///   third, thrust by the throttle, whose middle carries the weight. The pilot's motors are armed as the mission's
///   were at the take-over: the pilot cannot start from the ground by hand.
/// Frames:  sticks right, forward, clockwise and up are positive.
/// Thread:  executor, with the position controller, after it.   RT: yes.
/// Errors:  without a setpoint to hand on no `attitude` is published; without a fresh state the pilot cannot fly by
///          hand.
class PilotSwitch final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override { state_ = {}; }
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  double channel(const msg::RcSample& rc, std::int64_t number) const;
  void look(const msg::RcSample* rc, msg::Time now);
  msg::AttitudeSetpoint by_hand(const msg::RcSample& rc, const msg::NavState& nav, double dt_s);

  rt::In<msg::RcSample> rc_;
  rt::In<msg::NavState> nav_;
  rt::In<msg::AttitudeSetpoint> mission_;
  rt::Out<msg::PilotSwitches> switches_;
  rt::Out<msg::AttitudeSetpoint> attitude_;

  std::int64_t roll_channel_ = 1, pitch_channel_ = 2, throttle_channel_ = 3, yaw_channel_ = 4, take_over_channel_ = 5,
               kill_channel_ = 6;
  double lost_after_s_ = 0.3;
  double tilt_rad_ = 0.45, yaw_radps_ = 1.5, dead_band_ = 0.05;
  double mass_kg_ = 1.2, thrust_min_n_ = 1.0, thrust_max_n_ = 20.0;
  struct State {
    msg::PilotSwitches switches;
    double yaw_rad = 0;
    std::uint32_t by_hand = 0, armed = 0;
  } state_;
};

}  // namespace sinew::control
