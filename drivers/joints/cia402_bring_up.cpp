// How a CiA 402 drive is found, configured and started.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "drivers/joints/cia402_servo.hpp"

namespace sinew::drivers {

using namespace std::chrono_literals;
using wire::ObjectAddress;

wire::DriveMode Cia402Servo::mode_of(ServoMode mode) {
  return mode == ServoMode::position   ? wire::DriveMode::cyclic_position
         : mode == ServoMode::velocity ? wire::DriveMode::cyclic_velocity
                                       : wire::DriveMode::cyclic_torque;
}

namespace {

/// 60C2h: `value` * 10^`exponent` seconds. Nothing: it cannot hold this cycle, and the drive would drift against SYNC.
struct CycleTime {
  std::uint8_t value = 0;
  std::int8_t exponent = 0;
};
std::optional<CycleTime> cycle_time(double tick_hz) {
  for (const int exponent : {-4, -3, -5, -6, -2, -1, 0}) {
    const double value = std::pow(10, -exponent) / tick_hz, whole = std::round(value);
    if (whole < 1 || whole > 255 || std::abs(value - whole) > 1e-9 * whole) continue;
    return CycleTime{static_cast<std::uint8_t>(whole), static_cast<std::int8_t>(exponent)};
  }
  return std::nullopt;
}

}  // namespace

bool is_homing_method(int method) noexcept {
  return (method >= -128 && method <= 14) || (method >= 17 && method <= 30) || (method >= 33 && method <= 35) ||
         method == 37;
}

WrongKeys check_cia402(const ServoConfig& c, const Cia402Options& o) {
  WrongKeys wrong = check_servo(c);
  if (c.node_id < 1 || c.node_id > wire::kMaxCanopenNode) wrong.push_back({"id", "an integer from 1 to 127"});
  if (c.node_id == o.master_node) wrong.push_back({"id", "another number than the bus's master_node"});
  if (o.master_node < 1 || o.master_node > wire::kMaxCanopenNode)
    wrong.push_back({"bus.master_node", "an integer from 1 to 127"});
  if (c.stop == StopAction::damp)
    wrong.push_back({"on_stop", "\"torque_off\", \"quick_stop\" or \"hold\"; CiA 402 has no damp"});
  if (c.stop == StopAction::hold && c.mode == ServoMode::effort)
    wrong.push_back({"on_stop", "\"torque_off\" or \"quick_stop\"; an effort cannot hold a position"});
  if (!(c.counts_per_turn > 0)) wrong.push_back({"counts_per_turn", "a number above 0; it is required"});
  if (!(c.rated_effort_nm >= 0)) wrong.push_back({"rated_effort_nm", "a number not below 0"});
  if (o.slow_every < 1 || o.slow_every > 240) wrong.push_back({"slow_every", "an integer from 1 to 240"});
  if (c.device_timeout > 65s) wrong.push_back({"device_timeout_ms", "at most 65000"});
  if (!is_homing_method(c.homing_method)) wrong.push_back({"homing_method", std::string(kHomingMethods)});
  if (!(o.tick_hz > 0) || o.tick_hz > 4000)
    wrong.push_back({"bus.tick_hz", "a number above 0, at most 4000"});
  else if (!cycle_time(o.tick_hz))
    wrong.push_back({"bus.tick_hz",
                     "with cia402 on it a rate whose period 60C2h holds, 1 to 255 times a power of ten "
                     "seconds: 100, 125, 200, 250, 400, 500, 800, 1000, 2000 and such"});
  return wrong;
}

BusNeed CanopenMaster::need(double tick_hz) const {
  BusNeed need;
  need.add(wire::encode_sync(), tick_hz);
  need.add(wire::encode_heartbeat(1, wire::NmtState::operational), 1 / msg::seconds(options_.heartbeat));
  return need;
}

void CanopenMaster::end(Time now, FrameSink& out) noexcept {
  out.send(wire::encode_sync());
  if (now < next_heartbeat_) return;
  out.send(wire::encode_heartbeat(options_.node_id, wire::NmtState::operational));
  next_heartbeat_ = now + options_.heartbeat;
}

Cia402Servo::Cia402Servo(const ServoConfig& config, const Cia402Options& options)
    : options_(options), joint_(config), sdo_(config.node_id) {
  const std::uint32_t node = config.node_id;
  for (const std::uint32_t id : {wire::tpdo_id(1, node), wire::tpdo_id(2, node), wire::heartbeat_id(node),
                                 wire::emergency_id(node), wire::sdo_reply_id(node)}) {
    interests_.push_back({id, 0x7FF, false});
  }
  plan();
}

BusNeed Cia402Servo::need(double tick_hz) const {
  BusNeed need;
  const msg::CanFrame full = wire::can_frame(0, 8);
  need.add(full, 2 * tick_hz);                    // RPDO1, TPDO1
  need.add(full, tick_hz / options_.slow_every);  // TPDO2
  need.add(wire::encode_heartbeat(1, wire::NmtState::operational), 10);
  if (options_.temperature_object.index != 0) need.add(full, 2);
  return need;
}

void Cia402Servo::read(ObjectAddress object, std::uint32_t* into, bool optional) {
  steps_.push_back({wire::sdo_read(object), optional, into});
}
void Cia402Servo::write(ObjectAddress object, std::uint32_t value, std::uint8_t bytes, bool optional) {
  steps_.push_back({wire::sdo_write(object, value, bytes), optional, nullptr});
}

/// A PDO is switched off, mapped anew, and switched on (CiA 301, 7.5.2.36 and 7.5.2.38).
void Cia402Servo::plan_pdo(bool transmit, std::uint32_t number, std::uint32_t type,
                           std::span<const std::uint32_t> entries, bool last_is_optional) {
  const std::uint32_t node = config().node_id;
  const std::uint32_t id = transmit ? wire::tpdo_id(number, node) : wire::rpdo_id(number, node);
  const auto communication = transmit ? wire::tpdo_communication : wire::rpdo_communication;
  const auto mapping = transmit ? wire::tpdo_mapping : wire::rpdo_mapping;
  write(communication(number, 1), wire::kPdoInvalid | id, 4);
  write(mapping(number, 0), 0, 1);
  std::uint8_t sub = 0;
  for (const std::uint32_t entry : entries) write(mapping(number, ++sub), entry, 4);
  if (last_is_optional) steps_.back().optional = true, steps_.back().entry = sub;
  write(mapping(number, 0), sub, 1);
  write(communication(number, 2), type, 1);
  write(communication(number, 1), id, 4);
}

void Cia402Servo::plan() {
  const ServoConfig& c = config();
  read(wire::kVendorId, &identity_.vendor, false);
  read(wire::kProductCode, &identity_.product);
  read(wire::kRevision, &identity_.revision);
  read(wire::kSerialNumber, &serial_);
  read(wire::kDeviceName, nullptr);
  read(wire::kHeartbeatProducer, &mark_read_);
  if (c.rated_effort_nm <= 0) read(wire::kRatedTorque, &rated_mnm_, false);
  write(wire::kControlword, 0, 2);
  const std::uint32_t target = c.mode == ServoMode::position   ? wire::mapped(wire::kTargetPosition, 32)
                               : c.mode == ServoMode::velocity ? wire::mapped(wire::kTargetVelocity, 32)
                                                               : wire::mapped(wire::kTargetTorque, 16);
  const std::uint32_t rpdo1[] = {wire::mapped(wire::kControlword, 16), target, wire::mapped(wire::kMaxTorque, 16)};
  const std::size_t rpdo1_entries = limits_effort() ? 3 : 2;
  const std::uint32_t tpdo1[] = {wire::mapped(wire::kStatusword, 16), wire::mapped(wire::kActualPosition, 32),
                                 wire::mapped(wire::kActualTorque, 16)};
  const std::uint32_t tpdo2[] = {wire::mapped(wire::kActualVelocity, 32), wire::mapped(wire::kDcLinkVoltage, 32)};
  plan_pdo(false, 1, 1, std::span(rpdo1).first(rpdo1_entries));
  plan_pdo(true, 1, 1, tpdo1);
  plan_pdo(true, 2, options_.slow_every, tpdo2, true);  // 6079h is optional, CiA 402-2
  mark_step_ = steps_.size();
  write(wire::kHeartbeatProducer, kHeartbeatMs, 2, true);
  if (c.device_timeout > 0ns) {
    const auto ms = static_cast<std::uint32_t>((c.device_timeout + 999'999ns) / 1ms);
    write(wire::kHeartbeatConsumer, options_.master_node << 16 | ms, 4);
    const std::uint32_t reaction = c.stop == StopAction::torque_off ? 2 : 3;  // 6007h: disable voltage, quick stop
    write(wire::kAbortOption, reaction, 2, true);
  }
  write(wire::kQuickStopOption, 2, 2, true);  // slows down on the quick stop ramp, then off
  write(wire::kModeOfOperation, static_cast<std::uint8_t>(mode_of(c.mode)), 1);
  const auto cycle = cycle_time(options_.tick_hz).value_or(CycleTime{});  // else check_cia402() has said so
  write(wire::kInterpolationTime, cycle.value, 1, true);
  write(wire::kInterpolationExponent, static_cast<std::uint8_t>(cycle.exponent), 1, true);
}

void Cia402Servo::bring_up(Time now, FrameSink& out) noexcept {
  if (phase_ == Phase::absent) {
    if (!retry_.due(now)) return;
    retry_.attempt(now);
    ++joint_.stats().restarts;
    out.send(wire::encode_nmt(wire::NmtCommand::pre_operational, config().node_id));  // PDOs are mapped there only
    step_ = 0;
    mark_read_ = 0;
    const auto mark = static_cast<std::uint32_t>(kHeartbeatMs + joint_.stats().restarts % kMarks);
    steps_[mark_step_].request.set_value(mark, 2);
    sdo_.start(steps_[0].request);
    sdo_.tick(now, out);
    phase_ = Phase::configuring;
    return;
  }
  if (phase_ == Phase::starting) {
    if (now > deadline_) give_up();
    return;
  }
  next_step(now, out);
}

void Cia402Servo::next_step(Time now, FrameSink& out) noexcept {
  switch (sdo_.state()) {
    case SdoClient::State::timeout:
      give_up();
      return;
    case SdoClient::State::aborted:
      if (!steps_[step_].optional) {
        joint_.set_drive_faults(now, msg::kJointOther, sdo_.abort_code());
        give_up();
        joint_.set_mode(msg::JointMode::fault);
        return;
      }
      if (step_ == mark_step_) homed_before_ = false, mark_ = 0;  // it takes no mark: a loss of power is not seen
      note_entry(false);
      ++step_;
      break;
    case SdoClient::State::done:
      note_entry(true);
      finish_step();
      break;
    default:
      sdo_.tick(now, out);
      return;
  }
  if (step_ < steps_.size()) {
    sdo_.start(steps_[step_].request);
    sdo_.tick(now, out);
    return;
  }
  sdo_.reset();
  if (!(rated_nm() > 0)) {  // per mille of an unknown torque mean nothing
    joint_.set_drive_faults(now, msg::kJointOther, wire::kRatedTorque.index);
    give_up();
    joint_.set_mode(msg::JointMode::fault);
    return;
  }
  identity_.serial = serial_;
  homed_ = homed_before_;
  homed_before_ = false;
  joint_.set_drive_faults(now, 0, 0);
  out.send(wire::encode_nmt(wire::NmtCommand::start, config().node_id));
  phase_ = Phase::starting;
  deadline_ = now + 1s;
}

void Cia402Servo::note_entry(bool mapped) noexcept {
  const std::uint8_t entry = steps_[step_].entry;
  if (entry == 0) return;
  tells_voltage_ = mapped;
  steps_[step_ + 1].request.set_value(mapped ? entry : entry - 1u, 1);
}

void Cia402Servo::finish_step() noexcept {
  const Step& step = steps_[step_++];
  if (step.into != nullptr) *step.into = sdo_.value();
  if (step_ == mark_step_ + 1) {
    // By now every sign of a lost power has been looked at: a drive that still has our mark has had power since we set
    // it.
    homed_before_ = homed_before_ && mark_ != 0 && mark_read_ == mark_;
    mark_ = step.request.value();
  }
  if (step.request.object == wire::kDeviceName) {
    const std::string_view name = sdo_.text();
    const std::size_t size = std::min(name.size(), sizeof identity_.name - 1);
    for (std::size_t i = 0; i < size; ++i) {  // control characters stay out of terminals
      identity_.name[i] = name[i] >= ' ' && name[i] <= '~' ? name[i] : '?';
    }
    identity_.name[size] = 0;
  }
  identity_.known = true;
  joint_.set_mode(joint_.feedback().faults != 0 ? msg::JointMode::fault : msg::JointMode::disabled);
}

void Cia402Servo::give_up() noexcept {
  drop();
  joint_.set_mode(msg::JointMode::absent);
}

void Cia402Servo::drop() noexcept {
  phase_ = Phase::absent;
  sdo_.reset();
  reading_temperature_ = false;
  wants_ = was_enabled_ = quick_ = false;
  control_ = 0;
  state_ = wire::DriveState::not_ready;
  error_code_ = 0;
  homing_ = Homing::no;
  homed_before_ = homed_before_ || homed_;  // bringing it up tells whether it has been without power
  homed_ = false;
  tpdos_ = ticks_ = 0;
  joint_.went_off();
  joint_.forget_position();
}

double Cia402Servo::rated_nm() const noexcept {
  return config().rated_effort_nm > 0 ? config().rated_effort_nm : rated_mnm_ / 1000.0;
}

bool Cia402Servo::limits_effort() const noexcept { return std::isfinite(config().limits.effort_nm); }

double Cia402Servo::velocity_unit() const noexcept {
  return options_.velocity_unit_radps > 0 ? options_.velocity_unit_radps
                                          : 2 * std::numbers::pi / config().counts_per_turn;
}

}  // namespace sinew::drivers
