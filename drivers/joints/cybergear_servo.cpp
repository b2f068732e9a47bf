#include "drivers/joints/cybergear_servo.hpp"

namespace sinew::drivers {

using namespace std::chrono_literals;
using wire::CyberGearKind;

namespace {

constexpr Duration kQuestions = 250ms;  // between two of them: voltage, identity
constexpr int kTimesTold = 3;           // in ticks one after the other: no answer tells whether it was heard

}  // namespace

WrongKeys check_cybergear(const ServoConfig& c, std::uint32_t host_id) {
  WrongKeys wrong = check_impedance(c, wire::kCyberGearKp, wire::kCyberGearKd);
  if (c.node_id < 1 || c.node_id > 127) wrong.push_back({"id", "an integer from 1 to 127"});
  if (host_id > 0xFF || host_id == c.node_id)
    wrong.push_back({"host_id", "an integer from 0x0 to 0xFF, another than the motor's id"});
  if (c.device_timeout > 20s) wrong.push_back({"device_timeout_ms", "at most 20000"});
  return wrong;
}

CyberGearServo::CyberGearServo(const ServoConfig& config, std::uint32_t host_id)
    : ImpedanceServo(config, wire::kCyberGearEffort_nm), host_(host_id) {
  constexpr std::uint32_t kMask = 0x1F00FFFF;  // kind, motor, target; the rest of a feedback's `data` is status
  const std::uint32_t motor = config.node_id;
  interests_ = {Interest{wire::cybergear_id(CyberGearKind::feedback, motor, host_), kMask, true},
                Interest{wire::cybergear_id(CyberGearKind::read, motor, host_), kMask, true},
                Interest{wire::cybergear_id(CyberGearKind::fault, motor, host_), kMask, true},
                Interest{wire::cybergear_id(CyberGearKind::identify, motor, wire::kCyberGearBroadcast), kMask, true}};
}

BusNeed CyberGearServo::need(double tick_hz) const {
  BusNeed need;
  need.add(wire::can_frame(0, 8, true), 2 * tick_hz + 2 / msg::seconds(kQuestions));
  return need;
}

msg::CanFrame CyberGearServo::encode(const wire::MitCommand& c) const noexcept {
  return wire::encode_cybergear_motion(config().node_id, {c.position_rad, c.velocity_radps, c.kp, c.kd, c.effort_nm});
}

msg::CanFrame CyberGearServo::encode(Switch what) const noexcept {
  const auto kind = what == Switch::enable ? CyberGearKind::enable : CyberGearKind::stop;
  return wire::encode_cybergear(kind, host_, config().node_id, what == Switch::clear_fault);
}

void CyberGearServo::ask_more(Time now, FrameSink& out) noexcept {
  const std::uint32_t motor = config().node_id;
  const bool off = joint_.feedback().mode == msg::JointMode::disabled;
  if (config().device_timeout > 0ns && off && timeouts_told_ < kTimesTold) {
    // 20000 is a second (manual of firmware 1.2.1.5, 4.1.11).
    const auto count = static_cast<std::uint32_t>(config().device_timeout / 50us);
    out.send(wire::encode_cybergear_parameter(CyberGearKind::write, host_, motor, {wire::kCyberGearCanTimeout, count}));
    ++timeouts_told_;
    return;
  }
  if (now < next_question_) return;
  next_question_ = now + kQuestions;
  if (identity_.serial == 0) {
    out.send(wire::encode_cybergear(CyberGearKind::identify, host_, motor));
  } else {
    out.send(wire::encode_cybergear_parameter(CyberGearKind::read, host_, motor, {wire::kCyberGearVbus, 0}));
    if (off && timeouts_told_ == kTimesTold) --timeouts_told_;  // once more: it may have been without power
  }
}

bool CyberGearServo::told_settings() const noexcept {
  return config().device_timeout <= 0ns || timeouts_told_ == kTimesTold;
}

void CyberGearServo::on_identity(std::uint64_t serial, Time now) noexcept {
  if (identity_.serial != 0 && identity_.serial != serial) joint_.looks_double(now);
  identity_.serial = serial;
}

Heard CyberGearServo::on_frame(const msg::CanFrame& frame, Time now) noexcept {
  if (const auto f = wire::decode_cybergear_feedback(frame)) {
    heard(now, {frame.stamp, f->position_rad, f->velocity_radps, f->effort_nm, f->temperature_c, kUnknown, f->faults,
                f->fault_bits, true, f->mode == wire::CyberGearFeedback::Mode::running});
    return Heard::mine;
  }
  if (const auto serial = wire::decode_cybergear_identity(frame)) {
    on_identity(*serial, now);
    return Heard::mine;
  }
  if (const auto p = wire::decode_cybergear_parameter(frame)) {
    if (p->index != wire::kCyberGearVbus) return Heard::foreign;
    if (!(p->real() >= 0 && p->real() < 200)) {
      joint_.malformed();
      return Heard::malformed;
    }
    joint_.set_voltage(p->real());
    return Heard::mine;
  }
  if (const auto bits = wire::decode_cybergear_fault(frame)) {
    if (*bits != 0) joint_.set_drive_faults(now, wire::joint_faults_of_report(*bits), *bits);
    return Heard::mine;
  }
  joint_.malformed();
  return Heard::malformed;
}

TorqueSaid CyberGearServo::torque_said(const msg::CanFrame& frame, Time /*now*/) noexcept {
  const auto f = wire::decode_cybergear_feedback(frame);
  if (!f) return TorqueSaid::nothing;
  return f->mode == wire::CyberGearFeedback::Mode::running ? TorqueSaid::on : TorqueSaid::off;
}

}  // namespace sinew::drivers
