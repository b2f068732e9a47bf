#include "drivers/joints/dronecan_servo.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::drivers {
namespace {

using wire::DronecanCommandType;
using wire::DronecanWanted;

constexpr DronecanWanted kServoHeard[] = {wire::kDronecanNodeStatus, wire::kDronecanGetNodeInfo,
                                          wire::kDronecanActuatorStatus, wire::kDronecanEscStatus};
constexpr double kRadpsPerRpm = 2 * 3.14159265358979323846 / 60;
constexpr std::uint32_t kFreshUptime_s = 3;                  // a node that says less has just begun
constexpr double kUptimeSlack_s = 1;                         // they are whole seconds
constexpr Duration kForthAndBack = std::chrono::seconds(3);  // statuses come each second
constexpr std::uint32_t kModeCode = 0x10000;  // fault codes above the vendor's 16 bits: not operational, and its mode

DronecanCommandType type_of(ServoMode mode) {
  return mode == ServoMode::position   ? DronecanCommandType::position
         : mode == ServoMode::velocity ? DronecanCommandType::speed
                                       : DronecanCommandType::force;
}

StopAction stop_of(const ServoConfig& c, const DronecanServoOptions& o) {
  if (o.esc || c.mode == ServoMode::effort) return StopAction::torque_off;
  return c.mode == ServoMode::position ? StopAction::hold : StopAction::damp;
}

}  // namespace

WrongKeys check_dronecan(const ServoConfig& c, const DronecanServoOptions& o) {
  WrongKeys wrong = check_servo(c, o.esc);
  if (c.node_id < 1 || c.node_id > wire::kDronecanMaxNode) wrong.push_back({"id", "an integer from 1 to 127"});
  if (o.esc && c.mode != ServoMode::velocity) wrong.push_back({"mode", "\"velocity\"; an ESC has no other"});
  if (o.esc && !(o.esc_full_radps > 0 && std::isfinite(o.esc_full_radps)))
    wrong.push_back({"esc_full_radps", "a number above 0; required for an ESC"});
  if (o.esc && c.zero_rad != 0) wrong.push_back({"zero_rad", "0: an ESC has no position"});
  const std::uint32_t most_id = o.esc ? 19 : 255;
  if (c.actuator_id > most_id)
    wrong.push_back({"actuator_id", "an integer from 0 to " + std::to_string(most_id) + (o.esc ? ", for an ESC" : "")});
  if (c.stop != stop_of(c, o))
    wrong.push_back({"on_stop", o.esc                           ? "\"torque_off\"; an ESC has no other"
                                : c.mode == ServoMode::position ? "\"hold\"; an actuator in mode position has no other"
                                : c.mode == ServoMode::velocity
                                    ? "\"damp\"; an actuator in mode velocity has no other"
                                    : "\"torque_off\"; an actuator in mode effort has no other"});
  if (c.homing_method != 0) wrong.push_back({"homing_method", "0: DroneCAN has none"});
  if (c.device_timeout > Duration{0})
    wrong.push_back({"device_timeout_ms", "0: it is set in the device, no frame does it"});
  if (!(o.status_hz > 0)) wrong.push_back({"status_hz", "a number above 0"});
  return wrong;
}

DronecanServo::DronecanServo(const ServoConfig& config, const DronecanServoOptions& options, DronecanNode& node)
    : joint_(config), options_(options), node_(node), assembler_(kServoHeard, 2) {
  const std::uint32_t status = options.esc ? wire::kDronecanEscStatus.type : wire::kDronecanActuatorStatus.type;
  interests_ = {Interest{status << 8 | config.node_id, 0x00FFFFFF, true},
                Interest{wire::kDronecanNodeStatus.type << 8u | config.node_id, 0x00FFFFFF, true},
                Interest{1u << 16 | std::uint32_t{node.id()} << 8 | 0x80u | config.node_id, 0x00FFFFFF, true}};
  if (options.esc)
    node.join_esc(config.actuator_id);
  else
    node.join_actuator();
  show();
}

BusNeed DronecanServo::need(double /*tick_hz*/) const {
  msg::CanFrame full;
  full.size = 8, full.flags = msg::kCanExtended;
  BusNeed need;
  need.add(full, (options_.esc ? 3 : 2) * options_.status_hz);  // 14 or 8 bytes with a CRC
  need.add(full, 1);
  return need;
}

Heard DronecanServo::on_frame(const msg::CanFrame& frame, Time now) noexcept {
  wire::DronecanTransfer transfer;
  using Parts = wire::DronecanAssembler::Heard;
  switch (assembler_.push(frame, now, node_.id(), transfer)) {
    case Parts::foreign:
      return Heard::foreign;
    case Parts::partial:
      return Heard::mine;
    case Parts::broken:
      joint_.malformed();
      return Heard::malformed;
    case Parts::complete:
      break;
  }
  if (transfer.id.source != config().node_id || (transfer.id.service && transfer.id.request)) return Heard::foreign;
  const bool good = transfer.id.service                                  ? on_info(transfer)
                    : transfer.id.type == wire::kDronecanNodeStatus.type ? on_node_status(transfer, now)
                                                                         : on_status(transfer, now);
  if (!good) joint_.malformed();
  show();
  return good ? Heard::mine : Heard::malformed;
}

