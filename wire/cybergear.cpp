#include "wire/cybergear.hpp"

#include <bit>

namespace sinew::wire {
namespace {

bool is_kind(const msg::CanFrame& frame, CyberGearKind kind) {
  return is_data(frame, true) && frame.size == 8 &&
         split_cybergear_id(frame.id).kind == static_cast<std::uint32_t>(kind);
}

/// Bits 16..21 of the identifier, from bit 0: under-voltage, over-current, over-temperature, magnetic encoder, Hall
/// encoder, not calibrated (manual 4.1.3).
std::uint32_t faults_of_id(std::uint32_t bits) {
  std::uint32_t faults = 0;
  if ((bits & 1) != 0) faults |= msg::kJointUnderVoltage;
  if ((bits & 2) != 0) faults |= msg::kJointOverCurrent;
  if ((bits & 4) != 0) faults |= msg::kJointOverTemperature;
  if ((bits & 0x38) != 0) faults |= msg::kJointEncoder;
  return faults;
}

}  // namespace

float CyberGearParameter::real() const { return std::bit_cast<float>(bits); }
void CyberGearParameter::set_real(float value) { bits = std::bit_cast<std::uint32_t>(value); }

msg::CanFrame encode_cybergear_motion(std::uint32_t motor, const CyberGearMotion& m) {
  const std::uint32_t effort = to_steps(m.effort_nm, -kCyberGearEffort_nm, kCyberGearEffort_nm, 16);
  msg::CanFrame frame = can_frame(cybergear_id(CyberGearKind::motion, effort, motor), 8, true);
  put_be16(frame, 0, to_steps(m.position_rad, -kCyberGearPosition_rad, kCyberGearPosition_rad, 16));
  put_be16(frame, 2, to_steps(m.velocity_radps, -kCyberGearVelocity_radps, kCyberGearVelocity_radps, 16));
  put_be16(frame, 4, to_steps(m.kp, 0, kCyberGearKp, 16));
  put_be16(frame, 6, to_steps(m.kd, 0, kCyberGearKd, 16));
  return frame;
}

std::optional<CyberGearMotion> decode_cybergear_motion(const msg::CanFrame& frame) {
  if (!is_kind(frame, CyberGearKind::motion)) return {};
  CyberGearMotion m;
  m.effort_nm = from_steps(split_cybergear_id(frame.id).data, -kCyberGearEffort_nm, kCyberGearEffort_nm, 16);
  m.position_rad = from_steps(get_be16(frame, 0), -kCyberGearPosition_rad, kCyberGearPosition_rad, 16);
  m.velocity_radps = from_steps(get_be16(frame, 2), -kCyberGearVelocity_radps, kCyberGearVelocity_radps, 16);
  m.kp = from_steps(get_be16(frame, 4), 0, kCyberGearKp, 16);
  m.kd = from_steps(get_be16(frame, 6), 0, kCyberGearKd, 16);
  return m;
}

msg::CanFrame encode_cybergear_feedback(const CyberGearFeedback& f) {
  const std::uint32_t data = static_cast<std::uint32_t>(f.mode) << 14 | (f.fault_bits & 0x3F) << 8 | (f.motor & 0xFF);
  msg::CanFrame frame = can_frame(cybergear_id(CyberGearKind::feedback, data, f.host), 8, true);
  put_be16(frame, 0, to_steps(f.position_rad, -kCyberGearPosition_rad, kCyberGearPosition_rad, 16));
  put_be16(frame, 2, to_steps(f.velocity_radps, -kCyberGearVelocity_radps, kCyberGearVelocity_radps, 16));
  put_be16(frame, 4, to_steps(f.effort_nm, -kCyberGearEffort_nm, kCyberGearEffort_nm, 16));
  put_be16(frame, 6, to_steps(f.temperature_c, 0, 6553.5, 16));  // tenths of a degree
  return frame;
}

std::optional<CyberGearFeedback> decode_cybergear_feedback(const msg::CanFrame& frame) {
  if (!is_kind(frame, CyberGearKind::feedback)) return {};
  const CyberGearId id = split_cybergear_id(frame.id);
  if (id.data >> 14 > 2) return {};
  CyberGearFeedback f;
  f.motor = id.data & 0xFF;
  f.host = id.target;
  f.fault_bits = id.data >> 8 & 0x3F;
  f.faults = faults_of_id(f.fault_bits);
  f.mode = static_cast<CyberGearFeedback::Mode>(id.data >> 14);
  f.position_rad = from_steps(get_be16(frame, 0), -kCyberGearPosition_rad, kCyberGearPosition_rad, 16);
  f.velocity_radps = from_steps(get_be16(frame, 2), -kCyberGearVelocity_radps, kCyberGearVelocity_radps, 16);
  f.effort_nm = from_steps(get_be16(frame, 4), -kCyberGearEffort_nm, kCyberGearEffort_nm, 16);
  f.temperature_c = get_be16(frame, 6) / 10.0;
  return f;
}

msg::CanFrame encode_cybergear(CyberGearKind kind, std::uint32_t host, std::uint32_t motor, bool flag) {
  msg::CanFrame frame = can_frame(cybergear_id(kind, host, motor), 8, true);
  frame.data[0] = flag ? 1 : 0;
  return frame;
}

msg::CanFrame encode_cybergear_identity(std::uint32_t motor, std::uint64_t serial) {
  msg::CanFrame frame = can_frame(cybergear_id(CyberGearKind::identify, motor, kCyberGearBroadcast), 8, true);
  put_le(frame, 0, serial);
  return frame;
}

std::optional<std::uint64_t> decode_cybergear_identity(const msg::CanFrame& frame) {
  if (!is_kind(frame, CyberGearKind::identify)) return {};
  return get_le<std::uint64_t>(frame, 0);
}

msg::CanFrame encode_cybergear_parameter(CyberGearKind kind, std::uint32_t from, std::uint32_t to,
                                         const CyberGearParameter& parameter) {
  msg::CanFrame frame = can_frame(cybergear_id(kind, from, to), 8, true);
  put_le(frame, 0, parameter.index);
  put_le(frame, 4, parameter.bits);
  return frame;
}

std::optional<CyberGearParameter> decode_cybergear_parameter(const msg::CanFrame& frame) {
  if (!is_kind(frame, CyberGearKind::read) && !is_kind(frame, CyberGearKind::write)) return {};
  return CyberGearParameter{get_le<std::uint16_t>(frame, 0), get_le<std::uint32_t>(frame, 4)};
}

msg::CanFrame encode_cybergear_fault(std::uint32_t motor, std::uint32_t host, std::uint32_t bits) {
  msg::CanFrame frame = can_frame(cybergear_id(CyberGearKind::fault, motor, host), 8, true);
  put_le(frame, 0, bits);
  return frame;
}

std::optional<std::uint32_t> decode_cybergear_fault(const msg::CanFrame& frame) {
  if (!is_kind(frame, CyberGearKind::fault)) return {};
  return get_le<std::uint32_t>(frame, 0);
}

std::uint32_t joint_faults_of_report(std::uint32_t bits) {
  std::uint32_t faults = 0;
  if ((bits & 1u << 0) != 0) faults |= msg::kJointOverTemperature;
  if ((bits & 1u << 2) != 0) faults |= msg::kJointUnderVoltage;
  if ((bits & 1u << 3) != 0) faults |= msg::kJointOverVoltage;
  if ((bits & (1u << 4 | 1u << 5 | 1u << 16)) != 0) faults |= msg::kJointOverCurrent;  // phases B, C, A
  if ((bits & 1u << 7) != 0) faults |= msg::kJointEncoder;                             // not calibrated
  if ((bits & 0x3F00) != 0) faults |= msg::kJointOverload;
  if (faults == 0 && bits != 0) faults = msg::kJointOther;
  return faults;
}

}  // namespace sinew::wire
