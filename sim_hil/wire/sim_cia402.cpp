#include "sim_hil/wire/sim_cia402.hpp"

#include <numbers>

namespace sinew::sim_hil {

using namespace std::chrono_literals;
using wire::DriveState;

namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr Duration kHeartbeatAtLeast = 1ms;

std::uint32_t bits(double value) { return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(value))); }
double clamp(double v, double most) { return v > most ? most : v < -most ? -most : v; }

}  // namespace

SimCia402::SimCia402(hal::CanBus& bus, SimJoint& joint, const SimMount& mount, const Parameters& parameters)
    : SimServo(bus, joint, mount), p_(parameters) {
  SimCia402::on_power();
}

void SimCia402::measure() {
  set(wire::kActualPosition, bits((drive_position() - zero_) / kTurn * p_.counts_per_turn));
  set(wire::kActualVelocity, bits(drive_velocity() / kTurn * p_.counts_per_turn));
  set(wire::kActualTorque, bits(drive_effort() / p_.rated_nm * 1000) & 0xFFFF);
  set(wire::kDcLinkVoltage, bits(voltage_v * 1000));
  set(kTemperature, bits(temperature_c * 10) & 0xFFFF);
  set(wire::kModeDisplay, object(wire::kModeOfOperation));
  set(wire::kStatusword, wire::state_bits(state_) | wire::kStatusVoltage | wire::kStatusRemote | extra_status_);
}

// ---- what the drive hears ----

void SimCia402::on_frame(const msg::CanFrame& frame, Time now) {
  const wire::CanopenId id = wire::canopen_id(frame.id);
  if (frame.extended()) return;
  now_ = now;
  if (const auto nmt = wire::decode_nmt(frame)) {
    if (nmt->node == 0 || nmt->node == p_.node_id) on_nmt(*nmt);
  } else if (id.kind == wire::CanopenKind::sync) {
    on_sync();
  } else if (id.kind == wire::CanopenKind::sdo_request && id.node == p_.node_id) {
    if (const auto sdo = wire::decode_sdo_request(frame)) on_sdo(*sdo);
  } else if (id.kind == wire::CanopenKind::rpdo && id.node == p_.node_id) {
    on_rpdo(frame, id.number);
  } else if (id.kind == wire::CanopenKind::heartbeat && id.node == object(wire::kHeartbeatConsumer) >> 16) {
    master_heard_ = now;
    master_watched_ = true;  // from the first one on, CiA 301, 7.2.8.3.2.2
  }
}

void SimCia402::on_nmt(const wire::Nmt& nmt) {
  switch (nmt.command) {
    case wire::NmtCommand::start:
      nmt_ = wire::NmtState::operational;
      break;
    case wire::NmtCommand::stop:
      nmt_ = wire::NmtState::stopped;
      lose_connection();
      break;
    case wire::NmtCommand::pre_operational:
      nmt_ = wire::NmtState::pre_operational;
      break;
    default:
      on_power();  // says its boot-up message again
  }
}

void SimCia402::on_rpdo(const msg::CanFrame& frame, std::uint32_t number) {
  if (nmt_ != wire::NmtState::operational || number > 2) return;
  if ((object(wire::rpdo_communication(number, 1)) & wire::kPdoInvalid) != 0) return;
  std::size_t at = 0;
  bool control = false;
  for (std::uint8_t sub = 1; sub <= object(wire::rpdo_mapping(number, 0)); ++sub) {
    const std::uint32_t entry = object(wire::rpdo_mapping(number, sub));
    const std::size_t bytes = (entry & 0xFF) / 8;
    if (at + bytes > frame.size) return;  // too short: CiA 301 has an EMCY for it
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value |= std::uint32_t{frame.data[at + i]} << (8 * i);
    objects_[entry >> 8].value = value;
    control = control || entry >> 8 == key(wire::kControlword);
    at += bytes;
  }
  if (control) on_controlword();  // at once, not with the next SYNC, which follows anyway
}

void SimCia402::on_sync() {
  if (nmt_ != wire::NmtState::operational) return;
  ++syncs_;
  for (std::uint32_t number = 1; number <= 2; ++number) {
    const std::uint32_t type = object(wire::tpdo_communication(number, 2));
    const bool exists = (object(wire::tpdo_communication(number, 1)) & wire::kPdoInvalid) == 0;
    if (exists && type >= 1 && type <= 240 && syncs_ % type == 0) send_tpdo(number);
  }
}

void SimCia402::send_tpdo(std::uint32_t number) {
  measure();
  msg::CanFrame frame = wire::can_frame(object(wire::tpdo_communication(number, 1)) & 0x7FF, 0);
  for (std::uint8_t sub = 1; sub <= object(wire::tpdo_mapping(number, 0)); ++sub) {
    const std::uint32_t entry = object(wire::tpdo_mapping(number, sub));
    const std::size_t bytes = (entry & 0xFF) / 8;
    const std::uint32_t value = objects_[entry >> 8].value;
    for (std::size_t i = 0; i < bytes && frame.size < 8; ++i) {
      frame.data[frame.size++] = static_cast<std::uint8_t>(value >> (8 * i));
    }
  }
  send(frame);
}