bool DronecanServo::on_status(const wire::DronecanTransfer& transfer, Time now) noexcept {
  if (options_.esc) {
    wire::DronecanEscStatus status;
    if (!decode(transfer.payload, status)) return false;
    if (status.esc_index != config().actuator_id) return true;  // another motor of the same node
    joint_.measured(now, transfer.stamp, 0, status.rpm * kRadpsPerRpm, kUnknown);
    joint_.set_temperature(status.temperature_k - 273.15);
    joint_.set_voltage(status.voltage_v);
    return true;
  }
  wire::DronecanActuatorStatus status;
  if (!decode(transfer.payload, status)) return false;
  if (status.actuator_id == config().actuator_id)
    joint_.measured(now, transfer.stamp, status.position, status.speed, status.force);
  return true;
}

bool DronecanServo::on_node_status(const wire::DronecanTransfer& transfer, Time now) noexcept {
  wire::DronecanNodeStatus status;
  if (!decode(transfer.payload, status)) return false;
  // The uptime of a restarted node goes back once. With two nodes of one id it goes back and forth, also when one has
  // just been plugged in.
  const bool ahead = heard_status_ && status.uptime_s > uptime_s_ + msg::seconds(now - status_at_) + kUptimeSlack_s;
  if (ahead) {
    joint_.looks_double(now);
    ahead_at_ = now;
  }
  if (heard_status_ && status.uptime_s < uptime_s_) {
    if (status.uptime_s > kFreshUptime_s || (ahead_at_.ns != 0 && now - ahead_at_ < kForthAndBack)) {
      joint_.looks_double(now);
    } else {  // it has begun anew, and knows nothing of us
      on_ = false;
      joint_.went_off();
      identity_ = {};
      ask_.reset();
    }
  }
  heard_status_ = true;
  uptime_s_ = status.uptime_s;
  status_at_ = now;
  const bool bad = status.health == wire::DronecanHealth::error || status.health == wire::DronecanHealth::critical;
  if (bad)
    joint_.set_drive_faults(now, msg::kJointOther, status.vendor_code);
  else if (status.mode != static_cast<std::uint8_t>(wire::DronecanMode::operational))
    joint_.set_drive_faults(now, msg::kJointOther, kModeCode | status.mode);
  else
    joint_.set_drive_faults(now, 0, 0);
  return true;
}

bool DronecanServo::on_info(const wire::DronecanTransfer& transfer) noexcept {
  wire::DronecanNodeInfo info;
  if (!decode(transfer.payload, info)) return false;
  identity_.known = true;
  identity_.revision = static_cast<std::uint32_t>(info.hardware_major << 8 | info.hardware_minor);
  identity_.serial = 0;
  for (std::size_t i = 0; i < 8; ++i) identity_.serial |= std::uint64_t{info.unique_id[i]} << (8 * i);
  const std::string_view name = info.name().substr(0, sizeof identity_.name - 1);
  std::fill(std::begin(identity_.name), std::end(identity_.name), '\0');
  std::copy(name.begin(), name.end(), identity_.name);
  return true;
}

void DronecanServo::ask_identity(Time now, FrameSink& out) noexcept {
  if (identity_.known || !heard_status_ || !ask_.due(now)) return;
  ask_.attempt(now);
  wire::DronecanId id;
  id.priority = 30, id.service = id.request = true, id.type = wire::kDronecanGetNodeInfo.type;
  id.source = node_.id(), id.destination = static_cast<std::uint8_t>(config().node_id);
  node_.send_short(id, wire::kDronecanGetNodeInfo.signature, ask_transfer_, {}, out);
  ask_transfer_ = static_cast<std::uint8_t>((ask_transfer_ + 1) & 31);
}

void DronecanServo::command(double joint_value) noexcept {
  const ServoConfig& c = config();
  const double drive = c.mode == ServoMode::position   ? joint_.to_drive_position(joint_value)
                       : c.mode == ServoMode::velocity ? joint_.to_drive_velocity(joint_value)
                                                       : joint_.to_drive_effort(joint_value);
  // An ESC takes no effort limit: derated, it turns no faster than the same part of its speed limit.
  if (!options_.esc) return node_.set_actuator(static_cast<std::uint8_t>(c.actuator_id), type_of(c.mode), drive);
  const double fastest = c.limits.velocity_radps * joint_.strength() * c.gear_ratio;
  const double raw =
      std::clamp(std::clamp(drive, -fastest, fastest) / options_.esc_full_radps, -1.0, 1.0) * wire::kDronecanEscFull;
  node_.set_esc(c.actuator_id, static_cast<std::int16_t>(std::lround(raw)));
}

