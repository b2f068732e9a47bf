#include "drivers/joints/servo_joint.hpp"

#include <cmath>

namespace sinew::drivers {
namespace {

using namespace std::chrono_literals;

constexpr double kJumpMargin_rad = 0.02;  // for quantisation, and for time stamps that are not the measurement's
constexpr double kLimitMargin_rad = 0.01;
constexpr double kBeyond = 1.0001;  // of a limit: no rounding

double clamp(double value, double low, double high) { return value < low ? low : value > high ? high : value; }

}  // namespace

ServoJoint::ServoJoint(const ServoConfig& config) : config_(config) {
  if (config_.plausible_velocity_radps <= 0) config_.plausible_velocity_radps = 4 * config_.limits.velocity_radps;
  if (config_.following.position_rad < 0) config_.following.position_rad = FollowingError::kUsual_rad;
}

bool ServoJoint::plausible(Time now, double joint_rad, double joint_radps) const noexcept {
  const double fastest = config_.plausible_velocity_radps;
  if (!std::isfinite(joint_rad) || std::abs(joint_radps) > fastest) return false;  // NaN: not in this frame
  if (!believed_ || new_zero_) return true;
  return std::abs(joint_rad - feedback_.position_rad) <= fastest * msg::seconds(now - arrived_) + kJumpMargin_rad;
}

bool ServoJoint::measured(Time now, Time stamp, double drive_rad, double drive_radps, double drive_nm) noexcept {
  const double turn = config_.sign / config_.gear_ratio;
  const double joint_rad = turn * drive_rad - config_.zero_rad, joint_radps = turn * drive_radps;
  if (!plausible(now, joint_rad, joint_radps)) {
    ++stats_.implausible;
    doubted_ = true;
    return false;
  }
  feedback_.measured = stamp.ns != 0 ? stamp : now;
  ++feedback_.number;
  ++stats_.feedback;
  feedback_.position_rad = joint_rad;
  if (!std::isnan(drive_radps)) feedback_.velocity_radps = joint_radps;
  if (!std::isnan(drive_nm)) feedback_.effort_nm = config_.sign * drive_nm * config_.gear_ratio;
  arrived_ = now;
  believed_ = true;
  new_zero_ = doubted_ = false;
  lost_ = false;
  collect_faults();
  return true;
}

void ServoJoint::set_velocity(double drive_radps) noexcept {
  const double joint_radps = config_.sign * drive_radps / config_.gear_ratio;
  if (!(std::abs(joint_radps) <= config_.plausible_velocity_radps)) {
    ++stats_.implausible;
    return;
  }
  feedback_.velocity_radps = joint_radps;
}

void ServoJoint::set_drive_faults(Time now, std::uint32_t faults, std::uint32_t code) noexcept {
  if (faults != 0 && drive_faults_ == 0) {
    ++stats_.faults;
    back_off_.attempt(now);
    went_off();
  }
  drive_faults_ = faults;
  if (faults != 0) feedback_.fault_code = code;
  collect_faults();
}

void ServoJoint::looks_double(Time now) noexcept {
  if (doubles_ == 0 || now - double_first_ > 1s) {
    doubles_ = 0;
    double_first_ = now;
  }
  ++doubles_;
  double_at_ = now;
  if (doubles_ < 2 || double_) return;
  double_ = true;
  ++stats_.faults;
  went_off();
  collect_faults();
}

bool ServoJoint::zero_here() noexcept {
  if (!believed_) return false;
  config_.zero_rad += feedback_.position_rad;
  feedback_.position_rad = 0;
  return true;
}

bool ServoJoint::watch(Time now) noexcept {
  if (double_ && now - double_at_ > 2s) double_ = false;
  if (runs_well(now)) back_off_.reset();
  collect_faults();
  if (!believed_ || now - arrived_ <= config_.feedback_timeout) return false;
  believed_ = false;
  lost_ = true;
  ++stats_.losses;
  if (doubted_) own_faults_ |= msg::kJointEncoder;  // it sent frames all the time, none of them plausible
  went_off();
  back_off_.attempt(now);
  set_mode(msg::JointMode::absent);
  collect_faults();
  return true;
}

bool ServoJoint::may_enable(Time now, const ServoCommand& command) noexcept {
  if (command.disarmed) disarmed_ = true;
  // Commands from the time when it could not be enabled count as old.
  if (!believed_ || drive_faults_ != 0 || double_ || !back_off_.due(now)) stale_number_ = true;
  if (stale_number_) {  // the first command that is seen after going off does not count: it may be the old one
    stale_number_ = false;
    seen_number_ = command.number;
    if (config_.needs_disarm && stats_.faults + stats_.losses > 0) {
      disarmed_ = command.disarmed;
    }
    return false;
  }
  if (command.intent != ServoCommand::Intent::follow || command.number == seen_number_ || !disarmed_) return false;
  return believed_ && drive_faults_ == 0 && !double_ && back_off_.due(now) && std::isfinite(command.setpoint);
}

void ServoJoint::begin(Time now) noexcept {
  own_faults_ = 0;
  enabled_at_ = now;
  ++stats_.enables;
  resume(now);
  collect_faults();
}

bool ServoJoint::runs_well(Time now) const noexcept { return enabled() && now - enabled_at_ > 1s; }

void ServoJoint::resume(Time now) noexcept {
  behind_ = false;
  target_at_ = asked_well_ = now;
  last_value_ = config_.mode == ServoMode::position ? feedback_.position_rad : 0;
}

double ServoJoint::strength() const noexcept {
  const Derating& d = config_.derating;
  if (d.start_c >= d.end_c || std::isnan(feedback_.temperature_c)) return 1;
  return clamp((d.end_c - feedback_.temperature_c) / (d.end_c - d.start_c), 0, 1);
}

double ServoJoint::effort_limit() const noexcept {
  const double most = config_.limits.effort_nm;
  return std::isfinite(most) ? strength() * most : most;
}

bool ServoJoint::falls_behind(double value) const noexcept {
  const FollowingError& f = config_.following;
  if (strength() < 1) return false;
  if (config_.mode == ServoMode::position) {
    return f.position_rad > 0 && std::abs(value - feedback_.position_rad) > f.position_rad;
  }
  return config_.mode == ServoMode::velocity && f.velocity_radps > 0 &&
         std::abs(value - feedback_.velocity_radps) > f.velocity_radps;
}

bool ServoJoint::asks_too_much(double setpoint) const noexcept {
  const ServoLimits& l = config_.limits;
  if (config_.mode == ServoMode::position)
    return setpoint < l.position_min_rad - kLimitMargin_rad || setpoint > l.position_max_rad + kLimitMargin_rad;
  const double most = config_.mode == ServoMode::velocity ? l.velocity_radps : l.effort_nm;
  return std::abs(setpoint) > kBeyond * most;
}

ServoJoint::Target ServoJoint::target(Time now, double setpoint) noexcept {
  const ServoLimits& limits = config_.limits;
  if (!asks_too_much(setpoint)) asked_well_ = now;
  feedback_.beyond = now - asked_well_;
  Target t{setpoint, effort_limit()};
  const double p = feedback_.position_rad;
  if (config_.mode == ServoMode::position) {
    const double reach = limits.velocity_radps * msg::seconds(now - target_at_);
    t.value = clamp(clamp(setpoint, limits.position_min_rad, limits.position_max_rad), last_value_ - reach,
                    last_value_ + reach);
  } else {
    const double most = config_.mode == ServoMode::velocity ? limits.velocity_radps : t.effort_limit_nm;
    t.value = clamp(setpoint, -most, most);
    if ((p >= limits.position_max_rad && t.value > 0) || (p <= limits.position_min_rad && t.value < 0)) t.value = 0;
  }
  target_at_ = now;
  last_value_ = t.value;
  if (!falls_behind(t.value)) {
    behind_ = false;
  } else if (!behind_) {
    behind_ = true;
    behind_since_ = now;
  } else if (now - behind_since_ > config_.following.time) {
    trip(now, msg::kJointOverload);
  }
  return t;
}

ServoJoint::Target ServoJoint::held(Time now) noexcept {
  target_at_ = asked_well_ = now;
  feedback_.beyond = {};
  behind_ = false;
  return {config_.mode == ServoMode::position ? last_value_ : 0.0, effort_limit()};
}

void ServoJoint::trip(Time now, std::uint32_t faults) noexcept {
  if ((own_faults_ & faults) != faults) ++stats_.faults;
  own_faults_ |= faults;
  went_off();
  back_off_.attempt(now);
  set_mode(msg::JointMode::fault);
  collect_faults();
}

msg::JointMode ServoJoint::idle_mode(Time now) const noexcept {
  const bool held_back = drive_faults_ != 0 || double_ || (own_faults_ != 0 && !back_off_.due(now));
  return held_back ? msg::JointMode::fault : msg::JointMode::disabled;
}

void ServoJoint::collect_faults() noexcept {
  std::uint32_t faults = drive_faults_ | own_faults_;
  if (lost_) faults |= msg::kJointLost;
  if (double_) faults |= msg::kJointDuplicate;
  if (strength() < 1) faults |= msg::kJointDerated;
  const double p = feedback_.position_rad;
  if (believed_ && (p < config_.limits.position_min_rad - kLimitMargin_rad ||
                    p > config_.limits.position_max_rad + kLimitMargin_rad)) {
    faults |= msg::kJointLimit;
  }
  feedback_.faults = faults;
}

}  // namespace sinew::drivers
