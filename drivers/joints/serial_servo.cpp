#include "drivers/joints/serial_servo.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::drivers {
namespace {

using namespace std::chrono_literals;
using wire::DxlVersion;

constexpr std::int32_t kWatchdogMost = 127, kWatchdogTripped = 0xFF;  // counts; then goals are refused until it is 0
constexpr std::uint32_t kRefused = 0x100;  // a fault code of ours: the servo's error number is added
constexpr std::uint8_t kHealthMost = 8;    // bytes: further apart, torque and hardware error are not read together

double watchdog_s(const wire::ServoModel& m) { return m.seconds_per_watchdog; }

std::int32_t watchdog_count(const wire::ServoModel& m, Duration timeout) {
  return static_cast<std::int32_t>(std::ceil(msg::seconds(timeout) / watchdog_s(m) - 1e-9));
}

}  // namespace

WrongKeys check_serial_servo(const ServoConfig& c, const SerialServoOptions& o) {
  WrongKeys wrong = check_servo(c);
  const wire::ServoModel& m = *o.model;
  const std::uint8_t most_id = wire::dxl_most_id(m.version);
  if (c.node_id > most_id) wrong.push_back({"id", "an integer from 0 to " + std::to_string(most_id)});
  if (c.mode == ServoMode::velocity && !m.operating_mode)
    wrong.push_back(
        {"mode", "\"position\"; " + std::string(m.title) + " has no velocity mode that keeps its position"});
  if (c.mode == ServoMode::effort && !m.has_effort_mode)
    wrong.push_back({"mode", "\"position\"" + std::string(m.operating_mode ? " or \"velocity\"" : "") + "; " +
                                 std::string(m.title) + " measures no current"});
  if (c.stop == StopAction::damp || c.stop == StopAction::quick_stop)
    wrong.push_back({"on_stop", "\"torque_off\" or \"hold\""});
  if (c.stop == StopAction::hold && c.mode == ServoMode::effort)
    wrong.push_back({"on_stop", "\"torque_off\"; hold needs mode position or velocity"});
  if (c.mode != ServoMode::effort && std::isfinite(c.limits.effort_nm))
    wrong.push_back({"max_effort_nm", "with mode \"effort\" only; otherwise the limit of the servo's own table holds"});
  if (c.homing_method != 0) wrong.push_back({"homing_method", "0; this servo has none"});
  if (c.device_timeout > Duration{0}) {
    const double most_ms = kWatchdogMost * watchdog_s(m) * 1e3;
    if (!m.bus_watchdog)
      wrong.push_back({"device_timeout_ms", "0; " + std::string(m.title) + " has no bus watchdog"});
    else if (msg::seconds(c.device_timeout) * 1e3 > most_ms)
      wrong.push_back({"device_timeout_ms", "at most " + key_number(most_ms)});
  }
  return wrong;
}

SerialServo::SerialServo(const ServoConfig& config, const SerialServoOptions& options)
    : model_(*options.model), joint_(config), cycle_(model_.cycle()) {
  const wire::ServoModel& m = model_;
  using Kind = Setting::Kind;
  const bool feetech = m.maker == wire::ServoMaker::feetech;
  std::int32_t mode = m.position_mode;
  goal_ = m.goal_position;
  if (config.mode == ServoMode::velocity) mode = m.velocity_mode, goal_ = m.goal_velocity;
  if (config.mode == ServoMode::effort) mode = m.effort_mode, goal_ = m.goal_effort;
  power_ = {m.present_voltage.address,
            static_cast<std::uint8_t>(m.present_temperature.address + m.present_temperature.size -
                                      m.present_voltage.address)};
  health_ = m.torque_enable;
  if (m.hardware_error && m.hardware_error.address < m.torque_enable.address + kHealthMost)
    health_.size = static_cast<std::uint8_t>(m.hardware_error.address + 1 - m.torque_enable.address);
  add_setting(Kind::model, m.model_number, m.number);
  add_setting(Kind::write, m.torque_enable, 0);
  if (feetech) add_setting(Kind::write, m.lock, 0);
  add_setting(Kind::keep, m.status_return, feetech ? 1 : 2);
  add_setting(Kind::keep, m.return_delay, 0);
  add_setting(Kind::keep, m.operating_mode, mode);
  if (feetech) add_setting(Kind::write, m.lock, 1);
  add_setting(Kind::look, m.hardware_error);
}

