#pragma once
// "MIT" motor frames: one frame with position, velocity, gains and torque, answered by one with the motor's
// measurements. Numbers of 12 and 16 bits follow each other, highest bit first.
// Source:  the open controller firmware of their origin, bgkatz/motorcontrol Core/Src/can.c; CubeMars, "AK series
//          actuator driver manual" 1.0.15, section 5.3; Damiao, "DM-J4310 user manual", section on MIT mode.
#include <optional>
#include <string_view>

#include "msg/joints.hpp"
#include "wire/can_bytes.hpp"

namespace sinew::wire {

/// The fields of a reply behind position, velocity and torque.
enum class MitReply : std::uint8_t {
  plain,        // nothing (six bytes), or the bus voltage (a seventh, in half volts)
  temperature,  // a byte of temperature, one with an error number (AK series)
  status,       // a status in the upper half of the id, temperatures of bridge and winding (Damiao)
};

/// How numbers lie in the frames of one motor type; symmetric about zero, gains from zero.
/// The firmware's own settings count: they differ between versions, and many motors let the user change them.
struct MitMotorType {
  const char* name = "";
  double position_rad = 12.5, velocity_radps = 45, effort_nm = 18;
  double kp = 500, kd = 5;  // N m/rad, N m s/rad
  MitReply reply = MitReply::plain;
  double temperature_offset_c = 0;
};
/// Types known by name ("ak80_9", "dm4310"); null: none of that name.
const MitMotorType* mit_motor_type(std::string_view name);
std::span<const MitMotorType> mit_motor_types();

struct MitCommand {
  double position_rad = 0, velocity_radps = 0, kp = 0, kd = 0, effort_nm = 0;
};
/// Values outside the ranges are pulled in.
msg::CanFrame encode_mit(std::uint32_t motor, const MitCommand& command, const MitMotorType& type);

/// Eight bytes that are no setpoint: the last byte is the switch.
enum class MitSwitch : std::uint8_t { clear_fault = 0xFB, enable = 0xFC, disable = 0xFD, zero = 0xFE };
msg::CanFrame encode_mit(std::uint32_t motor, MitSwitch what);

struct MitFeedback {
  std::uint32_t motor = 0;
  double position_rad = 0, velocity_radps = 0, effort_nm = 0;
  double temperature_c = 0, voltage_v = 0;  // NaN: not in the frame
  std::uint32_t code = 0;                   // error number or status; 0: none, or not in the frame
  std::uint32_t faults = 0;                 // what `code` means, msg::JointFault bits
  bool status_known = false, enabled = false;
};
/// Takes any identifier (all motors may answer on one number, the master's). Nothing: another size than this type's
/// answers.
std::optional<MitFeedback> decode_mit_reply(const msg::CanFrame& frame, const MitMotorType& type);

// The motor's side, for simulated motors.
std::optional<MitCommand> decode_mit_command(const msg::CanFrame& frame, const MitMotorType& type);
std::optional<MitSwitch> decode_mit_switch(const msg::CanFrame& frame);
msg::CanFrame encode_mit_reply(std::uint32_t master, const MitFeedback& feedback, const MitMotorType& type);

}  // namespace sinew::wire
