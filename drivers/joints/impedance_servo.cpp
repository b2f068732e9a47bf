#include "drivers/joints/impedance_servo.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::drivers {

using namespace std::chrono_literals;
using wire::MitCommand;

namespace {

constexpr std::uint32_t kRepliesWindow = 20;  // questions after which replies are counted, to find a second motor
constexpr int kConfirmations = 2;             // the first reply may belong to a question of before

}  // namespace

WrongKeys check_impedance(const ServoConfig& c, double most_kp, double most_kd) {
  WrongKeys wrong = check_servo(c);
  const double gear = c.gear_ratio * c.gear_ratio;  // gains are the joint's, ranges the motor's
  const auto up_to = [gear](double most) { return "a number above 0, at most " + key_number(most * gear); };
  if (c.mode == ServoMode::position && !(c.kp > 0 && c.kp / gear <= most_kp))
    wrong.push_back({"kp", up_to(most_kp) + "; required for mode position"});
  if (c.mode != ServoMode::effort && !(c.kd > 0 && c.kd / gear <= most_kd))
    wrong.push_back({"kd", up_to(most_kd) + "; required for mode position and velocity"});
  if (!(c.damp_kd / gear <= most_kd)) wrong.push_back({"damp_kd", "at most " + key_number(most_kd * gear)});
  if (c.stop == StopAction::quick_stop)
    wrong.push_back({"on_stop", "\"torque_off\", \"damp\" or \"hold\"; this motor has no quick_stop"});
  if (c.stop == StopAction::hold && c.mode != ServoMode::position)
    wrong.push_back({"on_stop", "\"torque_off\" or \"damp\"; hold needs mode position"});
  if (c.stop == StopAction::damp && !(c.damp_kd > 0 || c.kd > 0))
    wrong.push_back({"damp_kd", up_to(most_kd) + "; required for on_stop = \"damp\" without kd"});
  if (c.homing_method != 0) wrong.push_back({"homing_method", "0; this motor has none"});
  return wrong;
}

ServoConfig ImpedanceServo::with_spring(ServoConfig c, double motor_nm) {
  if (c.following.position_rad >= 0 || !(c.kp > 0)) return c;
  c.following.position_rad = FollowingError::kUsual_rad + std::min(c.limits.effort_nm, motor_nm * c.gear_ratio) / c.kp;
  return c;
}

void ImpedanceServo::heard(Time now, const Reply& reply) noexcept {
  ++replies_;
  waiting_ = false;
  identity_.known = true;
  if (!joint_.measured(now, reply.stamp, reply.position_rad, reply.velocity_radps, reply.effort_nm)) return;
  probe_.reset();
  if (!std::isnan(reply.temperature_c)) joint_.set_temperature(reply.temperature_c);
  if (!std::isnan(reply.voltage_v)) joint_.set_voltage(reply.voltage_v);
  joint_.set_drive_faults(now, reply.faults, reply.code);
  if (!on_ || reply.faults != 0) return;
  if (!reply.status_known || reply.enabled) {
    ++confirmations_;
  } else if (confirmations_ >= kConfirmations) {
    joint_.trip(now, msg::kJointOther);  // it went off by itself
  }
}

void ImpedanceServo::ask(const msg::CanFrame& frame, FrameSink& out) noexcept {
  if (waiting_) joint_.missed();
  waiting_ = true;
  ++asked_;
  out.send(frame);
}

void ImpedanceServo::count_replies(Time now) noexcept {
  if (asked_ < kRepliesWindow) return;
  if (replies_ > asked_ * 3 / 2) joint_.looks_double(now);
  asked_ = replies_ = 0;
}

void ImpedanceServo::take_request(Time now, const ServoCommand& command) noexcept {
  if (command.request_number == request_seen_) return;
  request_seen_ = command.request_number;
  if (command.request == ServoCommand::Request::zero_here && joint_.zero_here()) joint_.resume(now);
}

void ImpedanceServo::tick(Time now, const ServoCommand& command, FrameSink& out) noexcept {
  if (joint_.watch(now)) {
    on_ = false;
    on_off();
    probe_.reset();
    asked_ = replies_ = 0;
  }
  count_replies(now);
  take_request(now, command);
  if (on_) {
    stay_on(now, command, out);
  } else {
    stay_off(now, command, out);
  }
  if (joint_.feedback().mode != msg::JointMode::absent) ask_more(now, out);
}

