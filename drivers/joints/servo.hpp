#pragma once
// One servo as its hub sees it: configuration, command, feedback, and on a CAN bus the protocol that lies between them
// and the frames. Protocols know no clock, thread or bus: time and frames are handed to them, so each is tested alone.
#include <chrono>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "hal/can_bus.hpp"
#include "msg/can.hpp"
#include "msg/joints.hpp"

namespace sinew::drivers {

using hal::Duration;
using hal::Time;

/// What a setpoint of the joint means; its unit is rad, rad/s or N m.
enum class ServoMode : std::uint8_t { position, velocity, effort };
/// What a joint does when its lease has run out: no torque; no motion, softly; stays where it is; the drive's own ramp.
/// A protocol refuses at configure an action that it does not have.
enum class StopAction : std::uint8_t { torque_off, damp, hold, quick_stop };

/// Bounds of setpoints, joint frame. Setpoints beyond are pulled in; feedback beyond raises msg::kJointLimit.
struct ServoLimits {
  double position_min_rad = -1e9, position_max_rad = 1e9;
  double velocity_radps = 1e3;  // of a velocity setpoint, and of the change of a position setpoint
  double effort_nm = std::numeric_limits<double>::infinity();  // not finite: what the drive itself allows
};

/// The effort limit falls from `start_c` on, and is 0 at `end_c` and above; it has to be given then. start >= end:
/// never.
struct Derating {
  double start_c = 0, end_c = 0;
};

/// How far a joint may stay behind its setpoint: further than this for longer than `time` is an overload (stuck,
/// stalled, a drive that repeats itself), and it is switched off. 0: not watched. A joint that derating has weakened
/// may stay behind.
struct FollowingError {
  static constexpr double kUsual = -1;  // kUsual_rad; springs (MIT, CyberGear) add what their most effort bends
  static constexpr double kUsual_rad = 0.5;
  double position_rad = kUsual, velocity_radps = 0;
  Duration time{std::chrono::milliseconds(500)};
};

/// One servo: what the robot file says about it, without a word about its bus. Plain data, read once.
/// Frames:  joint_rad = sign * drive_rad / gear_ratio - zero_rad: so zero_rad is what the joint read, before
///          calibration, where it should read zero. Efforts: joint_nm = sign * drive_nm * gear_ratio.
struct ServoConfig {
  std::string name;           // of the joint, for texts
  std::uint32_t node_id = 1;  // CANopen 1..127; MIT and CyberGear: the motor's id; DroneCAN 1..127
  ServoMode mode = ServoMode::position;
  StopAction stop = StopAction::torque_off;
  double zero_rad = 0;
  double sign = 1;             // or -1
  double gear_ratio = 1;       // turns of what the drive measures per turn of the joint
  double counts_per_turn = 0;  // of the drive's position unit (CiA 402: increments); 0: the protocol's own unit
  double rated_effort_nm = 0;  // CiA 402: what 1000 per mille of 6071h/6077h are, drive side; 0: read 6076h
  double kp = 0, kd = 0;       // MIT and CyberGear, joint side: N m/rad, N m s/rad
  double damp_kd = 0;          // the same, of StopAction::damp; 0: kd
  ServoLimits limits;
  Derating derating;
  FollowingError following;
  Duration feedback_timeout{std::chrono::milliseconds(50)};  // no feedback for this long: lost
  Duration device_timeout{0};  // the drive is told to stop when it hears nothing for this long; 0: as it is set
  double plausible_velocity_radps = 0;  // feedback that moves faster is disbelieved; 0: four times the velocity limit
  int homing_method = 0;                // CiA 402 6098h; 0: the drive knows where it is
  bool needs_disarm = false;            // after a fault: it has to be disarmed (armed = 0) before it is enabled again
  std::uint32_t actuator_id = 0;        // DroneCAN: actuator_id, or index in esc.RawCommand
};

/// What the hub wants of a joint in this tick.
struct ServoCommand {
  enum class Intent : std::uint8_t {
    off,     // no torque: nobody wants it live
    stop,    // its lease has run out: ServoConfig::stop
    follow,  // setpoint holds
  };
  Intent intent = Intent::off;
  bool disarmed = false;     // off on purpose, not because commands are missing
  double setpoint = 0;       // joint frame, in the unit of the mode; finite
  std::uint32_t number = 0;  // counts the commands written; only one that the joint has not seen yet enables it again
  enum class Request : std::uint8_t { none, home, zero_here };
  Request request = Request::none;  // to be done once, when request_number is another than before
  std::uint32_t request_number = 0;
};

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// What a joint says about itself; as msg::JointState, joint frame. NaN: not measured, or nothing came yet.
struct ServoFeedback {
  Time measured;             // of the last position; 0: never
  std::uint32_t number = 0;  // counts positions received
  double position_rad = kUnknown, velocity_radps = kUnknown, effort_nm = kUnknown;
  double temperature_c = kUnknown, voltage_v = kUnknown;
  msg::JointMode mode = msg::JointMode::absent;
  std::uint32_t faults = 0;      // msg::JointFault bits, now
  std::uint32_t fault_code = 0;  // the drive's own, of the last fault
  Duration beyond{};             // for how long it follows a setpoint that is beyond its limits, and is pulled in
  Duration refusing{};           // for how long it answers, is told to follow, and was not ready for a second on end
};

/// The identity that the servo reports; zero and empty where the protocol does not tell.
struct ServoIdentity {
  bool known = false;
  std::uint32_t vendor = 0, product = 0, revision = 0;
  std::uint64_t serial = 0;
  char name[40] = "";  // ends with 0
};

/// Counted since the start.
struct ServoStats {
  std::uint64_t feedback = 0;     // frames that became feedback
  std::uint64_t malformed = 0;    // frames to us that the protocol does not allow
  std::uint64_t implausible = 0;  // well formed, and disbelieved
  std::uint64_t missed = 0;       // replies or cycles without one, tolerated
  std::uint64_t losses = 0;       // feedback time-outs
  std::uint64_t faults = 0;       // entries into a fault
  std::uint64_t enables = 0;      // times that it became enabled
  std::uint64_t restarts = 0;     // attempts to bring it up, with back-off
};

/// Takes the frames of one tick. A frame that the bus has no room for is lost and counted by the hub.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /// RT: yes, never blocks.
  virtual void send(const msg::CanFrame& frame) noexcept = 0;
};

