#include "wire/mit_motor.hpp"

#include <limits>

namespace sinew::wire {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// Source: cheetah: bgkatz/motorcontrol, Core/Inc/user_config.h defaults (P 12.5, V 65, kp 500, kd 5, I 40 A at
// 0.45 N m/A); ak*: neurobionics/TMotorCANControl, MIT_Params, after CubeMars' manual; dm*: Damiao's defaults as in the
// Limit_Param table of its own driver (cmjang/DM_Control). Temperature of the AK series: -40..215, manual 5.3.
constexpr MitMotorType kTypes[] = {
    {"cheetah", 12.5, 65, 18, 500, 5, MitReply::plain, 0},
    {"ak10_9", 12.5, 50, 65, 500, 5, MitReply::temperature, -40},
    {"ak60_6", 12.5, 50, 15, 500, 5, MitReply::temperature, -40},
    {"ak70_10", 12.5, 50, 25, 500, 5, MitReply::temperature, -40},
    {"ak80_6", 12.5, 76, 12, 500, 5, MitReply::temperature, -40},
    {"ak80_9", 12.5, 50, 18, 500, 5, MitReply::temperature, -40},
    {"ak80_64", 12.5, 8, 144, 500, 5, MitReply::temperature, -40},
    {"dm4310", 12.5, 30, 10, 500, 5, MitReply::status, 0},
    {"dm4340", 12.5, 8, 28, 500, 5, MitReply::status, 0},
    {"dm6006", 12.5, 45, 20, 500, 5, MitReply::status, 0},
    {"dm8006", 12.5, 45, 40, 500, 5, MitReply::status, 0},
    {"dm8009", 12.5, 45, 54, 500, 5, MitReply::status, 0},
    {"dm10010", 12.5, 20, 200, 500, 5, MitReply::status, 0},
};

// AK series: CubeMars manual, section 5.3, "error code".
std::uint32_t faults_of_error(std::uint32_t code) {
  switch (code) {
    case 0:
      return 0;
    case 1:
      return msg::kJointOverTemperature;
    case 2:
      return msg::kJointOverCurrent;
    case 3:
      return msg::kJointOverVoltage;
    case 4:
      return msg::kJointUnderVoltage;
    case 5:
      return msg::kJointEncoder;
    default:
      return msg::kJointOther;
  }
}

// Damiao manual, feedback frame, "ERR": 0 disabled, 1 enabled, from 8 on faults.
std::uint32_t faults_of_status(std::uint32_t code) {
  switch (code) {
    case 0x0:
    case 0x1:
      return 0;
    case 0x8:
      return msg::kJointOverVoltage;
    case 0x9:
      return msg::kJointUnderVoltage;
    case 0xA:
      return msg::kJointOverCurrent;
    case 0xB:
    case 0xC:
      return msg::kJointOverTemperature;
    case 0xD:
      return msg::kJointLost;
    case 0xE:
      return msg::kJointOverload;
    default:
      return msg::kJointOther;
  }
}

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(value > 255 ? 255.0 : value > 0 ? value + 0.5 : 0.0);
}

}  // namespace

std::span<const MitMotorType> mit_motor_types() { return kTypes; }

const MitMotorType* mit_motor_type(std::string_view name) {
  for (const MitMotorType& type : kTypes) {
    if (name == type.name) return &type;
  }
  return nullptr;
}

msg::CanFrame encode_mit(std::uint32_t motor, const MitCommand& c, const MitMotorType& t) {
  const std::uint32_t p = to_steps(c.position_rad, -t.position_rad, t.position_rad, 16);
  const std::uint32_t v = to_steps(c.velocity_radps, -t.velocity_radps, t.velocity_radps, 12);
  const std::uint32_t kp = to_steps(c.kp, 0, t.kp, 12), kd = to_steps(c.kd, 0, t.kd, 12);
  std::uint32_t e = to_steps(c.effort_nm, -t.effort_nm, t.effort_nm, 12);
  // All ones except the last nibble means a switch. A setpoint that would look like one gets one step less effort.
  const bool high = p == 0xFFFF && v == 0xFFF && kp == 0xFFF && kd == 0xFFF;
  if (high && e >= 0xFF0) e = 0xFEF;
  msg::CanFrame frame = can_frame(motor, 8);
  put_be16(frame, 0, p);
  frame.data[2] = static_cast<std::uint8_t>(v >> 4);
  frame.data[3] = static_cast<std::uint8_t>(v << 4 | kp >> 8);
  frame.data[4] = static_cast<std::uint8_t>(kp);
  frame.data[5] = static_cast<std::uint8_t>(kd >> 4);
  frame.data[6] = static_cast<std::uint8_t>(kd << 4 | e >> 8);
  frame.data[7] = static_cast<std::uint8_t>(e);
  return frame;
}