void SerialServo::add_setting(Setting::Kind kind, const wire::ServoRegister& reg, std::int32_t value) {
  if (reg) settings_.push_back({kind, reg, value});
}

// ---- units ----

std::int32_t SerialServo::position_count(double joint_rad) const noexcept {
  const double count = joint_.to_drive_position(joint_rad) / model_.rad_per_count() + model_.centre;
  return static_cast<std::int32_t>(
      std::lround(std::clamp(count, static_cast<double>(model_.least), static_cast<double>(model_.most))));
}

std::int32_t SerialServo::goal_count(double value) const noexcept {
  const auto whole = [](double counts) {
    return static_cast<std::int32_t>(std::lround(std::clamp(counts, -1e6, 1e6)));
  };
  if (config().mode == ServoMode::velocity) return whole(joint_.to_drive_velocity(value) / model_.radps_per_count);
  if (config().mode == ServoMode::effort) return whole(joint_.to_drive_effort(value) / model_.nm_per_count);
  return position_count(value);
}

// ---- once a tick ----

void SerialServo::tick(Time now, const ServoCommand& command) noexcept {
  using Intent = ServoCommand::Intent;
  command_ = command;
  has_goal_ = false;
  if (command.request_number != request_seen_) {
    request_seen_ = command.request_number;
    if (command.request == ServoCommand::Request::zero_here && joint_.zero_here()) joint_.resume(now);
  }
  if (joint_.watch(now)) {
    state_ = State::away;
    probe_.reset();
  }
  const bool torque_off =
      command.intent == Intent::off || (command.intent == Intent::stop && config().stop == StopAction::torque_off);
  switch (state_) {
    case State::away:
    case State::setting:
      joint_.set_mode(joint_.feedback().mode == msg::JointMode::fault && joint_.tripped() ? msg::JointMode::fault
                                                                                          : msg::JointMode::absent);
      return;
    case State::off:
      joint_.set_mode(joint_.idle_mode(now));
      if (joint_.may_enable(now, command)) start_enabling(now);
      return;
    case State::enabling:
      joint_.resume(now);
      if (torque_off || joint_.idle_mode(now) == msg::JointMode::fault) return go_off(now);
      if (now > deadline_) {
        joint_.trip(now, msg::kJointOther);
        go_off(now);
      }
      return;
    case State::on:
      if (torque_off || joint_.idle_mode(now) == msg::JointMode::fault) return go_off(now);
      return follow(now);
    case State::stopping:
      joint_.set_mode(joint_.idle_mode(now));
      return;
  }
}

void SerialServo::start_enabling(Time now) noexcept {
  joint_.begin(now);
  joint_.set_mode(msg::JointMode::enabling);
  state_ = State::enabling;
  enabling_ = 0;
  tries_ = 0;
  deadline_ = now + 1s;
}

void SerialServo::follow(Time now) noexcept {
  if (joint_.runs_well(now)) clear_.reset();
  const bool stopping = command_.intent == ServoCommand::Intent::stop;
  const ServoJoint::Target target = stopping ? joint_.held(now) : joint_.target(now, command_.setpoint);
  if (joint_.tripped()) return go_off(now);
  joint_.set_mode(stopping ? msg::JointMode::stopping : msg::JointMode::enabled);
  goal_value_ = goal_count(target.value);
  has_goal_ = true;
}

void SerialServo::go_off(Time now) noexcept {
  state_ = State::stopping;
  tries_ = 0;
  has_goal_ = false;
  joint_.went_off();
  joint_.set_mode(joint_.idle_mode(now));
}

bool SerialServo::goal(std::int32_t& out) const noexcept {
  if (!has_goal_ || state_ != State::on) return false;
  out = goal_value_;
  return true;
}

// ---- what it says ----

bool SerialServo::refused(std::uint8_t error) const noexcept {
  if (model_.version == DxlVersion::two) return (error & ~wire::kDxlAlert) != 0;
  constexpr std::uint8_t kPacket =
      wire::kDxl1AngleLimit | wire::kDxl1Range | wire::kDxl1Checksum | wire::kDxl1Instruction;
  return model_.maker == wire::ServoMaker::robotis && (error & kPacket) != 0;
}

void SerialServo::note_error(Time now, std::uint8_t error) noexcept {
  if (model_.version == DxlVersion::two)
    alert_ = alert_ || (error & wire::kDxlAlert) != 0;
  else
    joint_.set_drive_faults(now, wire::servo_faults(model_, error), error);
}

