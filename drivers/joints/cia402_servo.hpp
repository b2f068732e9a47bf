#pragma once
// A drive of the CiA 402 profile on CANopen.
#include <vector>

#include "drivers/joints/sdo_client.hpp"
#include "drivers/joints/servo_check.hpp"
#include "drivers/joints/servo_joint.hpp"
#include "wire/cia402.hpp"

namespace sinew::drivers {

/// The services that all CANopen drives of a bus share: SYNC at the end of each tick, and the master's heartbeat.
/// Drives stop when they miss the heartbeat (ServoConfig::device_timeout), so also when this program dies.
class CanopenMaster final : public BusService {
 public:
  struct Options {
    std::uint32_t node_id = 126;
    Duration heartbeat{std::chrono::milliseconds(10)};
  };
  CanopenMaster() = default;
  explicit CanopenMaster(const Options& options) : options_(options) {}
  std::span<const Interest> interests() const override { return {}; }
  BusNeed need(double tick_hz) const override;
  Heard on_frame(const msg::CanFrame&, Time) noexcept override { return Heard::foreign; }
  void end(Time now, FrameSink& out) noexcept override;
  std::uint32_t node_id() const { return options_.node_id; }

 private:
  Options options_;
  Time next_heartbeat_{};
};

/// What a CANopen drive needs beside ServoConfig.
struct Cia402Options {
  double tick_hz = 500;                      // of its hub: SYNC, and the interpolation time (60C2h)
  std::uint32_t master_node = 126;           // whose heartbeat the drive consumes
  std::uint32_t slow_every = 5;              // velocity and voltage come with every n-th SYNC, 1..240
  double velocity_unit_radps = 0;            // of 60FFh and 606Ch, drive side; 0: counts per second
  wire::ObjectAddress temperature_object{};  // no profile has one: the maker's, read once a second; index 0: none
  double temperature_unit_c = 1;
};
/// 6098h: those of the profile, and a maker's own. Source: CiA 402-2, "Homing": 15, 16, 31, 32 and 36 are reserved.
bool is_homing_method(int method) noexcept;
inline constexpr std::string_view kHomingMethods =
    "0 (none), 1 to 14, 17 to 30, 33 to 35, 37, or -128 to -1 (the maker's own)";
/// Empty: fine.
WrongKeys check_cia402(const ServoConfig& config, const Cia402Options& options);

/// Brings a drive up by SDO (identity, PDO mapping, heartbeats, mode), starts it, and then talks in PDOs: RPDO1 takes
/// controlword, target and torque limit (if there is one) with each SYNC, TPDO1 brings statusword, position and torque,
/// TPDO2 velocity and, where the drive has it, DC link voltage. Setpoints are cyclic synchronous position, velocity or
/// torque.
/// Lease:   StopAction torque_off, quick_stop, hold; the drive itself watches the master's heartbeat (1016h) when
///          ServoConfig::device_timeout is set, and then stops by 6007h.
/// Homing:  with ServoConfig::homing_method the drive homes by itself (mode 6) when it is enabled for the first time
///          after it was brought up, and follows no setpoint before. A drive that was homed and fell silent only homes
///          again if it lost its power: each bring-up sets its heartbeat time (1017h) to another number, which a drive
///          forgets with its power; if that number is gone, or a boot-up message came, it homes. A drive that says in
///          mode 6 that it is homed already does not move. Without a lease homing ends, and the torque with it.
///          Request::home homes again; zero_here moves our own offset.
/// Thread, RT: as ServoProtocol.
class Cia402Servo final : public ServoProtocol {
 public:
  Cia402Servo(const ServoConfig& config, const Cia402Options& options);

  std::span<const Interest> interests() const override { return interests_; }
  BusNeed need(double tick_hz) const override;
  Heard on_frame(const msg::CanFrame& frame, Time now) noexcept override;
  void tick(Time now, const ServoCommand& command, FrameSink& out) noexcept override;
  const ServoFeedback& feedback() const noexcept override { return joint_.feedback(); }
  const ServoIdentity& identity() const noexcept override { return identity_; }
  const ServoStats& stats() const noexcept override { return joint_.stats(); }
  const ServoConfig& config() const noexcept override { return joint_.config(); }
  void farewell(FrameSink& out) noexcept override;
  void ask_torque(FrameSink& out) noexcept override;
  TorqueSaid torque_said(const msg::CanFrame& frame, Time now) noexcept override;
  /// NMT stop: the drive then does what 6007h says, which bringing it up has set (CiA 402-2, 6007h).
  void insist(FrameSink& out) noexcept override;

