#include "robots/gripper/field_place.hpp"

#include "math/linear.hpp"
#include "soccer/world/field_at.hpp"

namespace sinew::gripper {

using namespace std::chrono_literals;

void FieldPlace::declare(rt::Declaration& d) {
  d.in("state", state_, {.max_age = 200ms});
  d.out("pose", pose_);
  d.param("start_x_m", start_x_m_, {.unit = "m", .min = -10, .max = 10, .doc = "where it started: along the field"});
  d.param("start_y_m", start_y_m_, {.unit = "m", .min = -10, .max = 10, .doc = "and across the field"});
  d.param("start_heading_deg", start_heading_deg_,
          {.unit = "deg", .min = -180, .max = 180, .doc = "where it looked: 0 along the field"});
  d.param("start_sigma_m", start_sigma_m_, {.unit = "m", .min = 0.001, .max = 1, .doc = "how well that is known"});
  d.param("way_sigma", way_sigma_, {.min = 0, .max = 1, .doc = "error of its way, as a share of it"});
  d.param("heading_sigma_rad", heading_sigma_rad_, {.unit = "rad", .min = 0.001, .max = 1, .doc = "of its heading"});
  d.state(way_m_, x_m_, y_m_);
}

void FieldPlace::reset() { way_m_ = x_m_ = y_m_ = 0; }

rt::StepStatus FieldPlace::step(const rt::Step& step) noexcept {
  const msg::NavState* state = state_.fresh(step.now);
  if (!state) return rt::StepStatus::stale;
  way_m_ += math::hypot(state->p_world_m.x - x_m_, state->p_world_m.y - y_m_);
  x_m_ = state->p_world_m.x, y_m_ = state->p_world_m.y;
  const soccer::FieldAt start{start_x_m_, start_y_m_, start_heading_deg_ * math::kPi / 180};
  const soccer::FieldAt at = start.then({x_m_, y_m_, math::Quat(state->q_world_base).yaw()});
  const double sigma_m = start_sigma_m_ + way_sigma_ * way_m_;
  msg::FieldPose& pose = pose_.loan();
  pose.stamp = state->stamp;
  pose.x_m = at.x_m, pose.y_m = at.y_m, pose.heading_rad = at.heading_rad;
  pose.covariance[0] = pose.covariance[4] = sigma_m * sigma_m;
  pose.covariance[8] = heading_sigma_rad_ * heading_sigma_rad_;
  pose.mirrored = 0;
  pose.found = 1;
  return rt::StepStatus::ok;
}

}  // namespace sinew::gripper
