#include "drivers/joints/mit_servo.hpp"

namespace sinew::drivers {

WrongKeys check_mit(const ServoConfig& c, const MitOptions& o) {
  const wire::MitMotorType& t = o.type;
  WrongKeys wrong;
  for (const auto& [key, range] : {std::pair{"range_position_rad", t.position_rad},
                                   {"range_velocity_radps", t.velocity_radps},
                                   {"range_effort_nm", t.effort_nm},
                                   {"range_kp", t.kp},
                                   {"range_kd", t.kd}})
    if (!(range > 0)) wrong.push_back({key, "a number above 0"});
  if (!wrong.empty()) return wrong;  // gains are checked against these
  wrong = check_impedance(c, t.kp, t.kd);
  const std::uint32_t most_id = t.reply == wire::MitReply::status ? 15 : 255;  // half a byte of the reply
  if (c.node_id < 1 || c.node_id > most_id)
    wrong.push_back({"id", "an integer from 1 to " + std::to_string(most_id) + ", for this motor"});
  if (o.master_id > 0x7FF) wrong.push_back({"master_id", "an integer from 0x0 to 0x7FF"});
  if (o.master_id == c.node_id) wrong.push_back({"master_id", "another number than the motor's id"});
  if (c.device_timeout > Duration{0})
    wrong.push_back({"device_timeout_ms", "0: it is set in the motor, no frame does it"});
  return wrong;
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
  auto code = clears ? wire::MitSwitch::clear_fault : wire::MitSwitch::disable;
  if (what == Switch::enable) code = wire::MitSwitch::enable;
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