/// Commands no motion, as far as the mode can. In mode position no more setpoints are sent; the device decides what it
/// does.
void DronecanServo::command_stop() noexcept {
  if (config().mode != ServoMode::position) command(0);
}

void DronecanServo::tick(Time now, const ServoCommand& wish, FrameSink& out) noexcept {
  using Intent = ServoCommand::Intent;
  if (joint_.watch(now)) {
    on_ = false;
    heard_status_ = false;
    identity_ = {};
    ask_.reset();
  }
  if (wish.request_number != request_seen_) {
    request_seen_ = wish.request_number;
    if (!options_.esc && wish.request == ServoCommand::Request::zero_here && joint_.zero_here()) joint_.resume(now);
  }
  const bool broken = joint_.idle_mode(now) == msg::JointMode::fault;
  const bool stop = wish.intent == Intent::stop;
  if (!on_ && joint_.may_enable(now, wish)) {
    joint_.begin(now);
    on_ = true;
  } else if (on_ && (wish.intent == Intent::off || broken || (stop && config().stop == StopAction::torque_off))) {
    on_ = false;
    joint_.went_off();
  }
  if (on_) node_.set_armed();
  const bool alive = joint_.feedback().measured.ns != 0 && (joint_.feedback().faults & msg::kJointLost) == 0;
  if (!on_) {
    joint_.set_mode(alive ? joint_.idle_mode(now) : msg::JointMode::absent);
    command_stop();
  } else {
    joint_.set_mode(stop ? msg::JointMode::stopping : msg::JointMode::enabled);
    const ServoJoint::Target target = stop ? joint_.held(now) : joint_.target(now, wish.setpoint);
    if (joint_.tripped()) {
      on_ = false;
      command_stop();
    } else {
      command(target.value);
    }
  }
  ask_identity(now, out);
  show();
}

void DronecanServo::show() noexcept {
  shown_ = joint_.feedback();
  if (options_.esc) shown_.position_rad = kUnknown;
}

TorqueSaid DronecanServo::torque_said(const msg::CanFrame& frame, Time now) noexcept {
  wire::DronecanTransfer transfer;
  if (assembler_.push(frame, now, node_.id(), transfer) != wire::DronecanAssembler::Heard::complete ||
      transfer.id.service || transfer.id.source != config().node_id)
    return TorqueSaid::nothing;
  constexpr std::uint8_t kPowerUnknown = 127;
  std::uint8_t power_pct = kPowerUnknown;
  if (options_.esc && transfer.id.type == wire::kDronecanEscStatus.type) {
    wire::DronecanEscStatus status;
    if (decode(transfer.payload, status) && status.esc_index == config().actuator_id) power_pct = status.power_pct;
  } else if (!options_.esc && transfer.id.type == wire::kDronecanActuatorStatus.type) {
    wire::DronecanActuatorStatus status;
    if (decode(transfer.payload, status) && status.actuator_id == config().actuator_id) power_pct = status.power_pct;
  }
  if (power_pct == kPowerUnknown) return TorqueSaid::nothing;
  return power_pct == 0 ? TorqueSaid::off : TorqueSaid::on;
}

template <class Message>
void DronecanServo::say(const wire::DronecanWanted& type, const Message& message, FrameSink& out) const noexcept {
  std::array<std::uint8_t, 40> bytes{};
  wire::DronecanId id;
  id.priority = 8, id.type = type.type, id.source = node_.id();
  wire::DronecanSplitter splitter(id, type.signature, farewell_transfer_,
                                  std::span(bytes).first(encode(message, bytes)));
  for (msg::CanFrame frame; splitter.next(frame);) out.send(frame);
}

/// "Disarmed" first: an actuator in mode position knows nothing else. Then 0, for modes that have it.
void DronecanServo::farewell(FrameSink& out) noexcept {
  const ServoConfig& c = config();
  farewell_transfer_ =
      static_cast<std::uint8_t>((farewell_transfer_ + 1) & 31);  // a transfer id that it knows is ignored
  say(wire::kDronecanArmingStatus, wire::DronecanArmingStatus{}, out);
  if (options_.esc) {
    // RawCommand of zeros up to this index: the ESCs before it stop, too, as all shall when the hub ends.
    wire::DronecanEscRawCommand zeros;
    zeros.count = static_cast<std::uint8_t>(c.actuator_id + 1);
    say(wire::kDronecanEscRawCommand, zeros, out);
  } else if (c.mode != ServoMode::position) {
    wire::DronecanActuatorCommand zero;
    zero.count = 1;
    zero.command[0] = {static_cast<std::uint8_t>(c.actuator_id), static_cast<std::uint8_t>(type_of(c.mode)), 0.0};
    say(wire::kDronecanActuatorCommand, zero, out);
  }
}

}  // namespace sinew::drivers