msg::CanFrame encode_mit(std::uint32_t motor, MitSwitch what) {
  return can_frame(motor, {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, static_cast<std::uint8_t>(what)});
}

std::optional<MitSwitch> decode_mit_switch(const msg::CanFrame& frame) {
  if (!is_data(frame, false) || frame.size != 8) return {};
  for (std::size_t i = 0; i < 7; ++i) {
    if (frame.data[i] != 0xFF) return {};
  }
  if (frame.data[7] < 0xFB || frame.data[7] > 0xFE) return {};
  return static_cast<MitSwitch>(frame.data[7]);
}

std::optional<MitCommand> decode_mit_command(const msg::CanFrame& frame, const MitMotorType& t) {
  if (!is_data(frame, false) || frame.size != 8 || decode_mit_switch(frame)) return {};
  const auto& d = frame.data;
  const auto bits = [&d](std::size_t high, std::size_t low) {
    return static_cast<std::uint32_t>(d[high] << 8 | d[low]);
  };
  MitCommand c;
  c.position_rad = from_steps(get_be16(frame, 0), -t.position_rad, t.position_rad, 16);
  c.velocity_radps = from_steps(bits(2, 3) >> 4, -t.velocity_radps, t.velocity_radps, 12);
  c.kp = from_steps(bits(3, 4) & 0xFFF, 0, t.kp, 12);
  c.kd = from_steps(bits(5, 6) >> 4, 0, t.kd, 12);
  c.effort_nm = from_steps(bits(6, 7) & 0xFFF, -t.effort_nm, t.effort_nm, 12);
  return c;
}

msg::CanFrame encode_mit_reply(std::uint32_t master, const MitFeedback& f, const MitMotorType& t) {
  const std::uint32_t v = to_steps(f.velocity_radps, -t.velocity_radps, t.velocity_radps, 12);
  const std::uint32_t e = to_steps(f.effort_nm, -t.effort_nm, t.effort_nm, 12);
  msg::CanFrame frame = can_frame(master, 6);
  frame.data[0] = static_cast<std::uint8_t>(f.motor);
  put_be16(frame, 1, to_steps(f.position_rad, -t.position_rad, t.position_rad, 16));
  frame.data[3] = static_cast<std::uint8_t>(v >> 4);
  frame.data[4] = static_cast<std::uint8_t>(v << 4 | e >> 8);
  frame.data[5] = static_cast<std::uint8_t>(e);
  if (t.reply == MitReply::plain) {
    if (f.voltage_v == f.voltage_v) frame.data[frame.size++] = to_byte(2 * f.voltage_v);
    return frame;
  }
  frame.size = 8;
  frame.data[6] = to_byte(f.temperature_c - t.temperature_offset_c);
  if (t.reply == MitReply::temperature) {
    frame.data[7] = static_cast<std::uint8_t>(f.code);
  } else {
    frame.data[0] = static_cast<std::uint8_t>(f.code << 4 | (f.motor & 0xF));
    frame.data[7] = to_byte(f.temperature_c - t.temperature_offset_c);
  }
  return frame;
}

std::optional<MitFeedback> decode_mit_reply(const msg::CanFrame& frame, const MitMotorType& t) {
  if (!is_data(frame, false)) return {};
  const bool plain = t.reply == MitReply::plain;
  if (plain ? frame.size != 6 && frame.size != 7 : frame.size != 8) return {};
  const auto& d = frame.data;
  MitFeedback f;
  f.motor = d[0];
  f.position_rad = from_steps(get_be16(frame, 1), -t.position_rad, t.position_rad, 16);
  f.velocity_radps =
      from_steps(static_cast<std::uint32_t>(d[3] << 4 | d[4] >> 4), -t.velocity_radps, t.velocity_radps, 12);
  f.effort_nm = from_steps(static_cast<std::uint32_t>((d[4] & 0xF) << 8 | d[5]), -t.effort_nm, t.effort_nm, 12);
  f.temperature_c = f.voltage_v = kNone;
  if (plain) {
    if (frame.size == 7) f.voltage_v = d[6] / 2.0;
    return f;
  }
  f.temperature_c = d[6] + t.temperature_offset_c;
  if (t.reply == MitReply::temperature) {
    f.code = d[7];
    f.faults = faults_of_error(f.code);
    return f;
  }
  f.motor = d[0] & 0xF;
  f.temperature_c = (d[6] > d[7] ? d[6] : d[7]) + t.temperature_offset_c;  // the warmer one counts
  const std::uint32_t status = d[0] >> 4;
  f.status_known = true;
  f.enabled = status == 1;
  f.faults = faults_of_status(status);
  f.code = f.faults != 0 ? status : 0;
  return f;
}

}  // namespace sinew::wire
