#include "drivers/mit_servo.hpp"

namespace sinew::drivers {

std::string check_mit(const ServoConfig& c, const MitOptions& o) {
  const auto say = [&c](const char* what) { return "servo '" + c.name + "': " + what; };
  const wire::MitMotorType& t = o.type;
  if (!(t.position_rad > 0 && t.velocity_radps > 0 && t.effort_nm > 0 && t.kp > 0 && t.kd > 0)) {
    return say("ranges of the motor: above 0");
  }
  if (std::string wrong = check_impedance(c, t.kp, t.kd); !wrong.empty()) return wrong;
  const bool short_id = t.reply == wire::MitReply::status;  // half a byte of the reply
  if (c.node_id < 1 || c.node_id > (short_id ? 15u : 255u)) return say(short_id ? "node_id: 1..15" : "node_id: 1..255");
  if (o.master_id > 0x7FF) return say("master_id: 0..2047");
  if (o.master_id == c.node_id) return say("master_id: is the motor's own");
  if (c.device_timeout > Duration{0}) return say("device_timeout: is set in the motor, no frame does it");
  return {};
}

BusNeed MitServo::need(double tick_hz) const {
  BusNeed need;
  need.add(wire::can_frame(0, 8), 2 * tick_hz);
  return need;
}

msg::CanFrame MitServo::encode(const wire::MitCommand& command) const noexcept {
  return encode_mit(config().node_id, command, options_.type);
}

msg::CanFrame MitServo::encode(Switch what) const noexcept {
  // Only Damiao's firmware knows how to clear a fault; others do by leaving the mode.
  const bool clears = what == Switch::clear_fault && options_.type.reply == wire::MitReply::status;
  const auto code = what == Switch::enable ? wire::MitSwitch::enable
                    : clears               ? wire::MitSwitch::clear_fault
                                           : wire::MitSwitch::disable;
  return encode_mit(config().node_id, code);
}

Heard MitServo::on_frame(const msg::CanFrame& frame, Time now) noexcept {
  const auto reply = decode_mit_reply(frame, options_.type);
  if (!reply) {
    joint_.malformed();
    return Heard::malformed;
  }
  if (reply->motor != config().node_id) return Heard::foreign;  // another motor's, under the same identifier
  heard(now, {frame.stamp, reply->position_rad, reply->velocity_radps, reply->effort_nm, reply->temperature_c,
              reply->voltage_v, reply->faults, reply->code, reply->status_known, reply->enabled});
  return Heard::mine;
}

TorqueSaid MitServo::torque_said(const msg::CanFrame& frame, Time /*now*/) noexcept {
  const auto reply = decode_mit_reply(frame, options_.type);
  if (!reply || reply->motor != config().node_id) return TorqueSaid::nothing;
  return reply->status_known && reply->enabled ? TorqueSaid::on : TorqueSaid::off;
}

}  // namespace sinew::drivers
