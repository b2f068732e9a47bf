#pragma once
// Xiaomi CyberGear motors: 29-bit identifiers that carry a kind, 16 bits of data and an address. Setpoints are
// big-endian.
// Source:  Xiaomi, "CyberGear micro-motor instruction manual" (2023), chapter 4; constants compared with
//          project-sternbergia/cybergear_m5 src/cybergear_driver_defs.hh.
#include <optional>

#include "msg/joints.hpp"
#include "wire/can_bytes.hpp"

namespace sinew::wire {

enum class CyberGearKind : std::uint8_t {
  identify = 0,
  motion = 1,
  feedback = 2,
  enable = 3,
  stop = 4,
  zero = 6,
  read = 17,
  write = 18,
  fault = 21
};

/// The parts of an identifier. To a motor: `data` has the host in its low byte (motion frames: the torque), and
/// `target` is the motor. From a motor: `data` has the motor in its low byte, and `target` is the host.
struct CyberGearId {
  std::uint32_t kind = 0, data = 0, target = 0;
};
constexpr std::uint32_t cybergear_id(CyberGearKind kind, std::uint32_t data, std::uint32_t target) {
  return static_cast<std::uint32_t>(kind) << 24 | (data & 0xFFFF) << 8 | (target & 0xFF);
}
constexpr CyberGearId split_cybergear_id(std::uint32_t id) { return {id >> 24 & 0x1F, id >> 8 & 0xFFFF, id & 0xFF}; }
inline constexpr std::uint32_t kCyberGearBroadcast = 0xFE;  // target of a motor's answer to `identify`

// Ranges of the 16-bit numbers. The manual draws the position's as +-4 pi and calculates with +-12.5, as firmwares do.
inline constexpr double kCyberGearPosition_rad = 12.5, kCyberGearVelocity_radps = 30, kCyberGearEffort_nm = 12,
                        kCyberGearKp = 500, kCyberGearKd = 5;

struct CyberGearMotion {
  double position_rad = 0, velocity_radps = 0, kp = 0, kd = 0, effort_nm = 0;
};
struct CyberGearFeedback {
  std::uint32_t motor = 0, host = 0;
  double position_rad = 0, velocity_radps = 0, effort_nm = 0, temperature_c = 0;
  std::uint32_t fault_bits = 0;  // six bits of the identifier, manual 4.1.3
  std::uint32_t faults = 0;      // the same as msg::JointFault
  enum class Mode : std::uint8_t { reset = 0, calibrating = 1, running = 2 } mode = Mode::reset;
};
struct CyberGearParameter {
  std::uint16_t index = 0;
  std::uint32_t bits = 0;  // little endian, as it is in the frame
  float real() const;
  void set_real(float value);
};
// Parameters that read and write know, manual 4.1.11.
inline constexpr std::uint16_t kCyberGearRunMode = 0x7005, kCyberGearLimitTorque = 0x700B, kCyberGearVbus = 0x701C,
                               kCyberGearCanTimeout = 0x7028;

msg::CanFrame encode_cybergear_motion(std::uint32_t motor, const CyberGearMotion& motion);
std::optional<CyberGearMotion> decode_cybergear_motion(const msg::CanFrame& frame);
msg::CanFrame encode_cybergear_feedback(const CyberGearFeedback& feedback);
std::optional<CyberGearFeedback> decode_cybergear_feedback(const msg::CanFrame& frame);
/// identify, enable, stop (`flag`: clear faults), zero (`flag` set).
msg::CanFrame encode_cybergear(CyberGearKind kind, std::uint32_t host, std::uint32_t motor, bool flag = false);
/// A motor's answer to identify. `serial`: its processor's number.
msg::CanFrame encode_cybergear_identity(std::uint32_t motor, std::uint64_t serial);
std::optional<std::uint64_t> decode_cybergear_identity(const msg::CanFrame& frame);
/// Read (bits 0) and write to a motor, and its answer to read; the two addresses change places in the answer.
msg::CanFrame encode_cybergear_parameter(CyberGearKind kind, std::uint32_t from, std::uint32_t to,
                                         const CyberGearParameter& parameter);
std::optional<CyberGearParameter> decode_cybergear_parameter(const msg::CanFrame& frame);
/// Of a fault report (kind 21): the drive's bits, manual 4.1.9; 0: no faults.
std::optional<std::uint32_t> decode_cybergear_fault(const msg::CanFrame& frame);
msg::CanFrame encode_cybergear_fault(std::uint32_t motor, std::uint32_t host, std::uint32_t bits);
std::uint32_t joint_faults_of_report(std::uint32_t bits);

}  // namespace sinew::wire
