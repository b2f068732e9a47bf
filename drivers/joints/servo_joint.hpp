#pragma once
// What all servo protocols have in common between their frames and the joint.
#include "drivers/joints/servo.hpp"

namespace sinew::drivers {

/// Pauses between attempts: 100 ms, then twice as long each time, at most 2 s. RT: yes.
class BackOff {
 public:
  bool due(Time now) const { return now >= next_; }
  void attempt(Time now) {
    next_ = now + pause_;
    pause_ = pause_ * 2 > kMost ? kMost : pause_ * 2;
  }
  void reset() {
    pause_ = kFirst;
    next_ = {};
  }

 private:
  static constexpr Duration kFirst = std::chrono::milliseconds(100), kMost = std::chrono::seconds(2);
  Duration pause_ = kFirst;
  Time next_{};
};

/// The joint behind a protocol: its frame and its units, limits, derating, plausibility, time-outs, faults, and whether
/// it may be enabled. A protocol reports what its drive says and asks what to send.
/// Frames:  "drive" is what the drive measures (rad, rad/s, N m on its side of the gear); feedback() is the joint.
/// Thread:  owner.   RT: yes after construction.
class ServoJoint {
 public:
  explicit ServoJoint(const ServoConfig& config);

  // ---- what the drive said ----

  /// A position with whatever came with it (NaN: not in this frame). False: disbelieved, as a joint cannot move like
  /// that; counted, and nothing else changed. After a loss any first position is believed.
  bool measured(Time now, Time stamp, double drive_rad, double drive_radps, double drive_nm) noexcept;
  void set_velocity(double drive_radps) noexcept;
  void set_temperature(double c) noexcept { feedback_.temperature_c = c; }
  void set_voltage(double v) noexcept { feedback_.voltage_v = v; }
  /// What the drive says is wrong now: msg::JointFault bits and its own code; 0, 0: nothing.
  void set_drive_faults(Time now, std::uint32_t faults, std::uint32_t code) noexcept;
  void malformed() noexcept { ++stats_.malformed, doubted_ = true; }
  void missed() noexcept { ++stats_.missed; }
  /// A sign that two drives answer to this number; two signs within a second make it a fault until none came for two
  /// seconds.
  void looks_double(Time now) noexcept;
  /// Nothing is known any more, nor expected: any next position is believed, whenever it comes.
  void forget_position() noexcept { believed_ = false; }
  /// Any next position is believed, but one has to come in time: the drive changes its zero.
  void expect_new_zero() noexcept { new_zero_ = true; }
  /// From now on the joint reads 0 here. False: no position is known.
  bool zero_here() noexcept;

  // ---- once a tick ----

  /// Watches time-outs. True: the joint was lost just now (it is absent then, with kJointLost).
  bool watch(Time now) noexcept;
  /// Whether this command may enable the joint (again): it is alive, without faults, the pause after a fault is over,
  /// and the command is newer than that.
  bool may_enable(Time now, const ServoCommand& command) noexcept;
  /// The joint is about to be enabled: setpoints start from where it is, own faults are forgotten.
  void begin(Time now) noexcept;
  /// Setpoints start again from where it is. Called in every tick in which the joint is on and follows nothing: the
  /// first setpoint after that moves it no further than one tick allows.
  void resume(Time now) noexcept;
  /// The setpoint to send, within all limits, joint frame; effort_limit_nm holds the derating. Watches following.
  struct Target {
    double value = 0, effort_limit_nm = 0;
  };
  Target target(Time now, double setpoint) noexcept;
  /// The last target again, for StopAction::hold; what follows starts from it.
  Target held(Time now) noexcept;
  /// We judge that it failed: off, in a fault, and not enabled again for a growing pause.
  void trip(Time now, std::uint32_t faults) noexcept;
  /// It went off by itself or was switched off: only a newer command enables it again.
  void went_off() noexcept { stale_number_ = true, feedback_.beyond = {}; }
  void set_mode(msg::JointMode mode) noexcept { feedback_.mode = mode; }
  /// The mode of a joint that answers without torque: fault as long as a fault holds it back, else disabled.
  msg::JointMode idle_mode(Time now) const noexcept;
  /// Enabled for a second: pauses begin at their shortest again.
  bool runs_well(Time now) const noexcept;
  bool drive_faulty() const noexcept { return drive_faults_ != 0; }
  bool tripped() const noexcept { return own_faults_ != 0; }
  bool enabled() const noexcept { return feedback_.mode == msg::JointMode::enabled; }

  // ---- frames of reference ----

  double to_drive_position(double joint_rad) const noexcept {
    return config_.sign * config_.gear_ratio * (joint_rad + config_.zero_rad);
  }
  double to_drive_velocity(double joint_radps) const noexcept {
    return config_.sign * config_.gear_ratio * joint_radps;
  }
  double to_drive_effort(double joint_nm) const noexcept { return config_.sign * joint_nm / config_.gear_ratio; }
  /// Of a stiffness or damping, N m/rad or N m s/rad.
  double to_drive_gain(double gain) const noexcept { return gain / (config_.gear_ratio * config_.gear_ratio); }

  double effort_limit() const noexcept;
  /// The share of the effort that derating leaves: 1 all, 0 nothing. See Derating.
  double strength() const noexcept;
  const ServoConfig& config() const noexcept { return config_; }
  const ServoFeedback& feedback() const noexcept { return feedback_; }
  ServoStats& stats() noexcept { return stats_; }
  const ServoStats& stats() const noexcept { return stats_; }

 private:
  void collect_faults() noexcept;
  bool plausible(Time now, double joint_rad, double joint_radps) const noexcept;
  bool falls_behind(double value) const noexcept;
  bool asks_too_much(double setpoint) const noexcept;

  ServoConfig config_;
  ServoFeedback feedback_;
  ServoStats stats_;
  std::uint32_t drive_faults_ = 0, own_faults_ = 0;
  bool believed_ = false, new_zero_ = false, lost_ = false, doubted_ = false;
  Time arrived_{}, behind_since_{}, enabled_at_{}, target_at_{}, asked_well_{}, double_at_{}, double_first_{};
  std::uint32_t doubles_ = 0;
  bool behind_ = false, double_ = false;
  double last_value_ = 0;
  BackOff back_off_;
  bool stale_number_ = true, disarmed_ = true;  // the command counts as old until its number changes
  std::uint32_t seen_number_ = 0;
};

}  // namespace sinew::drivers