void SerialServo::on_cycle(Time now, std::uint8_t error, std::span<const std::uint8_t> data) noexcept {
  const std::uint16_t first = cycle_.address;
  const auto position = wire::servo_number(model_, model_.present_position, first, data);
  if (!position) {
    joint_.malformed();
    return;
  }
  misses_ = 0;
  const auto velocity = wire::servo_number(model_, model_.present_velocity, first, data);
  const auto effort = wire::servo_number(model_, model_.present_effort, first, data);
  joint_.measured(now, now, (*position - model_.centre) * model_.rad_per_count(),
                  velocity ? *velocity * model_.radps_per_count : kUnknown,
                  effort ? *effort * model_.nm_per_count : kUnknown);
  note_error(now, error);
}

void SerialServo::on_missed() noexcept {
  ++misses_;
  joint_.missed();
}

// ---- one question at a time ----

bool SerialServo::is_urgent(Time now) const noexcept {
  switch (state_) {
    case State::away:
      return probe_.due(now);
    case State::setting:
    case State::enabling:
    case State::stopping:
      return true;
    case State::off:
    case State::on:
      return (alert_ && !joint_.drive_faulty()) || misses_ >= kMissesApart;
  }
  return false;
}

bool SerialServo::ask(Time now, LineQuestion& out) noexcept {
  using Kind = LineQuestion::Kind;
  switch (state_) {
    case State::away:
      if (!probe_.due(now)) return false;
      probe_.attempt(now);
      ++joint_.stats().restarts;
      out = {Kind::read, model_.model_number};
      break;
    case State::setting: {
      const Setting& s = settings_[setting_];
      const bool write = s.kind == Setting::Kind::write || setting_differs_;
      out = {write ? Kind::write : Kind::read, s.reg, s.value};
      break;
    }
    case State::enabling:
      if (!next_enabling(out)) return false;
      break;
    case State::stopping:
      out = {Kind::write, model_.torque_enable, 0};
      break;
    case State::off:
    case State::on:
      if (misses_ >= kMissesApart) {
        out = {Kind::read, cycle_};
      } else if (state_ == State::off && joint_.drive_faulty() && model_.version == DxlVersion::two &&
                 command_.intent == ServoCommand::Intent::follow && clear_.due(now)) {
        clear_.attempt(now);
        out = {Kind::reboot, {}};
      } else if (alert_ && !joint_.drive_faulty()) {
        out = {Kind::read, model_.hardware_error};
      } else {
        out = {Kind::read, next_slow_register()};
      }
      break;
  }
  asked_ = out;
  return true;
}

/// In turn: power, health and, where it may have tripped, the watchdog: a servo that it stopped answers as one that
/// runs.
const wire::ServoRegister& SerialServo::next_slow_register() noexcept {
  const bool watched = state_ == State::on && has_watchdog();
  const std::uint32_t turn = ++turn_ % (watched ? 3 : 2);
  return turn == 0 ? power_ : turn == 1 ? health_ : model_.bus_watchdog;
}

/// In this order: the watchdog's own error is cleared, the goal is where the joint is, torque, watchdog.
bool SerialServo::next_enabling(LineQuestion& out) const noexcept {
  using Kind = LineQuestion::Kind;
  const double here = config().mode == ServoMode::position ? joint_.feedback().position_rad : 0;
  switch (enabling_) {
    case 0:
      out = {Kind::write, model_.bus_watchdog, 0};
      if (!model_.bus_watchdog) out = {Kind::write, goal_, goal_count(here)};
      return true;
    case 1:
      out = {Kind::write, goal_, goal_count(here)};
      return true;
    case 2:
      out = {Kind::write, model_.torque_enable, 1};
      return true;
    case 3:
      out = has_watchdog()
                ? LineQuestion{Kind::write, model_.bus_watchdog, watchdog_count(model_, config().device_timeout)}
                : LineQuestion{Kind::read, model_.torque_enable};
      return true;
    default:
      return false;
  }
}