/// Identifiers somebody listens to: those that agree with `id` in all bits of `mask`.
using Interest = hal::CanFilter;

/// What a listener made of a frame; the hub counts.
enum class Heard : std::uint8_t { mine, foreign, malformed };

/// The part of a bus that a listener needs per second: frames in both directions, worst-case stuffing.
struct BusNeed {
  double frames_per_s = 0, bits_per_s = 0;
  /// `frame` (its size and kind count) `hz` times a second.
  void add(const msg::CanFrame& frame, double hz) {
    frames_per_s += hz;
    bits_per_s += hz * hal::can_frame_bits(frame);
  }
};

/// A receiver of frames of a bus: a servo, or something that several servos share.
/// Thread:  the hub's.   RT: on_frame() yes, interests() and need() configure only.
class CanListener {
 public:
  virtual ~CanListener() = default;
  /// Asked once. Standard identifiers need full masks (0x7FF); extended ones at most a few different masks a bus.
  virtual std::span<const Interest> interests() const = 0;
  virtual BusNeed need(double tick_hz) const = 0;
  /// A frame that one of the interests names; never an error frame. Several listeners may get the same frame.
  virtual Heard on_frame(const msg::CanFrame& frame, Time now) noexcept = 0;
};

/// What servos of one protocol have in common on their bus: SYNC, the master's own heartbeat, one frame that carries
/// the setpoints of many (DroneCAN), allocation of node ids. The hub ticks: begin() of all, tick() of all servos, end()
/// of all. A servo that shares a frame is made with a reference to its service, and leaves its part there in tick().
class BusService : public CanListener {
 public:
  virtual void begin(Time /*now*/, FrameSink& /*out*/) noexcept {}
  virtual void end(Time /*now*/, FrameSink& /*out*/) noexcept {}
};

/// What a frame says about the torque of a drive.
enum class TorqueSaid : std::uint8_t { nothing, off, on };

/// A servo as its group sees it, whatever bus it is on. Thread: the hub's. RT: yes.
class JointServo {
 public:
  virtual ~JointServo() = default;
  /// Valid between calls of its hub.
  virtual const ServoFeedback& feedback() const noexcept = 0;
  virtual const ServoIdentity& identity() const noexcept = 0;
  virtual const ServoStats& stats() const noexcept = 0;
  virtual const ServoConfig& config() const noexcept = 0;
};

/// The protocol of one servo on a CAN bus: brings it up, feeds it setpoints, watches it, and brings it up again.
/// It is never given up: absent or broken servos are tried again with growing pauses. It is enabled by a command
/// (Intent::follow) that is newer than its last fault or loss, and never by itself.
/// Thread:  the hub's.   RT: on_frame(), tick() and the look-ups: yes. No clock: `now` never goes backwards.
class ServoProtocol : public CanListener, public JointServo {
 public:
  /// One cycle: sends everything that is due, at most kMaxFramesPerTick frames.
  virtual void tick(Time now, const ServoCommand& command, FrameSink& out) noexcept = 0;
  /// The shared command in which actuator_id is its place: no other servo on the bus may have the same place. Empty:
  /// its frames are its own.
  virtual std::string_view shares() const noexcept { return {}; }
  /// Sent when the hub ends: leaves the drive without torque, whatever state it is in.
  virtual void farewell(FrameSink& out) noexcept = 0;

  // For CanStopLine, which stops the drive from outside of its hub with an object that never ticked.
  // RT: yes; each sends at most kMaxFramesPerTick frames.

  /// Makes the drive say whether it has torque, after a farewell(). Default: farewell(), for drives that answer it.
  virtual void ask_torque(FrameSink& out) noexcept { farewell(out); }
  /// What a frame says that one of the interests names.
  virtual TorqueSaid torque_said(const msg::CanFrame& frame, Time now) noexcept = 0;
  /// Another way, for a drive that farewell() did not move; it may have to be brought up anew afterwards. Default:
  /// none.
  virtual void insist(FrameSink& /*out*/) noexcept {}

  static constexpr int kMaxFramesPerTick = 4;
};

}  // namespace sinew::drivers
