// How a CiA 402 drive is run once it is operational.
#include "drivers/joints/cia402_servo.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace sinew::drivers {

using namespace std::chrono_literals;
using wire::DriveGoal;
using wire::DriveState;

namespace {

/// To an integer object: rounded, pulled into its range; NaN becomes 0.
template <class T>
T to_integer(double value) {
  constexpr auto low = static_cast<double>(std::numeric_limits<T>::min());
  constexpr auto high = static_cast<double>(std::numeric_limits<T>::max());
  if (std::isnan(value)) return 0;
  return static_cast<T>(std::lround(value < low ? low : value > high ? high : value));
}

constexpr std::uint32_t kFramesWindow = 20;  // ticks over which frames are counted to find a second drive

}  // namespace

Heard Cia402Servo::on_frame(const msg::CanFrame& frame, Time now) noexcept {
  Heard heard = Heard::foreign;
  switch (const wire::CanopenId id = wire::canopen_id(frame.id); id.kind) {
    case wire::CanopenKind::tpdo:
      heard = id.number == 1 ? on_tpdo1(frame, now) : on_tpdo2(frame);
      break;
    case wire::CanopenKind::heartbeat:
      heard = on_heartbeat(frame, now);
      break;
    case wire::CanopenKind::emergency:
      heard = on_emergency(frame);
      break;
    case wire::CanopenKind::sdo_reply:
      heard = sdo_.on_reply(frame);
      if (sdo_.answered_twice()) joint_.looks_double(now);
      break;
    default:
      break;
  }
  if (heard == Heard::malformed) joint_.malformed();
  return heard;
}

Heard Cia402Servo::on_tpdo1(const msg::CanFrame& frame, Time now) noexcept {
  if (!wire::is_data(frame, false) || frame.size != 8) return Heard::malformed;
  if (phase_ != Phase::running && phase_ != Phase::starting) return Heard::foreign;  // from before it was configured
  const auto status = wire::get_le<std::uint16_t>(frame, 0);
  const auto state = wire::drive_state(status);
  if (!state) return Heard::malformed;
  const double turns = wire::get_le<std::int32_t>(frame, 2) / config().counts_per_turn;
  const double effort = wire::get_le<std::int16_t>(frame, 6) * 1e-3 * rated_nm();
  heard_ = true;
  ++tpdos_;
  if (!joint_.measured(now, frame.stamp, turns * 2 * std::numbers::pi, kUnknown, effort)) return Heard::mine;
  status_ = status;
  state_ = *state;
  if (phase_ == Phase::starting) {
    phase_ = Phase::running;
    retry_.reset();
  }
  return Heard::mine;
}

Heard Cia402Servo::on_tpdo2(const msg::CanFrame& frame) noexcept {
  if (phase_ != Phase::running) return Heard::foreign;
  if (!wire::is_data(frame, false) || frame.size != (tells_voltage_ ? 8 : 4)) return Heard::malformed;
  joint_.set_velocity(wire::get_le<std::int32_t>(frame, 0) * velocity_unit());
  if (tells_voltage_) joint_.set_voltage(wire::get_le<std::uint32_t>(frame, 4) * 1e-3);
  return Heard::mine;
}

Heard Cia402Servo::on_heartbeat(const msg::CanFrame& frame, Time now) noexcept {
  const auto nmt = wire::decode_heartbeat(frame);
  if (!nmt) return Heard::malformed;
  const bool first = last_heartbeat_.ns == 0 || now - last_heartbeat_ > 1s;
  last_heartbeat_ = now;
  const bool begins = *nmt == wire::NmtState::boot_up;
  if (begins || (phase_ == Phase::running && *nmt != wire::NmtState::operational)) {  // or somebody stopped it
    if (wants_) joint_.trip(now, msg::kJointOther);
    if (phase_ != Phase::absent) give_up();
    if (begins) homed_before_ = false;  // from power-up or a reset
  }
  if (begins || first) retry_.reset();  // it is there: no need to wait for the next attempt
  return Heard::mine;
}

Heard Cia402Servo::on_emergency(const msg::CanFrame& frame) noexcept {
  const auto emergency = wire::decode_emergency(frame);
  if (!emergency) return Heard::malformed;
  if (emergency->code != 0) error_code_ = emergency->code;  // the statusword says "no error", too
  return Heard::mine;
}

