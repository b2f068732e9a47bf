#pragma once
// The guardian's permission, and its reasons to refuse.
#include "msg/actuators.hpp"

namespace sinew::msg {

inline constexpr std::size_t kMaxFailsafes = 16;

/// What a failsafe condition asks for; the larger one wins.
enum class FailsafeAction : std::uint32_t {
  none = 0,
  land = 1,  // the mission comes down where it is
  stop = 2,  // the actuators' safe action at once, until disarmed
};

inline constexpr ValueName kFailsafeActionNames[] = {
    {"none", FailsafeAction::none}, {"land", FailsafeAction::land}, {"stop", FailsafeAction::stop}};

/// The guardian's view of the whole robot, published in each of its steps. Bit i of `conditions`, `latched` and `acted`
/// is the i-th [[failsafe]] of the robot file. Bit i of `groups_...` is the i-th actuator group, and says why the group
/// is not ready (0 while permitted). rt/safety_text.hpp turns all this into words.
struct SafetyState {
  Time stamp;
  Time disarmed;  // the last disarm() in flight; 0: never
  /// Per condition: seconds without a message or without a change, or the value; NaN before the first message.
  std::array<double, kMaxFailsafes> measured{};
  GuardianMode mode = GuardianMode::standby;  // the worst of all groups
  std::uint32_t permitted = 0;                // 1: armed commands pass
  std::uint32_t ready = 0;                    // 1: arming would be granted
  FailsafeAction action = FailsafeAction::none;
  std::uint32_t conditions = 0;  // hold now
  std::uint32_t latched = 0;     // have acted, until disarmed
  std::uint32_t acted = 0;       // have acted since the start
  std::uint32_t groups_without_command = 0;
  std::uint32_t groups_bad_command = 0;  // not finite, outside the limits, or a wrong number of channels
  std::uint32_t groups_not_idle = 0;     // commanded to move
  std::uint32_t groups_device_refused = 0;
  std::uint32_t groups_moving = 0;  // get setpoints to move: passed on, or held
  // Of the first of groups_bad_command, the first thing that is wrong with its command:
  std::uint32_t bad_fault = 0;    // GuardianFault: count, not finite or limit
  std::uint32_t bad_channel = 0;  // the channel of bad_value
  double bad_value = 0;           // the value; for a wrong count the command's number of channels
};

template <>
struct Description<SafetyState> {
  static constexpr std::string_view name = "SafetyState", doc = "What the guardian permits, and why not.";
  static constexpr auto fields = describe(
      field<&SafetyState::stamp>("ns"), field<&SafetyState::disarmed>("ns", "last disarmed in flight; 0: never"),
      field<&SafetyState::measured>("", "per condition: s, or the field's unit"),
      enum_field<&SafetyState::mode>(kGuardianModeNames, "the worst of all groups"),
      field<&SafetyState::permitted>("1", "1: armed commands pass"),
      field<&SafetyState::ready>("1", "1: arming would be granted"),
      enum_field<&SafetyState::action>(kFailsafeActionNames), field<&SafetyState::conditions>("1", "bits: hold now"),
      field<&SafetyState::latched>("1", "bits: have acted, until disarmed"),
      field<&SafetyState::acted>("1", "bits: have acted since the start"),
      field<&SafetyState::groups_without_command>("1", "bits: no fresh command"),
      field<&SafetyState::groups_bad_command>("1", "bits: not finite, outside limits, or wrong count"),
      field<&SafetyState::groups_not_idle>("1", "bits: commanded to move"),
      field<&SafetyState::groups_device_refused>("1", "bits"),
      field<&SafetyState::groups_moving>("1", "bits: get setpoints to move, passed on or held"),
      enum_field<&SafetyState::bad_fault>(kGuardianFaultNames, "of the first bad command"),
      field<&SafetyState::bad_channel>("1", "whose value it is"),
      field<&SafetyState::bad_value>("", "that value; of a wrong count the number of channels"));
};

}  // namespace sinew::msg
