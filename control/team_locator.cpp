#include "control/team_locator.hpp"

#include "math/elementary.hpp"

namespace sinew::control {
namespace {

using namespace std::chrono_literals;

constexpr double kRadPerDeg = math::kPi / 180;

msg::PlaceEstimate to_message(msg::Time stamp, const Place& place) {
  return {stamp, place.p_m.to<msg::Vec3>(), place.covariance_m2.a};
}

math::Mat3 diagonal(double variance) {
  math::Mat3 m;
  for (int i = 0; i < 3; ++i) m(i, i) = variance;
  return m;
}

}  // namespace

void TeamLocator::declare(rt::Declaration& d) {
  d.in("state", state_, {.max_age = 100ms});
  d.in("mate_pad", mate_pad_, {.optional = true});
  d.out("pose", pose_);
  d.out("pad", pad_);
  d.out("told_pad", told_pad_);
  d.param("start_x_m", start_x_m_,
          {.unit = "m", .min = -1e5, .max = 1e5, .doc = "where it starts, in the team's frame"});
  d.param("start_y_m", start_y_m_, {.unit = "m", .min = -1e5, .max = 1e5, .doc = "likewise"});
  d.param("start_yaw_deg", start_yaw_deg_,
          {.unit = "deg", .min = -360, .max = 360, .doc = "its direction there, counter-clockwise from the team's x"});
  d.param("start_std_m", start_std_m_,
          {.unit = "m", .min = 1e-4, .max = 100, .doc = "how well that place is known, 1 sigma"});
  d.param("start_std_deg", start_std_deg_, {.unit = "deg", .min = 1e-3, .max = 90, .doc = "and that direction"});
  d.param("pad_std_m", pad_std_m_,
          {.unit = "m", .min = 1e-4, .max = 100, .doc = "how well the pad is seen from the own place, 1 sigma"});
}

/// The frame of NavState, in the team's.
UncertainPose TeamLocator::start() const {
  UncertainPose pose;
  pose.p_m = {start_x_m_, start_y_m_, 0};
  const auto half = math::sincos(start_yaw_deg_ * kRadPerDeg / 2);
  pose.q = {half.cos, 0, 0, half.sin};
  const double yaw_std = start_std_deg_ * kRadPerDeg;
  for (int i = 0; i < 3; ++i) pose.covariance(i, i) = start_std_m_ * start_std_m_;
  pose.covariance(5, 5) = yaw_std * yaw_std;  // the filter levels itself
  return pose;
}

rt::StepStatus TeamLocator::step(const rt::Step& step) noexcept {
  const msg::NavState* state = state_.fresh(step.now);
  if (!state) return rt::StepStatus::stale;
  const UncertainPose frame = start();
  const double p_var = state->p_std_m * state->p_std_m;
  if (state->position_valid) {
    const Place here = to_team(frame, {math::Vec3(state->p_world_m), diagonal(p_var)});
    msg::TeamPose& pose = pose_.loan();
    pose = {};
    pose.stamp = state->stamp;
    pose.p_team_m = here.p_m.to<msg::Vec3>();
    pose.q_team_base = (frame.q * math::Quat(state->q_world_base)).to<msg::Quat>();
    const double tilt_var = state->tilt_std_rad * state->tilt_std_rad;
    const double rotation[] = {tilt_var, tilt_var, frame.covariance(5, 5)};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) pose.covariance[6 * i + j] = here.covariance_m2.a[3 * i + j];
      pose.covariance[6 * (3 + i) + 3 + i] = rotation[i];
    }
  }
  if (state->pad_known) {
    const Place seen{math::Vec3(state->pad_world_m), diagonal(p_var + pad_std_m_ * pad_std_m_)};
    pad_.loan() = to_message(state->stamp, to_team(frame, seen));
  }
  if (const msg::PlaceEstimate* told = mate_pad_.get()) {
    Place in_team;
    in_team.p_m = math::Vec3(told->p_m);
    in_team.covariance_m2.a = told->covariance_m2;
    told_pad_.loan() = to_message(told->stamp, from_team(frame, in_team));
  }
  return rt::StepStatus::ok;
}

}  // namespace sinew::control