 private:
  enum class Phase : std::uint8_t { absent, configuring, starting, running };
  /// arriving: mode 6 is set, and its first statusword is on its way.
  enum class Homing : std::uint8_t { no, set_method, set_mode, check_mode, arriving, moving, set_back, check_back };
  /// One step of bringing it up; a drive may refuse what is optional.
  struct Step {
    wire::Sdo request;
    bool optional = false;
    std::uint32_t* into = nullptr;  // of a read
    std::uint8_t entry = 0;         // of a PDO, its last one and optional: the next step writes how many there are
  };

  static constexpr std::uint32_t kHeartbeatMs = 100, kMarks = 50;  // 100 to 149 ms

  void plan();
  void read(wire::ObjectAddress object, std::uint32_t* into, bool optional = true);
  void write(wire::ObjectAddress object, std::uint32_t value, std::uint8_t bytes, bool optional = false);
  void plan_pdo(bool transmit, std::uint32_t number, std::uint32_t type, std::span<const std::uint32_t> entries,
                bool last_is_optional = false);

  Heard on_tpdo1(const msg::CanFrame& frame, Time now) noexcept;
  Heard on_tpdo2(const msg::CanFrame& frame) noexcept;
  Heard on_heartbeat(const msg::CanFrame& frame, Time now) noexcept;
  Heard on_emergency(const msg::CanFrame& frame) noexcept;

  void bring_up(Time now, FrameSink& out) noexcept;
  void next_step(Time now, FrameSink& out) noexcept;
  void finish_step() noexcept;
  void note_entry(bool mapped) noexcept;
  void give_up() noexcept;
  void run(Time now, const ServoCommand& command, FrameSink& out) noexcept;
  void count_cycle(Time now) noexcept;
  void decide(Time now, const ServoCommand& command) noexcept;
  void note_state(Time now, bool holding) noexcept;
  std::uint16_t controlword(Time now) noexcept;
  void home(Time now, const ServoCommand& command) noexcept;
  void begin_homing(Time now, const ServoCommand& command) noexcept;
  void next_homing_step(Time now) noexcept;
  void watch_homing(Time now) noexcept;
  void check_mode(Homing step) noexcept;
  bool homed() const noexcept { return homed_ || config().homing_method == 0; }
  void end_homing() noexcept;
  void set_mode(wire::DriveMode mode, Homing step) noexcept;
  static wire::DriveMode mode_of(ServoMode mode);
  void poll_temperature(Time now, FrameSink& out) noexcept;
  void send_rpdo(FrameSink& out) noexcept;
  void aim(Time now, const ServoCommand& command) noexcept;
  void drop() noexcept;
  double rated_nm() const noexcept;
  bool limits_effort() const noexcept;  // else the drive's own 6072h stays as it is
  double velocity_unit() const noexcept;

  Cia402Options options_;
  ServoJoint joint_;
  ServoIdentity identity_;
  SdoClient sdo_;
  std::vector<Interest> interests_;
  std::vector<Step> steps_;
  std::size_t step_ = 0;
  Phase phase_ = Phase::absent;
  BackOff retry_, fault_reset_;
  std::uint32_t rated_mnm_ = 0, serial_ = 0;
  Time deadline_{};  // of this phase; of becoming enabled

  wire::DriveState state_ = wire::DriveState::not_ready;
  std::uint16_t status_ = 0, control_ = 0, error_code_ = 0;
  bool wants_ = false, was_enabled_ = false, quick_ = false;
  std::int32_t target_ = 0;
  std::uint16_t torque_limit_ = 0;
  std::uint32_t tpdos_ = 0, ticks_ = 0;  // in a window; many more frames than ticks are two drives
  bool heard_ = false;                   // since the last tick
  bool tells_voltage_ = true;            // in TPDO2
  Homing homing_ = Homing::no;
  bool homed_ = false, home_anew_ = false, homing_began_ = false;
  bool homed_before_ = false;  // it fell silent
  // 1017h: what we wrote when it was last brought up (0: never), and what it was when it came back.
  std::uint32_t mark_ = 0, mark_read_ = 0;
  std::size_t mark_step_ = 0;
  Time homing_deadline_{};
  std::uint32_t homing_number_ = 0;  // of the feedback at the start of its step
  std::uint32_t request_seen_ = 0;
  Time next_temperature_{}, last_heartbeat_{};
  bool reading_temperature_ = false;
};

}  // namespace sinew::drivers