void ImpedanceServo::stay_off(Time now, const ServoCommand& command, FrameSink& out) noexcept {
  const ServoFeedback& f = joint_.feedback();
  const bool alive = f.measured.ns != 0 && (f.faults & msg::kJointLost) == 0;
  if (joint_.may_enable(now, command) && told_settings()) {
    joint_.begin(now);
    joint_.set_mode(msg::JointMode::enabling);
    on_ = true;
    confirmations_ = 0;
    deadline_ = now + 500ms;
    ask(encode(Switch::enable), out);
    return;
  }
  joint_.set_mode(alive ? joint_.idle_mode(now) : msg::JointMode::absent);
  if (alive ? now < next_ask_ : !probe_.due(now)) return;
  if (!alive) {
    probe_.attempt(now);
    ++joint_.stats().restarts;
  }
  next_ask_ = now + std::min<Duration>(20ms, config().feedback_timeout / 4);
  const bool clear = joint_.drive_faulty() && clear_.due(now);
  if (clear) clear_.attempt(now);
  ask(encode(clear ? Switch::clear_fault : Switch::disable), out);
}

void ImpedanceServo::stay_on(Time now, const ServoCommand& command, FrameSink& out) noexcept {
  using Intent = ServoCommand::Intent;
  const bool stopping = command.intent == Intent::stop;
  const bool broken = joint_.idle_mode(now) == msg::JointMode::fault;
  if (command.intent == Intent::off || broken || (stopping && config().stop == StopAction::torque_off)) {
    go_off(now, out);
    return;
  }
  if (confirmations_ < kConfirmations) {
    if (now > deadline_) {
      joint_.trip(now, msg::kJointOther);
      go_off(now, out);
      return;
    }
    joint_.resume(now);
    ask(encode(Switch::enable), out);  // a lost one is said again
    return;
  }
  if (joint_.runs_well(now)) clear_.reset();
  const MitCommand motion = stopping ? stop(now) : follow(now, command.setpoint);
  if (joint_.tripped()) {
    go_off(now, out);
    return;
  }
  joint_.set_mode(stopping ? msg::JointMode::stopping : msg::JointMode::enabled);
  ask(encode(motion), out);
}

void ImpedanceServo::go_off(Time now, FrameSink& out) noexcept {
  on_ = false;
  on_off();
  joint_.went_off();
  joint_.set_mode(joint_.idle_mode(now));
  next_ask_ = now;  // said again at once, should this frame be lost
  ask(encode(Switch::disable), out);
}

double ImpedanceServo::pulled(double target, double measured, double gain, double most_nm) noexcept {
  const double reach = most_nm / gain, error = target - measured;
  return measured + std::clamp(error, -reach, reach);
}

MitCommand ImpedanceServo::follow(Time now, double setpoint) noexcept {
  const ServoConfig& c = config();
  const ServoJoint::Target target = joint_.target(now, setpoint);
  const ServoFeedback& f = joint_.feedback();
  MitCommand command;
  if (c.mode == ServoMode::effort) {
    command.effort_nm = joint_.to_drive_effort(target.value);
    return command;
  }
  command.kd = joint_.to_drive_gain(c.kd);
  if (c.mode == ServoMode::velocity) {
    command.velocity_radps =
        joint_.to_drive_velocity(pulled(target.value, f.velocity_radps, c.kd, target.effort_limit_nm));
    return command;
  }
  command.kp = joint_.to_drive_gain(c.kp);
  command.position_rad = joint_.to_drive_position(pulled(target.value, f.position_rad, c.kp, target.effort_limit_nm));
  return command;
}

MitCommand ImpedanceServo::stop(Time now) noexcept {
  const ServoConfig& c = config();
  MitCommand command;
  if (c.stop != StopAction::hold) {
    joint_.resume(now);
    command.kd = joint_.to_drive_gain(c.damp_kd > 0 ? c.damp_kd : c.kd);
    return command;
  }
  const ServoJoint::Target held = joint_.held(now);
  command.position_rad =
      joint_.to_drive_position(pulled(held.value, joint_.feedback().position_rad, c.kp, held.effort_limit_nm));
  command.kp = joint_.to_drive_gain(c.kp);
  command.kd = joint_.to_drive_gain(c.kd);
  return command;
}

}  // namespace sinew::drivers
