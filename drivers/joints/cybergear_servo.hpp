#pragma once
#include "drivers/joints/impedance_servo.hpp"
#include "wire/cybergear.hpp"

namespace sinew::drivers {

/// Empty: fine.
WrongKeys check_cybergear(const ServoConfig& config, std::uint32_t host_id);

/// A CyberGear motor in its motion mode. The number of its processor identifies it. It reports faults by name, and its
/// bus voltage when asked, a few times a second. ServoConfig::device_timeout goes into its CAN_TIMEOUT each time before
/// it is enabled (newer firmwares only; older ones have no time-out, as with 0).
/// Thread, RT: as ServoProtocol.
class CyberGearServo final : public ImpedanceServo {
 public:
  explicit CyberGearServo(const ServoConfig& config, std::uint32_t host_id = 0xFD);

  std::span<const Interest> interests() const override { return interests_; }
  BusNeed need(double tick_hz) const override;
  Heard on_frame(const msg::CanFrame& frame, Time now) noexcept override;
  void farewell(FrameSink& out) noexcept override { out.send(encode(Switch::disable)); }
  TorqueSaid torque_said(const msg::CanFrame& frame, Time now) noexcept override;

 private:
  msg::CanFrame encode(const wire::MitCommand& command) const noexcept override;
  msg::CanFrame encode(Switch what) const noexcept override;
  void ask_more(Time now, FrameSink& out) noexcept override;
  bool told_settings() const noexcept override;
  void on_off() noexcept override { timeouts_told_ = 0; }
  void on_identity(std::uint64_t serial, Time now) noexcept;

  std::uint32_t host_;
  std::array<Interest, 4> interests_;
  int timeouts_told_ = 0;  // since it was on
  Time next_question_{};
};

}  // namespace sinew::drivers