// ---- what the drive does ----

void SimCia402::on_controlword() {
  if (deaf) return;
  const auto word = static_cast<std::uint16_t>(object(wire::kControlword));
  const DriveState before = state_;
  state_ = next_state(state_, word, control_before_);
  if (state_ == DriveState::quick_stop_active && before != state_) quick_ = true;
  if (before == DriveState::fault && state_ != before) {
    if (fault_stays || temperature_c > p_.hot_c) {
      enter_fault(static_cast<std::uint16_t>(stays_code_));
    } else {
      set(wire::kErrorCode, 0);
      set(wire::kErrorRegister, 0);
      send(wire::encode_emergency(p_.node_id, {}));
    }
  }
  if (state_ != DriveState::operation_enabled && state_ != DriveState::quick_stop_active) quick_ = homing_ = false;
  const bool start = (word & 0x10) != 0 && (control_before_ & 0x10) == 0;
  if (state_ == DriveState::operation_enabled && start && object(wire::kModeOfOperation) == 6) {
    homing_ = true;
    extra_status_ = 0;
  }
  control_before_ = word;
}

void SimCia402::fail(std::uint32_t code) { enter_fault(static_cast<std::uint16_t>(code)); }

void SimCia402::enter_fault(std::uint16_t code) {
  state_ = DriveState::fault;
  quick_ = homing_ = false;
  stays_code_ = code;
  set(wire::kErrorCode, code);
  set(wire::kErrorRegister, 1);
  if (nmt_ != wire::NmtState::boot_up) send(wire::encode_emergency(p_.node_id, {code, 1, {}}));
}

double SimCia402::position_target() const {
  return static_cast<std::int32_t>(object(wire::kTargetPosition)) / p_.counts_per_turn * kTurn + zero_;
}

double SimCia402::home(Time) {
  const double error = p_.home_rad - drive_position();
  if (std::abs(error) < 0.01 && std::abs(drive_velocity()) < 0.1) {
    homing_ = false;
    zero_ = p_.home_rad;
    extra_status_ = wire::kStatusHomed | 1 << 10;
  }
  return p_.kp * clamp(error, 0.05) - p_.kd * drive_velocity();
}

double SimCia402::control(Time now, Duration) {
  const double most = object(wire::kMaxTorque) * 1e-3 * p_.rated_nm;
  if (quick_) {
    if (std::abs(drive_velocity()) > 0.02) return clamp(-p_.kd * drive_velocity(), most);
    quick_ = false;
    state_ = DriveState::switch_on_disabled;  // 605Ah = 2
  }
  if (state_ != DriveState::operation_enabled) return 0;
  if (temperature_c > p_.hot_c) {
    enter_fault(0x4310);
    return 0;
  }
  switch (static_cast<wire::DriveMode>(object(wire::kModeOfOperation))) {
    case wire::DriveMode::homing:
      return homing_ ? clamp(home(now), most) : clamp(-p_.kd * drive_velocity(), most);
    case wire::DriveMode::cyclic_position:
      return clamp(p_.kp * (position_target() - drive_position()) - p_.kd * drive_velocity(), most);
    case wire::DriveMode::cyclic_velocity: {
      const double target = static_cast<std::int32_t>(object(wire::kTargetVelocity)) / p_.counts_per_turn * kTurn;
      return clamp(p_.kd * (target - drive_velocity()), most);
    }
    case wire::DriveMode::cyclic_torque:
      return clamp(static_cast<std::int16_t>(object(wire::kTargetTorque)) * 1e-3 * p_.rated_nm, most);
    default:
      return 0;
  }
}

void SimCia402::watch_master(Time now) {
  const Duration patience = std::chrono::milliseconds(object(wire::kHeartbeatConsumer) & 0xFFFF);
  if (!master_watched_ || patience.count() == 0 || now - master_heard_ <= patience) return;
  master_watched_ = false;
  send(wire::encode_emergency(p_.node_id, {0x8130, 0x10, {}}));
  lose_connection();
}

/// 6007h: the drive's reaction when its master is gone, and in NMT stopped.
void SimCia402::lose_connection() {
  const bool on = state_ == DriveState::operation_enabled;
  switch (object(wire::kAbortOption)) {
    case 1:
      enter_fault(0x8130);
      break;
    case 2:
      if (on) state_ = DriveState::switch_on_disabled;
      break;
    case 3:
      if (on) state_ = DriveState::quick_stop_active, quick_ = true;
      break;
    default:
      break;
  }
}

void SimCia402::say(Time now) {
  if (nmt_ == wire::NmtState::boot_up) {
    send(encode_heartbeat(p_.node_id, wire::NmtState::boot_up));
    nmt_ = wire::NmtState::pre_operational;
  }
  watch_master(now);
  const Duration every = std::chrono::milliseconds(object(wire::kHeartbeatProducer));
  if (every < kHeartbeatAtLeast || now < next_heartbeat_) return;
  next_heartbeat_ = now + every;
  send(encode_heartbeat(p_.node_id, nmt_));
}

}  // namespace sinew::sim_hil
