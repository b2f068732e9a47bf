#include "sim_hil/wire/sim_impedance.hpp"

namespace sinew::sim_hil {

using namespace std::chrono_literals;
using wire::CyberGearKind;

double SimImpedance::control(Time now, Duration) {
  if (temperature_c > hot_c_ && fault_ == 0) fail(hot_code());
  if (live_ && timeout_.count() > 0 && now - commanded_ > timeout_) live_ = false;
  if (!live_) return 0;
  const wire::MitCommand& c = command_;
  const double nm =
      c.kp * (c.position_rad + zero_ - drive_position()) + c.kd * (c.velocity_radps - drive_velocity()) + c.effort_nm;
  return nm > most_nm_ ? most_nm_ : nm < -most_nm_ ? -most_nm_ : nm;
}

void SimImpedance::on_power() {
  live_ = false;
  fault_ = 0;
  command_ = {};
}

SimMitMotor::SimMitMotor(hal::CanBus& bus, SimJoint& joint, const SimMount& mount, const Parameters& parameters)
    : SimImpedance(bus, joint, mount), p_(parameters) {
  most_nm_ = p_.type.effort_nm;
  timeout_ = p_.timeout;
}

void SimMitMotor::on_frame(const msg::CanFrame& frame, Time now) {
  if (frame.extended() || frame.id != p_.motor || frame.size != 8) return;
  if (const auto what = wire::decode_mit_switch(frame)) {
    switch (*what) {
      case wire::MitSwitch::enable:
        if (fault_ == 0 && !live_) {
          live_ = true;
          command_ = {};
        }
        break;
      case wire::MitSwitch::disable:
        live_ = false;
        if (p_.type.reply != wire::MitReply::status) clear();  // these forget a fault when they leave the mode
        break;
      case wire::MitSwitch::zero:
        zero_ = drive_position();
        break;
      case wire::MitSwitch::clear_fault:
        clear();
        break;
    }
    commanded_ = now;
  } else if (const auto command = wire::decode_mit_command(frame, p_.type)) {
    command_ = *command;
    commanded_ = now;
  }
  wire::MitFeedback f;
  f.motor = p_.motor;
  f.position_rad = drive_position() - zero_;
  f.velocity_radps = drive_velocity();
  f.effort_nm = drive_effort();
  f.temperature_c = temperature_c;
  f.voltage_v = voltage_v;
  f.code = fault_;
  if (p_.type.reply == wire::MitReply::status && fault_ == 0) f.code = live_ ? 1 : 0;
  send(encode_mit_reply(p_.master, f, p_.type));
}

SimCyberGear::SimCyberGear(hal::CanBus& bus, SimJoint& joint, const SimMount& mount, const Parameters& parameters)
    : SimImpedance(bus, joint, mount), p_(parameters) {
  most_nm_ = wire::kCyberGearEffort_nm;
  hot_c_ = 80;
}

void SimCyberGear::on_power() {
  SimImpedance::on_power();
  timeout_ = {};
}

void SimCyberGear::on_frame(const msg::CanFrame& frame, Time now) {
  const wire::CyberGearId id = wire::split_cybergear_id(frame.id);
  if (!frame.extended() || id.target != p_.motor || frame.size != 8) return;
  if (const auto m = wire::decode_cybergear_motion(frame)) {
    command_ = {m->position_rad, m->velocity_radps, m->kp, m->kd, m->effort_nm};
    commanded_ = now;
    reply(0xFD);
    return;
  }
  const std::uint32_t host = id.data & 0xFF;
  switch (static_cast<CyberGearKind>(id.kind)) {
    case CyberGearKind::identify:
      send(wire::encode_cybergear_identity(p_.motor, p_.serial));
      return;
    case CyberGearKind::enable:
      if (fault_ == 0 && !live_) {
        live_ = true;
        command_ = {};
      }
      commanded_ = now;
      break;
    case CyberGearKind::stop:
      live_ = false;
      if (frame.data[0] == 1) clear();
      break;
    case CyberGearKind::zero:
      zero_ = drive_position();
      break;
    case CyberGearKind::read:
    case CyberGearKind::write:
      on_parameter(frame, id);
      return;
    default:
      return;
  }
  reply(host);
}

void SimCyberGear::on_parameter(const msg::CanFrame& frame, const wire::CyberGearId& id) {
  const auto p = wire::decode_cybergear_parameter(frame);
  const std::uint32_t host = id.data & 0xFF;
  if (!p) return;
  if (static_cast<CyberGearKind>(id.kind) == CyberGearKind::write) {
    if (p->index == wire::kCyberGearCanTimeout) timeout_ = p->bits * 50us;
    reply(host);
    return;
  }
  wire::CyberGearParameter answer{p->index, 0};
  if (p->index == wire::kCyberGearVbus) answer.set_real(static_cast<float>(voltage_v));
  send(wire::encode_cybergear_parameter(CyberGearKind::read, p_.motor, host, answer));
}

void SimCyberGear::reply(std::uint32_t host) {
  wire::CyberGearFeedback f;
  f.motor = p_.motor;
  f.host = host;
  f.position_rad = drive_position() - zero_;
  f.velocity_radps = drive_velocity();
  f.effort_nm = drive_effort();
  f.temperature_c = temperature_c;
  f.fault_bits = fault_;
  f.mode = live_ ? wire::CyberGearFeedback::Mode::running : wire::CyberGearFeedback::Mode::reset;
  send(wire::encode_cybergear_feedback(f));
}

}  // namespace sinew::sim_hil