void SerialServo::on_answer(Time now, std::uint8_t error, std::span<const std::uint8_t> data) noexcept {
  tries_ = 0;
  if (asked_.kind == LineQuestion::Kind::reboot) return rebooted(now);
  if (refused(error)) {
    note_error(now, error);
    if (state_ == State::stopping) return;  // said again
    joint_.set_drive_faults(now, msg::kJointOther, kRefused | (error & 0x7Fu));
    joint_.set_drive_faults(now, 0, 0);
    joint_.trip(now, msg::kJointOther);
    if (state_ == State::enabling)
      go_off(now);
    else if (state_ == State::setting)
      state_ = State::away;
    return;
  }
  if (state_ != State::away) note_error(now, error);
  if (asked_.kind == LineQuestion::Kind::read && data.size() != asked_.reg.size) {
    joint_.malformed();
    return;
  }
  switch (state_) {
    case State::away:
      state_ = State::setting;
      setting_ = 0;
      setting_differs_ = false;
      identity_.known = true;
      [[fallthrough]];
    case State::setting:
      return set_answered(now, asked_, data);
    case State::enabling:
      joint_.set_mode(msg::JointMode::enabling);
      if (++enabling_ < 4) return;
      state_ = State::on;
      joint_.resume(now);
      return;
    case State::stopping:
      state_ = State::off;
      return;
    case State::off:
    case State::on:
      return watched(now, asked_, data);
  }
}

void SerialServo::set_answered(Time now, const LineQuestion& asked, std::span<const std::uint8_t> data) noexcept {
  const Setting& s = settings_[setting_];
  const std::int32_t is = wire::servo_number(model_, s.reg, s.reg.address, data).value_or(0);
  const bool read = asked.kind == LineQuestion::Kind::read;
  if (s.kind == Setting::Kind::model) {
    identity_.product = static_cast<std::uint32_t>(is);
    if (is != s.value) {
      joint_.set_drive_faults(now, msg::kJointOther, static_cast<std::uint32_t>(is));
      joint_.trip(now, msg::kJointOther);
      state_ = State::away;
      return;
    }
    joint_.set_drive_faults(now, 0, 0);
  } else if (s.kind == Setting::Kind::look) {
    joint_.set_drive_faults(now, wire::servo_faults(model_, static_cast<std::uint8_t>(is)),
                            static_cast<std::uint32_t>(is));
    if (is != 0) clear_.attempt(now);  // the last reboot did not help: it is said for a while before the next
  } else if (s.kind == Setting::Kind::keep && read && is != s.value) {
    setting_differs_ = true;
    return;
  }
  setting_differs_ = false;
  if (++setting_ < settings_.size()) return;
  state_ = State::off;
  misses_ = 0;
  alert_ = false;
  probe_.reset();
}

void SerialServo::watched(Time now, const LineQuestion& asked, std::span<const std::uint8_t> data) noexcept {
  const auto is = [&](const wire::ServoRegister& reg) {
    return wire::servo_number(model_, reg, asked.reg.address, data);
  };
  if (asked.reg.address == cycle_.address && asked.reg.size == cycle_.size) return on_cycle(now, 0, data);
  if (const auto v = is(model_.present_voltage)) joint_.set_voltage(*v * model_.volts_per_count);
  if (const auto t = is(model_.present_temperature)) joint_.set_temperature(*t);
  if (const auto bits = is(model_.hardware_error)) {
    alert_ = false;
    joint_.set_drive_faults(now, wire::servo_faults(model_, static_cast<std::uint8_t>(*bits)),
                            static_cast<std::uint32_t>(*bits));
  }
  if (has_watchdog() && state_ == State::on && asked.reg.address == model_.bus_watchdog.address &&
      is(model_.bus_watchdog) == kWatchdogTripped) {
    has_goal_ = false;
    start_enabling(now);  // from where it stands, and without a moment without torque
    return;
  }
  if (const auto torque = is(model_.torque_enable); torque && *torque == 0 && state_ == State::on) {
    // It rebooted, or switched itself off: it may have forgotten its settings, and is not trusted with its goal.
    joint_.trip(now, msg::kJointOther);
    joint_.forget_position();  // the set-up takes a while
    has_goal_ = false;
    state_ = State::setting;
    setting_ = 0;
    setting_differs_ = false;
  }
}

void SerialServo::rebooted(Time now) noexcept {
  state_ = State::away;
  joint_.forget_position();
  joint_.went_off();
  joint_.set_drive_faults(now, 0, 0);
  joint_.set_mode(msg::JointMode::absent);
  probe_.reset();
}

void SerialServo::on_silence(Time now) noexcept {
  joint_.missed();
  if (asked_.kind == LineQuestion::Kind::reboot) return rebooted(now);
  if (state_ == State::setting && ++tries_ >= kTries) {
    state_ = State::away;
    tries_ = 0;
    probe_.attempt(now);
  }
}

}  // namespace sinew::drivers