void Cia402Servo::tick(Time now, const ServoCommand& command, FrameSink& out) noexcept {
  if (joint_.watch(now)) drop();
  if (phase_ != Phase::running) {
    (void)joint_.may_enable(now, command);  // commands from now count as old when it is back
    bring_up(now, out);
    heard_ = false;
    return;
  }
  run(now, command, out);
}

void Cia402Servo::run(Time now, const ServoCommand& command, FrameSink& out) noexcept {
  count_cycle(now);
  sdo_.tick(now, out);
  home(now, command);
  decide(now, command);
  aim(now, command);
  note_state(now, command.intent == ServoCommand::Intent::stop);
  control_ = controlword(now);
  send_rpdo(out);
  poll_temperature(now, out);
}

void Cia402Servo::count_cycle(Time now) noexcept {
  if (!heard_) joint_.missed();
  heard_ = false;
  if (++ticks_ < kFramesWindow) return;
  if (tpdos_ > kFramesWindow * 3 / 2) joint_.looks_double(now);
  ticks_ = tpdos_ = 0;
}

void Cia402Servo::decide(Time now, const ServoCommand& command) noexcept {
  using Intent = ServoCommand::Intent;
  if (command.intent == Intent::off) quick_ = false;  // a disarm does not wait for a ramp
  const bool broken = joint_.tripped() || joint_.idle_mode(now) == msg::JointMode::fault;
  if (!wants_) {
    if (!joint_.may_enable(now, command) || state_ == DriveState::fault || quick_ || homing_ != Homing::no) return;
    joint_.begin(now);
    wants_ = true;
    was_enabled_ = false;
    deadline_ = now + 1s;
    return;
  }
  const bool holds = config().stop == StopAction::hold && homing_ == Homing::no;  // homing would go on without a lease
  const bool stop = command.intent == Intent::stop && !holds;
  if (command.intent != Intent::off && !stop && !broken) return;
  quick_ = command.intent == Intent::stop && config().stop == StopAction::quick_stop && was_enabled_ && !broken;
  wants_ = was_enabled_ = false;
  end_homing();
  deadline_ = now + 2s;
  joint_.went_off();
}

void Cia402Servo::aim(Time now, const ServoCommand& command) noexcept {
  ServoJoint::Target target;
  if (wants_ && was_enabled_ && homing_ == Homing::no && homed()) {
    target = command.intent == ServoCommand::Intent::follow ? joint_.target(now, command.setpoint) : joint_.held(now);
    if (joint_.tripped()) wants_ = was_enabled_ = false;
  } else {
    joint_.resume(now);
    target = joint_.held(now);
  }
  switch (config().mode) {
    case ServoMode::position:
      target_ = to_integer<std::int32_t>(joint_.to_drive_position(target.value) / (2 * std::numbers::pi) *
                                         config().counts_per_turn);
      break;
    case ServoMode::velocity:
      target_ = to_integer<std::int32_t>(joint_.to_drive_velocity(target.value) / velocity_unit());
      break;
    case ServoMode::effort:
      target_ = to_integer<std::int16_t>(joint_.to_drive_effort(target.value) / rated_nm() * 1000);
      break;
  }
  if (!limits_effort()) return;
  const double most = std::abs(joint_.to_drive_effort(target.effort_limit_nm)) / rated_nm() * 1000;
  torque_limit_ = to_integer<std::uint16_t>(most);
}

void Cia402Servo::note_state(Time now, bool holding) noexcept {
  const bool fault = state_ == DriveState::fault || state_ == DriveState::fault_reaction;
  if (fault) {
    const std::uint32_t faults = wire::joint_faults(error_code_);
    joint_.set_drive_faults(now, faults != 0 ? faults : std::uint32_t{msg::kJointOther}, error_code_);
  } else {
    joint_.set_drive_faults(now, 0, 0);
  }
  const bool on = state_ == DriveState::operation_enabled;
  if (wants_ && !on && (was_enabled_ || now > deadline_ || fault)) {
    if (!fault) joint_.trip(now, msg::kJointOther);  // it went off by itself, or did not come on
    wants_ = was_enabled_ = false;
    end_homing();
    joint_.went_off();
  }
  if (wants_ && on) was_enabled_ = true;
  if (joint_.runs_well(now)) fault_reset_.reset();
  if (quick_ && (now > deadline_ || (!on && state_ != DriveState::quick_stop_active))) quick_ = false;
  msg::JointMode mode = joint_.idle_mode(now);
  if (wants_) {
    mode = !was_enabled_                       ? msg::JointMode::enabling
           : homing_ != Homing::no || !homed() ? msg::JointMode::homing
           : holding                           ? msg::JointMode::stopping
                                               : msg::JointMode::enabled;
  } else if (quick_ || (on && mode != msg::JointMode::fault)) {
    mode = msg::JointMode::stopping;
  }
  joint_.set_mode(mode);
}

