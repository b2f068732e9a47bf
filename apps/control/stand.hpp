#pragma once
#include <array>
#include <atomic>

#include "hal/board.hpp"
#include "hal/wide.hpp"
#include "math/linear.hpp"

namespace sinew::app {

/// A quadrotor on a stand: a ball joint holds its centre of mass, so it can only turn. It has the body and the rotors
/// of robots/quad/quad.toml. It is a board with the two devices that attitude control needs, "imu" and "motors"; your
/// own board can replace it.
///
/// Each read of the IMU moves the body by the time since the last read, 20 ms at most: after a pause of the computer
/// the body is almost where it was.
/// Frames:  base x forward, y left, z up. Order of the rotors: control::allocate().
/// Thread:  read(), tilt_rad(): one; write(), stop(): one; the rest: any.   RT: yes.
class Stand final : public hal::EmptyBoard, public hal::Imu, public hal::Actuators {
 public:
  /// Leans by `tilt_rad` over its left front, and stands still.
  Stand(const hal::Clock& clock, double tilt_rad);

  hal::Result<hal::Device*> open_sensor(hal::SensorKind kind, std::string_view name) override;
  hal::Result<hal::Actuators*> actuators(std::string_view name) override;

  hal::Result<bool> read(msg::ImuSample& out) noexcept override;  // one sample a millisecond at most
  hal::Time ready_at() const noexcept override { return last_ + kSample; }
  void set_wake(hal::Wake*) noexcept override {}  // no thread sleeps for it: the reading thread has a period
  hal::Status write(const msg::ActuatorCommand& command, hal::Duration lease) noexcept override;
  hal::Status stop() noexcept override;

  /// Between base z and the vertical.
  double tilt_rad() const;
  std::uint32_t commands() const { return commands_.load(std::memory_order_relaxed); }
  /// Time of the first command; kNever before.
  hal::Time first_command() const { return {first_command_ns_.load()}; }

 private:
  static constexpr hal::Duration kSample = std::chrono::milliseconds(1);
  static constexpr std::size_t kRotors = 4;
  void move(double dt_s, const std::array<double, kRotors>& command) noexcept;

  const hal::Clock& clock_;
  hal::Time last_{};
  math::Quat q_world_base_;
  math::Vec3 rate_radps_;
  std::array<double, kRotors> thrust_n_{};
  // From the thread that commands to the thread that reads. Each number is read whole; the four may be of two commands.
  std::array<std::atomic<float>, kRotors> command_{};
  hal::Wide<std::int64_t> valid_until_ns_{0}, first_command_ns_{hal::kNever.ns};
  std::atomic<std::uint32_t> commands_{0};
};

}  // namespace sinew::app
