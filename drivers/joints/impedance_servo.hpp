#pragma once
// Motors that take position, velocity, gains and torque in one frame and answer it: MIT frames, CyberGear.
#include "drivers/joints/servo_check.hpp"
#include "drivers/joints/servo_joint.hpp"
#include "wire/mit_motor.hpp"

namespace sinew::drivers {

/// What such motors have in common; the frames themselves are the derived classes'.
/// Position setpoints go out with kp and kd, velocity ones with kd alone, effort ones as torque. A position is pulled
/// towards the measured one as far as kp would ask for more than the effort limit, so derating holds here, too.
/// Discovery: motors are silent until they are spoken to; they are asked, with growing pauses, until one answers.
/// Lease:   StopAction torque_off, damp (kd alone), hold.
/// Homing:  Request::zero_here moves our offset; home: there is none.
/// Thread, RT: as ServoProtocol.
class ImpedanceServo : public ServoProtocol {
 public:
  /// `motor_nm`: the largest effort of the motor, drive side. The spring stays off its setpoint as far as this effort
  /// bends it; only a larger distance is an overload.
  ImpedanceServo(const ServoConfig& config, double motor_nm) : joint_(with_spring(config, motor_nm)) {}

  void tick(Time now, const ServoCommand& command, FrameSink& out) noexcept override;
  const ServoFeedback& feedback() const noexcept override { return joint_.feedback(); }
  const ServoIdentity& identity() const noexcept override { return identity_; }
  const ServoStats& stats() const noexcept override { return joint_.stats(); }
  const ServoConfig& config() const noexcept override { return joint_.config(); }

 protected:
  /// What a motor's reply says, drive side; NaN: not in it.
  struct Reply {
    Time stamp;
    double position_rad = 0, velocity_radps = 0, effort_nm = 0, temperature_c = kUnknown, voltage_v = kUnknown;
    std::uint32_t faults = 0, code = 0;
    bool status_known = false, enabled = false;  // whether the reply says that it is enabled
  };
  enum class Switch : std::uint8_t { enable, disable, clear_fault };
  /// True: all settings that the motor needs before it may be enabled have been sent.
  virtual bool told_settings() const noexcept { return true; }
  /// It was switched off, failed or fell silent: it may have forgotten what it was told.
  virtual void on_off() noexcept {}
  virtual msg::CanFrame encode(const wire::MitCommand& command) const noexcept = 0;
  virtual msg::CanFrame encode(Switch what) const noexcept = 0;
  /// Further questions and settings, at most two frames. Called once a tick while the motor answers.
  virtual void ask_more(Time /*now*/, FrameSink& /*out*/) noexcept {}
  /// A reply came.
  void heard(Time now, const Reply& reply) noexcept;

  ServoJoint joint_;
  ServoIdentity identity_;

 private:
  static ServoConfig with_spring(ServoConfig config, double motor_nm);
  void count_replies(Time now) noexcept;
  void take_request(Time now, const ServoCommand& command) noexcept;
  void stay_off(Time now, const ServoCommand& command, FrameSink& out) noexcept;
  void stay_on(Time now, const ServoCommand& command, FrameSink& out) noexcept;
  void go_off(Time now, FrameSink& out) noexcept;
  void ask(const msg::CanFrame& frame, FrameSink& out) noexcept;
  wire::MitCommand follow(Time now, double setpoint) noexcept;
  wire::MitCommand stop(Time now) noexcept;
  /// `target`, pulled towards `measured` until their distance is worth at most `most_nm` at this gain.
  static double pulled(double target, double measured, double gain, double most_nm) noexcept;

  BackOff probe_, clear_;
  bool on_ = false, waiting_ = false;  // it was told to be enabled; a reply is awaited
  int confirmations_ = 0;              // replies since it was told
  Time deadline_{}, next_ask_{};
  std::uint32_t asked_ = 0, replies_ = 0, request_seen_ = 0;
};

/// What check_mit() and check_cybergear() have in common. `most_kp`, `most_kd`: drive side.
WrongKeys check_impedance(const ServoConfig& config, double most_kp, double most_kd);

}  // namespace sinew::drivers