std::uint16_t Cia402Servo::controlword(Time now) noexcept {
  if (state_ == DriveState::fault) {
    if (control_ != 0 || !fault_reset_.due(now)) return 0;  // the reset is an edge
    fault_reset_.attempt(now);
    ++joint_.stats().restarts;
    return wire::kControlFaultReset;
  }
  const DriveGoal goal = quick_ ? DriveGoal::quick_stop : wants_ ? DriveGoal::enabled : DriveGoal::off;
  const bool homes = homing_ == Homing::moving && was_enabled_;
  return homes ? wire::kControlHomingStart : wire::next_controlword(state_, goal);
}

void Cia402Servo::send_rpdo(FrameSink& out) noexcept {
  const bool torque = config().mode == ServoMode::effort;
  const std::uint8_t size = torque ? 4 : 6;
  msg::CanFrame frame =
      wire::can_frame(wire::rpdo_id(1, config().node_id), limits_effort() ? static_cast<std::uint8_t>(size + 2) : size);
  wire::put_le(frame, 0, control_);
  if (torque) {
    wire::put_le(frame, 2, static_cast<std::int16_t>(target_));
  } else {
    wire::put_le(frame, 2, target_);
  }
  if (limits_effort()) wire::put_le(frame, size, torque_limit_);
  out.send(frame);
}

void Cia402Servo::poll_temperature(Time now, FrameSink& out) noexcept {
  if (options_.temperature_object.index == 0 || homing_ != Homing::no) return;
  if (reading_temperature_) {
    if (sdo_.state() == SdoClient::State::busy) return;
    if (sdo_.state() == SdoClient::State::done) {
      joint_.set_temperature(sdo_.signed_value() * options_.temperature_unit_c);
    }
    reading_temperature_ = false;  // not answered: the next time
    next_temperature_ = now + 1s;
    return;
  }
  if (now < next_temperature_) return;
  sdo_.start(wire::sdo_read(options_.temperature_object));
  sdo_.tick(now, out);
  reading_temperature_ = true;
}

void Cia402Servo::farewell(FrameSink& out) noexcept {
  control_ = 0;
  send_rpdo(out);
  out.send(wire::encode_sdo_request(config().node_id, wire::sdo_write(wire::kControlword, 0, 2)));
  out.send(wire::encode_nmt(wire::NmtCommand::pre_operational, config().node_id));
}

void Cia402Servo::ask_torque(FrameSink& out) noexcept {
  out.send(wire::encode_sdo_request(config().node_id, wire::sdo_read(wire::kStatusword)));
}

void Cia402Servo::insist(FrameSink& out) noexcept {
  out.send(wire::encode_nmt(wire::NmtCommand::stop, config().node_id));
}

TorqueSaid Cia402Servo::torque_said(const msg::CanFrame& frame, Time /*now*/) noexcept {
  std::optional<DriveState> state;
  if (frame.id == wire::sdo_reply_id(config().node_id)) {
    const auto reply = wire::decode_sdo_reply(frame);
    if (reply && reply->kind == wire::Sdo::Kind::value && reply->object == wire::kStatusword)
      state = wire::drive_state(static_cast<std::uint16_t>(reply->value()));
  } else if (frame.id == wire::tpdo_id(1, config().node_id) && wire::is_data(frame, false) && frame.size == 8) {
    state = wire::drive_state(wire::get_le<std::uint16_t>(frame, 0));
  }
  if (!state) return TorqueSaid::nothing;
  const bool on = *state == DriveState::operation_enabled || *state == DriveState::quick_stop_active ||
                  *state == DriveState::fault_reaction;
  return on ? TorqueSaid::on : TorqueSaid::off;
}

}  // namespace sinew::drivers
