#pragma once
// What the joints of one actuator group say about themselves.
#include "msg/actuators.hpp"

namespace sinew::msg {

enum class JointMode : std::uint32_t {
  absent = 0,    // not heard of, or not any more
  disabled = 1,  // answers; no torque
  enabling = 2,  // on its way to enabled, its protocol's steps one after the other
  enabled = 3,   // follows setpoints
  stopping = 4,  // its safe action: holds, damps or runs down
  fault = 5,     // refuses; `faults` says why
  homing = 6,
};

inline constexpr ValueName kJointModeNames[] = {{"absent", JointMode::absent},     {"disabled", JointMode::disabled},
                                                {"enabling", JointMode::enabling}, {"enabled", JointMode::enabled},
                                                {"stopping", JointMode::stopping}, {"fault", JointMode::fault},
                                                {"homing", JointMode::homing}};

/// What is wrong with a joint; bits, or-ed. The code of the drive itself is in `fault_code`.
enum JointFault : std::uint32_t {
  kJointOverCurrent = 1,
  kJointOverVoltage = 2,
  kJointUnderVoltage = 4,
  kJointOverTemperature = 8,  // of the drive or the motor, by the drive's own judgement
  kJointDerated = 16,         // warm: its effort is limited by us
  kJointEncoder = 32,
  kJointOverload = 64,    // stalled, following error
  kJointLost = 128,       // no feedback for longer than its time-out
  kJointLimit = 256,      // outside its position limits
  kJointOther = 512,      // the drive says so, and nothing more
  kJointDuplicate = 1024  // two drives answer to one number
};

inline constexpr ValueName kJointFaultNames[] = {{"over-current", kJointOverCurrent},
                                                 {"over-voltage", kJointOverVoltage},
                                                 {"under-voltage", kJointUnderVoltage},
                                                 {"over-temperature", kJointOverTemperature},
                                                 {"derated", kJointDerated},
                                                 {"encoder", kJointEncoder},
                                                 {"overload", kJointOverload},
                                                 {"lost", kJointLost},
                                                 {"limit", kJointLimit},
                                                 {"other", kJointOther},
                                                 {"duplicate", kJointDuplicate}};

/// Measured by the joints of one actuator group, in the order of its channels. Joint frame: zero and sign as the robot
/// file and its calibration say. NaN: this drive does not measure it, or nothing came yet.
struct JointState {
  Time stamp;                                 // of the oldest feedback in here
  std::array<Time, kMaxChannels> measured{};  // when each joint's feedback was received; 0: never
  std::array<double, kMaxChannels> position_rad{};
  std::array<double, kMaxChannels> velocity_radps{};
  std::array<double, kMaxChannels> effort_nm{};
  std::array<double, kMaxChannels> temperature_c{};
  std::array<double, kMaxChannels> voltage_v{};
  std::array<JointMode, kMaxChannels> mode{};
  std::array<std::uint32_t, kMaxChannels> faults{};      // JointFault bits
  std::array<std::uint32_t, kMaxChannels> fault_code{};  // the drive's own
  std::uint32_t count = 0;                               // joints in use
  std::uint32_t ready = 0;                               // bit i: joint i is enabled and without a fault
};

template <>
struct Description<JointState> {
  static constexpr std::string_view name = "JointState", doc = "What the joints of one actuator group measure.";
  static constexpr auto fields =
      describe(field<&JointState::stamp>("ns", "of the oldest feedback"),
               field<&JointState::measured>("ns", "0: never"), field<&JointState::position_rad>("rad"),
               field<&JointState::velocity_radps>("rad/s"), field<&JointState::effort_nm>("N m"),
               field<&JointState::temperature_c>("degC"), field<&JointState::voltage_v>("V"),
               enum_field<&JointState::mode>(kJointModeNames), bits_field<&JointState::faults>(kJointFaultNames),
               field<&JointState::fault_code>("1", "the drive's own"), field<&JointState::count>("1", "joints in use"),
               field<&JointState::ready>("1", "bits: enabled and without fault"));
};

}  // namespace sinew::msg
