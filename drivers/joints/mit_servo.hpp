#pragma once
#include "drivers/joints/impedance_servo.hpp"

namespace sinew::drivers {

struct MitOptions {
  wire::MitMotorType type;
  std::uint32_t master_id = 0;  // identifier of its replies; several motors may share it
};
/// Empty: fine.
WrongKeys check_mit(const ServoConfig& config, const MitOptions& options);

/// A motor that speaks MIT frames. Its own time-out is set in the motor; no frame sets it. A type that does not say
/// whether it is enabled counts as enabled when it has answered; ServoConfig::following finds one that ignores
/// `enable`.
/// Thread, RT: as ServoProtocol.
class MitServo final : public ImpedanceServo {
 public:
  MitServo(const ServoConfig& config, const MitOptions& options)
      : ImpedanceServo(config, options.type.effort_nm), options_(options), interest_{options.master_id, 0x7FF, false} {}

  std::span<const Interest> interests() const override { return {&interest_, 1}; }
  BusNeed need(double tick_hz) const override;
  Heard on_frame(const msg::CanFrame& frame, Time now) noexcept override;
  void farewell(FrameSink& out) noexcept override { out.send(encode(Switch::disable)); }
  /// Types that do not say whether they are enabled: an answer to farewell() counts as "off".
  TorqueSaid torque_said(const msg::CanFrame& frame, Time now) noexcept override;

 private:
  msg::CanFrame encode(const wire::MitCommand& command) const noexcept override;
  msg::CanFrame encode(Switch what) const noexcept override;

  MitOptions options_;
  Interest interest_;
};

}  // namespace sinew::drivers
