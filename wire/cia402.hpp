#pragma once
// Drives of the CiA 402 profile: state machine, modes, objects, fault codes. Values, no bytes: canopen.hpp puts them
// into frames, little-endian.
// Source: IEC 61800-7-201 (CiA 402-2) 8.3 (state machine), 8.4 (modes), 6.2.3 (error codes), annex of objects.
#include "msg/joints.hpp"
#include "wire/canopen.hpp"

namespace sinew::wire {

enum class DriveState : std::uint8_t {
  not_ready,
  switch_on_disabled,
  ready_to_switch_on,
  switched_on,
  operation_enabled,
  quick_stop_active,
  fault_reaction,
  fault
};
const char* to_string(DriveState state);
/// Nothing: bits that no state has.
std::optional<DriveState> drive_state(std::uint16_t statusword);
/// The bits of the statusword that make a state; for simulated drives.
std::uint16_t state_bits(DriveState state);

// Statusword bits beside the state.
constexpr std::uint16_t kStatusVoltage = 1 << 4, kStatusWarning = 1 << 7, kStatusRemote = 1 << 9,
                        kStatusLimit = 1 << 11, kStatusTargetReached = 1 << 10, kStatusHomed = 1 << 12,
                        kStatusHomingError = 1 << 13;
// Controlword commands.
constexpr std::uint16_t kControlDisableVoltage = 0x00, kControlQuickStop = 0x02, kControlShutdown = 0x06,
                        kControlSwitchOn = 0x07, kControlEnable = 0x0F, kControlFaultReset = 0x80,
                        kControlHomingStart = 0x1F;

/// What the master wants of a drive.
enum class DriveGoal : std::uint8_t { off, enabled, quick_stop };
/// The next controlword on the way from a state to a goal. For a fault this is `off`: the caller makes the edge of bit
/// 7 that resets it.
std::uint16_t next_controlword(DriveState state, DriveGoal goal);
/// The state that a drive goes to on a controlword, without the time it takes. `before`: the last controlword (edge of
/// bit 7).
DriveState next_state(DriveState state, std::uint16_t controlword, std::uint16_t before);

enum class DriveMode : std::int8_t {
  none = 0,
  profile_position = 1,
  profile_velocity = 3,
  profile_torque = 4,
  homing = 6,
  cyclic_position = 8,
  cyclic_velocity = 9,
  cyclic_torque = 10
};

constexpr ObjectAddress kAbortOption{0x6007, 0}, kErrorCode{0x603F, 0}, kControlword{0x6040, 0}, kStatusword{0x6041, 0},
    kQuickStopOption{0x605A, 0}, kModeOfOperation{0x6060, 0}, kModeDisplay{0x6061, 0}, kActualPosition{0x6064, 0},
    kActualVelocity{0x606C, 0}, kTargetTorque{0x6071, 0}, kMaxTorque{0x6072, 0}, kRatedTorque{0x6076, 0},
    kActualTorque{0x6077, 0}, kDcLinkVoltage{0x6079, 0}, kTargetPosition{0x607A, 0}, kHomingMethod{0x6098, 0},
    kInterpolationTime{0x60C2, 1}, kInterpolationExponent{0x60C2, 2}, kTargetVelocity{0x60FF, 0},
    kSupportedModes{0x6502, 0};

/// msg::JointFault bits of an error code (EMCY, 603Fh). Of 0: none.
std::uint32_t joint_faults(std::uint16_t error_code);

}  // namespace sinew::wire
