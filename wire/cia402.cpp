#include "wire/cia402.hpp"

namespace sinew::wire {

const char* to_string(DriveState state) {
  switch (state) {
    case DriveState::not_ready:
      return "not ready to switch on";
    case DriveState::switch_on_disabled:
      return "switch on disabled";
    case DriveState::ready_to_switch_on:
      return "ready to switch on";
    case DriveState::switched_on:
      return "switched on";
    case DriveState::operation_enabled:
      return "operation enabled";
    case DriveState::quick_stop_active:
      return "quick stop active";
    case DriveState::fault_reaction:
      return "fault reaction active";
    case DriveState::fault:
      return "fault";
  }
  return "?";
}

std::optional<DriveState> drive_state(std::uint16_t statusword) {
  switch (statusword & 0x4F) {  // these states do not look at the quick stop bit
    case 0x00:
      return DriveState::not_ready;
    case 0x40:
      return DriveState::switch_on_disabled;
    case 0x0F:
      return DriveState::fault_reaction;
    case 0x08:
      return DriveState::fault;
    default:
      break;
  }
  switch (statusword & 0x6F) {
    case 0x21:
      return DriveState::ready_to_switch_on;
    case 0x23:
      return DriveState::switched_on;
    case 0x27:
      return DriveState::operation_enabled;
    case 0x07:
      return DriveState::quick_stop_active;
    default:
      return {};
  }
}

std::uint16_t state_bits(DriveState state) {
  switch (state) {
    case DriveState::not_ready:
      return 0x00;
    case DriveState::switch_on_disabled:
      return 0x40;
    case DriveState::ready_to_switch_on:
      return 0x21;
    case DriveState::switched_on:
      return 0x23;
    case DriveState::operation_enabled:
      return 0x27;
    case DriveState::quick_stop_active:
      return 0x07;
    case DriveState::fault_reaction:
      return 0x0F;
    case DriveState::fault:
      return 0x08;
  }
  return 0;
}

std::uint16_t next_controlword(DriveState state, DriveGoal goal) {
  if (goal == DriveGoal::off) return kControlDisableVoltage;
  if (goal == DriveGoal::quick_stop) {
    const bool moving = state == DriveState::operation_enabled || state == DriveState::quick_stop_active;
    return moving ? kControlQuickStop : kControlDisableVoltage;
  }
  switch (state) {
    case DriveState::switch_on_disabled:
      return kControlShutdown;
    case DriveState::ready_to_switch_on:
      return kControlSwitchOn;
    case DriveState::switched_on:
    case DriveState::operation_enabled:
      return kControlEnable;
    case DriveState::quick_stop_active:  // not every drive can go back from here; all can go through switch on disabled
    case DriveState::not_ready:
    case DriveState::fault_reaction:
    case DriveState::fault:
      break;
  }
  return kControlDisableVoltage;
}

DriveState next_state(DriveState state, std::uint16_t controlword, std::uint16_t before) {
  const bool reset_edge = (controlword & ~before & kControlFaultReset) != 0;
  const std::uint16_t command = controlword & 0x0F;
  const bool disable_voltage = (command & 0x02) == 0, quick_stop = (command & 0x06) == 0x02;
  const bool shutdown = (command & 0x07) == 0x06, switch_on = (command & 0x0F) == 0x07, enable = command == 0x0F;
  switch (state) {
    case DriveState::fault:
      return reset_edge ? DriveState::switch_on_disabled : state;
    case DriveState::switch_on_disabled:
      return shutdown ? DriveState::ready_to_switch_on : state;
    case DriveState::ready_to_switch_on:
      if (disable_voltage || quick_stop) return DriveState::switch_on_disabled;
      return switch_on || enable ? DriveState::switched_on : state;
    case DriveState::switched_on:
      if (disable_voltage || quick_stop) return DriveState::switch_on_disabled;
      if (shutdown) return DriveState::ready_to_switch_on;
      return enable ? DriveState::operation_enabled : state;
    case DriveState::operation_enabled:
      if (disable_voltage) return DriveState::switch_on_disabled;
      if (quick_stop) return DriveState::quick_stop_active;
      if (shutdown) return DriveState::ready_to_switch_on;
      return switch_on ? DriveState::switched_on : state;
    case DriveState::quick_stop_active:
      if (disable_voltage) return DriveState::switch_on_disabled;
      return enable ? DriveState::operation_enabled : state;
    case DriveState::not_ready:
    case DriveState::fault_reaction:
      break;
  }
  return state;
}

std::uint32_t joint_faults(std::uint16_t error_code) {
  const std::uint32_t group = error_code >> 12, subgroup = error_code >> 8, family = error_code >> 4;
  if (error_code == 0) return 0;
  if (group == 0x2) return msg::kJointOverCurrent;
  if (group == 0x4) return msg::kJointOverTemperature;
  if (group == 0x3) {  // voltage: 3x1y is over, 3x2y under
    const std::uint32_t kind = family & 0xF;
    return kind == 2   ? std::uint32_t{msg::kJointUnderVoltage}
           : kind == 1 ? std::uint32_t{msg::kJointOverVoltage}
                       : std::uint32_t{msg::kJointOther};
  }
  if (subgroup == 0x73) return msg::kJointEncoder;                                         // sensor
  if (family == 0x712 || subgroup == 0x83 || family == 0x861) return msg::kJointOverload;  // stalled, torque, following
  if (family == 0x813 || family == 0x814) return msg::kJointLost;                          // heartbeat, bus off
  return msg::kJointOther;
}

}  // namespace sinew::wire
