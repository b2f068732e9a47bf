#include "robots/kid/calibration_stand.hpp"

#include <algorithm>

#include "robots/kid/devices.hpp"

namespace sinew::kid {

using namespace std::chrono_literals;
using kinematics::kLimbs;

namespace {

constexpr double kRests_s = 0.45;  // the last part of a pose, in which nothing moves
constexpr double kFirst_s = 2;     // to the first pose, from wherever it is

/// 0 to 1 without a jerk at the ends.
double smooth(double t) { return t * t * t * (10 + t * (6 * t - 15)); }

}  // namespace

void CalibrationStand::declare(rt::Declaration& d) {
  for (std::size_t i = 0; i < kLimbs; ++i)
    d.in(std::string(to_string(kinematics::Limb(i))) + "_joints", joints_[i], {.max_age = 100ms});
  d.in("soles", soles_, {.max_age = 100ms, .optional = true});
  for (std::size_t i = 0; i < kLimbs; ++i)
    d.out(to_string(kinematics::Limb(i)), limb_[i], {.channels = plant::kKidLimbJoints[i]});
  d.out("mission", mission_);
  d.state(from_, turn_rad_, begin_);
  d.param("poses", poses_, {.min = 3, .max = 400, .doc = "at the start"});
  d.param("seed", seed_, {.min = 0, .max = 1e6, .doc = "other poses of the same kind; at the start"});
  d.param("move_s", move_s_, {.unit = "s", .min = 0.2, .max = 10, .doc = "from pose to pose"});
  d.param("hold_s", hold_s_, {.unit = "s", .min = 0.3, .max = 10, .doc = "in each pose"});
  d.param("height_m", options_.height_m,
          {.unit = "m", .min = 0.05, .max = 2, .doc = "of the hips over the soles; at the start"});
  d.param("stance_m", options_.stance_m,
          {.unit = "m", .min = 0.02, .max = 1, .doc = "between the soles' middles; at the start"});
  d.param("ahead_m", options_.ahead_m,
          {.unit = "m", .min = 0.1, .max = 5, .doc = "where the board's middle is; at the start"});
  d.param("aside_m", options_.aside_m, {.unit = "m", .min = -2, .max = 2, .doc = "and to the left; at the start"});
  d.param("around_m", options_.around_m,
          {.unit = "m", .min = 0, .max = 2, .doc = "it looks up to this far beside it; at the start"});
  d.param("tilt_rad", options_.tilt_rad,
          {.unit = "rad", .min = 0, .max = 0.5, .doc = "of the torso, both ways; at the start"});
  d.param("turn_rad", options_.turn_rad,
          {.unit = "rad", .min = 0, .max = 0.8, .doc = "about the vertical; at the start"});
  d.param("shift_m", options_.shift_m,
          {.unit = "m", .min = 0, .max = 0.1, .doc = "of the centre of mass, both ways; at the start"});
  d.param("lower_m", options_.lower_m, {.unit = "m", .min = 0, .max = 0.2, .doc = "up to this far down; at the start"});
}

hal::Status CalibrationStand::configure(rt::Setup& setup) {
  if (!robot_.body) {
    setup.explain("it needs [body] in the robot file (docs/bodies.md)");
    return hal::Error{hal::Errc::bad_argument, "a body"};
  }
  std::string why;
  figure_ = motion::Figure::make(*robot_.body, why);
  if (!figure_) {
    setup.explain(why);
    return hal::Error{hal::Errc::bad_argument, "a body with two legs"};
  }
  limbs_ = kinematics::Limbs::of(*robot_.body);
  options_.poses = static_cast<std::size_t>(poses_);
  options_.seed = static_cast<std::uint64_t>(seed_);
  pose_ = motion::stand_poses(*figure_, options_);
  if (2 * pose_.size() < options_.poses) {
    setup.explain("the body reaches only " + std::to_string(pose_.size()) + " of " + std::to_string(options_.poses) +
                  " poses: another height_m, stance_m, tilt_rad or turn_rad");
    return hal::Error{hal::Errc::bad_argument, "poses within reach"};
  }
  level_.emplace(*figure_);
  from_.assign(figure_->joints(), 0);
  rad_.assign(figure_->joints(), 0);
  return {};
}

void CalibrationStand::reset() {
  std::ranges::fill(from_, 0.0);
  turn_rad_ = {};
  begin_ = {};
}

rt::StepStatus CalibrationStand::step(const rt::Step& step) noexcept {
  rt::Time stamp{};
  if (begin_ == rt::Time{}) {
    for (std::size_t limb = 0; limb < kLimbs; ++limb) {
      const msg::JointState* state = joints_[limb].fresh(step.now);
      const bool is_leg = limb >= static_cast<std::size_t>(kinematics::Limb::left_leg);
      if (!state && is_leg) return rt::StepStatus::stale;
      for (std::size_t c = 0; state && c < limbs_.joints[limb].size(); ++c)
        if (math::fabs(state->position_rad[c]) < 7) from_[limbs_.joints[limb][c]] = state->position_rad[c];
    }
    begin_ = step.now;
  }
  for (const auto& in : joints_)
    if (const msg::JointState* state = in.get()) stamp = state->stamp;

  // Before 0 it is on its way to the first pose; each pose begins with the way to it.
  const double t = msg::seconds(step.now - begin_) - kFirst_s, each = move_s_ + hold_s_;
  const auto last = static_cast<double>(pose_.size() - 1);
  const double number = t < hold_s_ ? 0 : std::min(last, math::floor((t - hold_s_) / each) + 1);
  const auto n = static_cast<std::size_t>(number);
  const double way_s = n == 0 ? kFirst_s : move_s_, since = n == 0 ? t + kFirst_s : t - hold_s_ - (number - 1) * each;
  const double part = smooth(std::clamp(since / way_s, 0.0, 1.0));
  for (std::size_t j = 0; j < rad_.size(); ++j) {
    const double from = n == 0 ? from_[j] : pose_[n - 1][j];
    rad_[j] = from + part * (pose_[n][j] - from);
  }
  level_->turn_rad = turn_rad_;
  const msg::SolePressure* soles = soles_.fresh(step.now);
  if (soles && since < way_s + hold_s_ - kRests_s) {
    std::array<motion::SoleForces, 2> forces;
    for (std::size_t i = 0; i < msg::kSoleCells; ++i) forces[i / 4][i % 4] = soles->force_n[i];
    level_->step(forces, msg::seconds(step.dt));
  }
  turn_rad_ = level_->turn_rad;
  level_->add_to(rad_);
  for (std::size_t limb = 0; limb < kLimbs; ++limb) {
    msg::ActuatorCommand& out = limb_[limb].loan();
    out.stamp = stamp;
    out.armed = 1;
    out.count = plant::kKidLimbJoints[limb];
    for (std::size_t c = 0; c < out.count; ++c) {
      out.value[c] = c < limbs_.joints[limb].size() ? rad_[limbs_.joints[limb][c]] : 0;
    }
  }
  msg::MissionState& mission = mission_.loan();
  mission.stamp = step.now;
  mission.phase_since = begin_;
  mission.phase = t > last * each + hold_s_ ? msg::MissionPhase::done : msg::MissionPhase::hold;
  return rt::StepStatus::ok;
}

}  // namespace sinew::kid
