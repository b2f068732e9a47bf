#include "wire/dronecan_types.hpp"

#include <algorithm>

#include "wire/dronecan_bits.hpp"

namespace sinew::wire {
namespace {

void put_status(BitWriter& bits, const DronecanNodeStatus& in) {
  bits.put(in.uptime_s, 32);
  bits.put(static_cast<std::uint8_t>(in.health), 2);
  bits.put_unsigned(in.mode, 3);
  bits.put_unsigned(in.sub_mode, 3);
  bits.put(in.vendor_code, 16);
}

DronecanNodeStatus take_status(BitReader& bits) {
  DronecanNodeStatus out;
  out.uptime_s = static_cast<std::uint32_t>(bits.take(32));
  out.health = static_cast<DronecanHealth>(bits.take(2));
  out.mode = static_cast<std::uint8_t>(bits.take(3));
  out.sub_mode = static_cast<std::uint8_t>(bits.take(3));
  out.vendor_code = static_cast<std::uint16_t>(bits.take(16));
  return out;
}

std::uint8_t take_byte(BitReader& bits) { return static_cast<std::uint8_t>(bits.take(8)); }

}  // namespace

std::size_t encode(const DronecanNodeStatus& in, std::span<std::uint8_t> out) noexcept {
  BitWriter bits(out);
  put_status(bits, in);
  return bits.size();
}

bool decode(Payload in, DronecanNodeStatus& out) noexcept {
  BitReader bits(in);
  out = take_status(bits);
  return bits.ok();
}

void DronecanNodeInfo::set_name(std::string_view name) noexcept {
  name_size = static_cast<std::uint8_t>(std::min(name.size(), name_text.size()));
  std::copy_n(name.begin(), name_size, name_text.begin());
}

std::size_t encode(const DronecanNodeInfo& in, std::span<std::uint8_t> out) noexcept {
  BitWriter bits(out);
  put_status(bits, in.status);
  bits.put(in.software_major, 8), bits.put(in.software_minor, 8), bits.put(in.software_flags, 8);
  bits.put(in.vcs_commit, 32), bits.put(in.image_crc, 64);
  bits.put(in.hardware_major, 8), bits.put(in.hardware_minor, 8);
  bits.put_bytes(in.unique_id);
  bits.put(0, 8);  // length of the certificate
  // The last array has no length field: it ends with the transfer.
  for (const char c : in.name().substr(0, in.name_text.size())) bits.put(static_cast<std::uint8_t>(c), 8);
  return bits.size();
}

bool decode(Payload in, DronecanNodeInfo& out) noexcept {
  BitReader bits(in);
  out = {};
  out.status = take_status(bits);
  out.software_major = take_byte(bits), out.software_minor = take_byte(bits), out.software_flags = take_byte(bits);
  out.vcs_commit = static_cast<std::uint32_t>(bits.take(32));
  out.image_crc = bits.take(64);
  out.hardware_major = take_byte(bits), out.hardware_minor = take_byte(bits);
  for (std::uint8_t& byte : out.unique_id) byte = take_byte(bits);
  for (std::uint64_t certificate = bits.take(8); certificate > 0 && bits.ok(); --certificate) bits.take(8);
  if (!bits.ok() || bits.bits_left() > 8 * out.name_text.size()) return false;
  while (bits.bits_left() >= 8) out.name_text[out.name_size++] = static_cast<char>(bits.take(8));
  return true;
}

std::size_t encode(const DronecanAllocation& in, std::span<std::uint8_t> out) noexcept {
  if (in.size > in.unique_id.size()) return 0;
  BitWriter bits(out);
  bits.put_unsigned(in.node_id, 7);
  bits.put(in.first_part ? 1 : 0, 1);
  bits.put_bytes(Payload(in.unique_id).first(in.size));
  return bits.size();
}

bool decode(Payload in, DronecanAllocation& out) noexcept {
  if (in.empty() || in.size() > 1 + out.unique_id.size()) return false;
  BitReader bits(in);
  out = {};
  out.node_id = static_cast<std::uint8_t>(bits.take(7));
  out.first_part = bits.take(1) != 0;
  while (bits.bits_left() >= 8) out.unique_id[out.size++] = take_byte(bits);
  return true;
}

std::size_t encode(const DronecanEscRawCommand& in, std::span<std::uint8_t> out) noexcept {
  if (in.count > in.command.size()) return 0;
  BitWriter bits(out);
  for (std::size_t i = 0; i < in.count; ++i) bits.put_signed(in.command[i], 14);
  return bits.size();
}

bool decode(Payload in, DronecanEscRawCommand& out) noexcept {
  if (in.size() > 35) return false;  // 20 of 14 bits
  BitReader bits(in);
  out = {};
  while (bits.bits_left() >= 14) out.command[out.count++] = static_cast<std::int16_t>(bits.take_signed(14));
  return bits.bits_left() < 8;  // of the last byte
}

std::size_t encode(const DronecanEscStatus& in, std::span<std::uint8_t> out) noexcept {
  BitWriter bits(out);
  bits.put(in.error_count, 32);
  bits.put_half(in.voltage_v), bits.put_half(in.current_a), bits.put_half(in.temperature_k);
  bits.put_signed(in.rpm, 18);
  bits.put_unsigned(in.power_pct, 7);
  bits.put_unsigned(in.esc_index, 5);
  return bits.size();
}

bool decode(Payload in, DronecanEscStatus& out) noexcept {
  BitReader bits(in);
  out.error_count = static_cast<std::uint32_t>(bits.take(32));
  out.voltage_v = bits.take_half(), out.current_a = bits.take_half(), out.temperature_k = bits.take_half();
  out.rpm = static_cast<std::int32_t>(bits.take_signed(18));
  out.power_pct = static_cast<std::uint8_t>(bits.take(7));
  out.esc_index = static_cast<std::uint8_t>(bits.take(5));
  return bits.ok();
}

std::size_t encode(const DronecanActuatorCommand& in, std::span<std::uint8_t> out) noexcept {
  if (in.count > in.command.size()) return 0;
  BitWriter bits(out);
  for (std::size_t i = 0; i < in.count; ++i) {
    bits.put(in.command[i].actuator_id, 8), bits.put(in.command[i].type, 8);
    bits.put_half(in.command[i].value);
  }
  return bits.size();
}

bool decode(Payload in, DronecanActuatorCommand& out) noexcept {
  if (in.size() % 4 != 0 || in.size() / 4 > out.command.size()) return false;
  BitReader bits(in);
  out = {};
  while (bits.bits_left() >= 32) {
    DronecanActuatorCommand::One& one = out.command[out.count++];
    one.actuator_id = take_byte(bits), one.type = take_byte(bits);
    one.value = bits.take_half();
  }
  return true;
}

std::size_t encode(const DronecanActuatorStatus& in, std::span<std::uint8_t> out) noexcept {
  BitWriter bits(out);
  bits.put(in.actuator_id, 8);
  bits.put_half(in.position), bits.put_half(in.force), bits.put_half(in.speed);
  bits.put(0, 1);
  bits.put_unsigned(in.power_pct, 7);
  return bits.size();
}

bool decode(Payload in, DronecanActuatorStatus& out) noexcept {
  BitReader bits(in);
  out.actuator_id = take_byte(bits);
  out.position = bits.take_half(), out.force = bits.take_half(), out.speed = bits.take_half();
  bits.take(1);
  out.power_pct = static_cast<std::uint8_t>(bits.take(7));
  return bits.ok();
}

std::size_t encode(const DronecanArmingStatus& in, std::span<std::uint8_t> out) noexcept {
  BitWriter bits(out);
  bits.put(in.armed ? 255 : 0, 8);
  return bits.size();
}

bool decode(Payload in, DronecanArmingStatus& out) noexcept {
  BitReader bits(in);
  out.armed = bits.take(8) == 255;
  return bits.ok();
}

}  // namespace sinew::wire
