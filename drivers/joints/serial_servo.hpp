#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "drivers/joints/servo_check.hpp"
#include "drivers/joints/servo_joint.hpp"
#include "wire/servos/servo_models.hpp"

namespace sinew::drivers {

struct SerialServoOptions {
  const wire::ServoModel* model = nullptr;
};
/// Empty: fine.
WrongKeys check_serial_servo(const ServoConfig& config, const SerialServoOptions& options);

/// A question to one servo, which answers it.
struct LineQuestion {
  enum class Kind : std::uint8_t { read, write, reboot } kind = Kind::read;
  wire::ServoRegister reg;
  std::int32_t value = 0;  // of a write

  std::size_t answer_size() const { return kind == Kind::read ? reg.size : 0; }
};

/// A Dynamixel or Feetech servo on a half-duplex serial line. SerialHub asks and writes for it.
/// Found:   its Model Number is read, with growing pauses, until it answers; another model than the robot file's is a
///          fault with that number as code.
/// Set up:  without torque; return delay 0, an answer to each instruction, operating mode; EEPROM is written only where
///          it differs.
/// Enabled: its goal is first written to where it is now, then it gets torque; so no goal of before moves it, also
/// after
///          it rebooted by itself. A bus watchdog (X series) is set to ServoConfig::device_timeout, in steps of 20 ms.
/// Watched: voltage and temperature, torque and hardware error in turn, one register in each cycle of the hub.
/// Faults:  of 2.0 by reboot, as the maker wants, with growing pauses; the others when the servo no longer says so.
/// Lease:   StopAction torque_off, hold.
/// Homing:  Request::zero_here moves our offset; home: there is none.
/// Thread:  the hub's.   RT: yes after construction.
class SerialServo final : public JointServo {
 public:
  SerialServo(const ServoConfig& config, const SerialServoOptions& options);

  const ServoFeedback& feedback() const noexcept override { return joint_.feedback(); }
  const ServoIdentity& identity() const noexcept override { return identity_; }
  const ServoStats& stats() const noexcept override { return joint_.stats(); }
  const ServoConfig& config() const noexcept override { return joint_.config(); }
  const wire::ServoModel& model() const noexcept { return model_; }
  std::uint8_t id() const noexcept { return static_cast<std::uint8_t>(config().node_id); }
  const wire::ServoRegister& goal_register() const noexcept { return goal_; }
  /// Of an answer to the question that each cycle has time for.
  std::size_t most_slow_bytes() const noexcept { return std::max(power_.size, health_.size); }

  // ---- once a tick ----

  void tick(Time now, const ServoCommand& command) noexcept;
  /// What goes into goal_register() in this tick; false: nothing.
  bool goal(std::int32_t& out) const noexcept;
  /// It is to lose its torque in this tick.
  bool loses_torque() const noexcept { return state_ == State::stopping; }
  /// It answers to what all are asked for in each cycle.
  bool in_cycle() const noexcept { return has_settings() && misses_ < kMissesApart; }
  /// Its answer: the bytes of model().cycle().
  void on_cycle(Time now, std::uint8_t error, std::span<const std::uint8_t> data) noexcept;
  /// It was asked with the others, and did not answer. After a few it is asked alone: behind a servo that is silent
  /// nobody answers.
  void on_missed() noexcept;
  /// It answered what it was not asked.
  void on_double(Time now) noexcept { joint_.looks_double(now); }
  /// An answer that says that the question was not taken; it has no data.
  bool refused(std::uint8_t error) const noexcept;

  // ---- one question at a time ----

  /// Whether something has to be asked or written soon.
  bool is_urgent(Time now) const noexcept;
  /// The next question. False: none now.
  bool ask(Time now, LineQuestion& out) noexcept;
  void on_answer(Time now, std::uint8_t error, std::span<const std::uint8_t> data) noexcept;
  void on_silence(Time now) noexcept;

 private:
  enum class State : std::uint8_t { away, setting, off, enabling, on, stopping };
  struct Setting {
    enum class Kind : std::uint8_t { model, write, keep, look } kind = Kind::write;
    wire::ServoRegister reg;
    std::int32_t value = 0;
  };
  static constexpr int kMissesApart = 2, kTries = 3;

  void add_setting(Setting::Kind kind, const wire::ServoRegister& reg, std::int32_t value = 0);
  bool has_settings() const noexcept { return state_ >= State::off; }
  void go_off(Time now) noexcept;
  void follow(Time now) noexcept;
  void start_enabling(Time now) noexcept;
  bool next_enabling(LineQuestion& out) const noexcept;
  const wire::ServoRegister& next_slow_register() noexcept;
  bool has_watchdog() const noexcept { return model_.bus_watchdog && config().device_timeout > Duration{0}; }
  void watched(Time now, const LineQuestion& asked, std::span<const std::uint8_t> data) noexcept;
  void note_error(Time now, std::uint8_t error) noexcept;
  void set_answered(Time now, const LineQuestion& asked, std::span<const std::uint8_t> data) noexcept;
  void rebooted(Time now) noexcept;
  std::int32_t position_count(double joint_rad) const noexcept;
  std::int32_t goal_count(double value) const noexcept;

  const wire::ServoModel& model_;
  ServoJoint joint_;
  ServoIdentity identity_;
  wire::ServoRegister goal_, cycle_;
  wire::ServoRegister power_, health_;  // voltage and temperature; torque, and hardware error where it is near
  std::vector<Setting> settings_;
  State state_ = State::away;
  std::size_t setting_ = 0;  // at
  bool setting_differs_ = false;
  int enabling_ = 0;  // step
  int tries_ = 0, misses_ = 0;
  std::uint32_t turn_ = 0;  // of the slow registers
  bool alert_ = false;
  ServoCommand command_;
  std::int32_t goal_value_ = 0;
  bool has_goal_ = false;
  LineQuestion asked_;
  BackOff probe_, clear_;
  Time deadline_{};
  std::uint32_t request_seen_ = 0;
};

}  // namespace sinew::drivers
