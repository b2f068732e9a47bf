#include "sim_hil/wire/sim_dronecan.hpp"

#include <algorithm>
#include <array>

namespace sinew::sim_hil {
namespace {

using namespace std::chrono_literals;
using wire::DronecanCommandType;
using wire::DronecanId;
using wire::DronecanWanted;

constexpr DronecanWanted kHeard[] = {wire::kDronecanGetNodeInfo, wire::kDronecanAllocation,
                                     wire::kDronecanEscRawCommand, wire::kDronecanActuatorCommand,
                                     wire::kDronecanArmingStatus};
constexpr double kRpmPerRadps = 60 / (2 * 3.14159265358979323846);

}  // namespace

SimDronecanServo::SimDronecanServo(hal::CanBus& bus, SimJoint& joint, const SimMount& mount,
                                   const Parameters& parameters)
    : SimServo(bus, joint, mount), p_(parameters), assembler_(kHeard, 4) {}

void SimDronecanServo::on_power() {
  node_id_ = p_.node_id;
  live_ = began_ = disarmed_ = false;
  fault_ = 0;
  known_ = 0;
}

void SimDronecanServo::send_all(DronecanId id, std::uint64_t signature, std::uint8_t transfer,
                                std::span<const std::uint8_t> payload) {
  wire::DronecanSplitter splitter(id, signature, transfer, payload);
  for (msg::CanFrame frame; splitter.next(frame);) send(frame);
}

void SimDronecanServo::tell(const DronecanWanted& type, std::uint8_t& transfer, std::span<const std::uint8_t> payload) {
  DronecanId id;
  id.type = type.type, id.source = node_id_;
  send_all(id, type.signature, transfer, payload);
  transfer = static_cast<std::uint8_t>((transfer + 1) & 31);
}

wire::DronecanNodeStatus SimDronecanServo::status(Time now) const {
  wire::DronecanNodeStatus out;
  out.uptime_s = static_cast<std::uint32_t>((now - powered_at_) / 1s) + uptime_offset_s;
  if (fault_ != 0) out.health = wire::DronecanHealth::error;
  out.vendor_code = static_cast<std::uint16_t>(fault_);
  return out;
}

void SimDronecanServo::say(Time now) {
  now_ = now;
  if (!began_) {
    began_ = true;
    powered_at_ = node_status_at_ = status_at_ = ask_at_ = now;
  }
  if (node_id_ == 0) {
    if (now >= ask_at_) ask_for_id(now);
    return;
  }
  std::array<std::uint8_t, 16> bytes{};
  if (now >= node_status_at_) {
    node_status_at_ = node_status_at_ + 1s;
    const std::size_t size = encode(status(now), bytes);
    tell(wire::kDronecanNodeStatus, node_transfer_, std::span(bytes).first(size));
  }
  if (now < status_at_) return;
  status_at_ = now + Duration(static_cast<std::int64_t>(1e9 / p_.status_hz));
  say_status();
}

void SimDronecanServo::say_status() {
  std::array<std::uint8_t, 16> bytes{};
  if (p_.esc) {
    wire::DronecanEscStatus out;
    out.voltage_v = voltage_v, out.temperature_k = temperature_c + 273.15;
    out.rpm = static_cast<std::int32_t>(std::lround(drive_velocity() * kRpmPerRadps));
    out.esc_index = p_.actuator_id;
    out.power_pct = power_pct();
    const std::size_t size = encode(out, bytes);
    return tell(wire::kDronecanEscStatus, status_transfer_, std::span(bytes).first(size));
  }
  wire::DronecanActuatorStatus out;
  out.actuator_id = p_.actuator_id;
  out.position = drive_position(), out.speed = drive_velocity(), out.force = drive_effort();
  out.power_pct = power_pct();
  const std::size_t size = encode(out, bytes);
  tell(wire::kDronecanActuatorStatus, status_transfer_, std::span(bytes).first(size));
}

/// 600 to 1000 ms, as the specification asks: nodes that start together do not go on asking together.
Duration SimDronecanServo::pause() {
  random_ = random_ * 1664525u + 1013904223u + p_.unique_id[0];
  return 600ms + std::chrono::milliseconds(random_ >> 16 & 0x3FF) * 400 / 1024;
}

/// One request: 6 bytes, 6 more when the allocator has repeated the first, then the last 4. Without an answer it begins
/// anew.
void SimDronecanServo::ask_for_id(Time now) {
  ask_at_ = now + pause();
  wire::DronecanAllocation ask;
  ask.first_part = known_ == 0;
  ask.size = known_ == 12 ? 4 : 6;
  std::copy_n(p_.unique_id.begin() + known_, ask.size, ask.unique_id.begin());
  std::array<std::uint8_t, 7> bytes{};
  const std::size_t size = encode(ask, bytes);
  DronecanId id;
  id.type = wire::kDronecanAllocation.type;
  id.discriminator = static_cast<std::uint16_t>(p_.unique_id[known_] * 64 + p_.unique_id[15]);
  send_all(id, wire::kDronecanAllocation.signature, ask_transfer_, std::span(bytes).first(size));
  ask_transfer_ = static_cast<std::uint8_t>((ask_transfer_ + 1) & 31);
  known_ = 0;  // until the allocator repeats it
}

void SimDronecanServo::on_allocation(const wire::DronecanTransfer& transfer, Time now) {
  wire::DronecanAllocation said;
  if (node_id_ != 0 || transfer.id.source == 0 || !decode(transfer.payload, said)) return;
  const bool ours = std::equal(said.unique_id.begin(), said.unique_id.begin() + said.size, p_.unique_id.begin());
  if (!ours) {  // the allocator answers another node
    known_ = 0;
    ask_at_ = now + pause();
    return;
  }
  if (said.size <= known_) return;
  known_ = said.size;
  if (said.size == 16 && said.node_id != 0) {
    node_id_ = said.node_id;
    node_status_at_ = status_at_ = now;
  } else {
    ask_at_ = now;
  }
}

void SimDronecanServo::on_command(const wire::DronecanTransfer& transfer, Time now) {
  bool ours = false;
  if (transfer.id.type == wire::kDronecanEscRawCommand.type) {
    wire::DronecanEscRawCommand raw;
    ours = p_.esc && decode(transfer.payload, raw) && p_.actuator_id < raw.count;
    if (ours)
      type_ = DronecanCommandType::speed,
      setpoint_ = raw.command[p_.actuator_id] * p_.esc_full_radps / wire::kDronecanEscFull;
  } else {
    wire::DronecanActuatorCommand command;
    if (p_.esc || !decode(transfer.payload, command)) return;
    for (std::size_t i = 0; i < command.count; ++i) {
      if (command.command[i].actuator_id != p_.actuator_id) continue;
      ours = true;
      type_ = static_cast<DronecanCommandType>(command.command[i].type);
      setpoint_ = command.command[i].value;
    }
  }
  if (!ours || fault_ != 0 || disarmed_) return;
  ++commands_;
  commanded_ = now;
  live_ = !(p_.esc && setpoint_ == 0);
}

void SimDronecanServo::on_arming(const wire::DronecanTransfer& transfer) {
  wire::DronecanArmingStatus status;
  if (!decode(transfer.payload, status)) return;
  disarmed_ = !status.armed;
  if (disarmed_) live_ = false;
}

/// In per cent of the most torque; at least 1 while it is live, so that 0 means "not live".
std::uint8_t SimDronecanServo::power_pct() const {
  if (!live_) return 0;
  return static_cast<std::uint8_t>(std::clamp(100 * std::abs(drive_effort()) / p_.most_nm, 1.0, 100.0));
}

void SimDronecanServo::on_frame(const msg::CanFrame& frame, Time now) {
  wire::DronecanTransfer transfer;
  if (assembler_.push(frame, now, node_id_, transfer) != wire::DronecanAssembler::Heard::complete) return;
  if (transfer.id.service) {
    if (!transfer.id.request || node_id_ == 0) return;
    wire::DronecanNodeInfo info;
    info.status = status(now);
    info.hardware_major = 1, info.unique_id = p_.unique_id;
    info.set_name(p_.name);
    std::array<std::uint8_t, wire::kDronecanMaxPayload> bytes{};
    const std::size_t size = encode(info, bytes);
    DronecanId id = transfer.id;
    id.request = false;
    std::swap(id.source, id.destination);
    send_all(id, wire::kDronecanGetNodeInfo.signature, transfer.transfer_id, std::span(bytes).first(size));
  } else if (transfer.id.type == wire::kDronecanAllocation.type) {
    on_allocation(transfer, now);
  } else if (transfer.id.type == wire::kDronecanArmingStatus.type) {
    on_arming(transfer);
  } else if (node_id_ != 0) {
    on_command(transfer, now);
  }
}

double SimDronecanServo::control(Time now, Duration) {
  if (live_ && now - commanded_ > p_.timeout) live_ = false;
  if (!live_) return 0;
  double nm = 0;
  if (type_ == DronecanCommandType::position) nm = p_.kp * (setpoint_ - drive_position()) - p_.kd * drive_velocity();
  if (type_ == DronecanCommandType::speed) nm = p_.kv * (setpoint_ - drive_velocity());
  if (type_ == DronecanCommandType::force) nm = setpoint_;
  return std::clamp(nm, -p_.most_nm, p_.most_nm);
}

}  // namespace sinew::sim_hil
