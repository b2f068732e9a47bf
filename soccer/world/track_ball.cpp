#include "soccer/world/track_ball.hpp"

#include <algorithm>

#include "rt/zone.hpp"
#include "soccer/sight/ground_view.hpp"

namespace sinew::soccer {

using namespace std::chrono_literals;

namespace {

constexpr double kEdge_px = 12;       // so near to the picture's edge a ball is easily missed
constexpr double kHidden_rad = 0.12;  // a robot this near to the ball's direction, and nearer, may hide it

bool may_be_hidden(const msg::SoccerSight& sight, const FieldPoint& ball) {
  const double far = math::hypot(ball.x_m, ball.y_m), way = math::atan2(ball.y_m, ball.x_m);
  for (std::uint32_t i = 0; i < std::min<std::size_t>(sight.robots, sight.robot.size()); ++i) {
    const msg::GroundPoint& r = sight.robot[i].at;
    const double turn = math::fabs(math::wrap_pi(math::atan2(double{r.y_m}, double{r.x_m}) - way));
    if (math::hypot(r.x_m, r.y_m) < far + 0.2 && turn < kHidden_rad + 0.15 / std::max(0.3, far)) return true;
  }
  return false;
}

}  // namespace

void TrackBall::declare(rt::Declaration& d) {
  d.in("sight", sight_, {.depth = 4});
  d.in("sight2", sight2_, {.depth = 4, .optional = true});
  d.in("camera", camera_, {.depth = 4, .optional = true});
  d.in("camera2", camera2_, {.depth = 4, .optional = true});
  d.in("field", field_, {.max_age = 1s, .optional = true});
  d.out("ball", out_);
  optics_.declare(d);
  d.param("width_px", width_px_, {.unit = "px", .min = 16, .max = 8192, .doc = "of the pictures"});
  d.param("height_px", height_px_, {.unit = "px", .min = 16, .max = 8192, .doc = "of the pictures"});
  d.param("ball_radius_m", ball_radius_m_, {.unit = "m", .min = 0.02, .max = 0.2, .doc = "of the ball"});
  d.param("seen_to_m", farthest_m_, {.unit = "m", .min = 0.3, .max = 14, .doc = "so far a picture must show it"});
  BallOptions& o = filter_.options();
  d.param("deceleration_mps2", o.deceleration_mps2,
          {.unit = "m/s^2", .min = 0.01, .max = 5, .doc = "of a rolling ball"});
  d.param("sight_scale", o.sight_scale, {.min = 0.05, .max = 5, .doc = "of the sightings' standard deviations"});
  d.param("rest_mps", o.rest_mps, {.unit = "m", .min = 0, .max = 1, .doc = "a resting ball is elsewhere after 1 s"});
  d.param("push_mps2", o.push_mps2, {.unit = "m/s", .min = 0, .max = 10, .doc = "a rolling ball's speed after 1 s"});
  d.param("way_sigma_m", o.way_sigma, {.unit = "m", .min = 0, .max = 1, .doc = "error of the odometry after 1 m"});
  d.param("kick_mps", o.kick_mps, {.unit = "m/s", .min = 0.1, .max = 10, .doc = "speed of a ball that starts to roll"});
  d.param("gate", o.gate, {.min = 2, .max = 200, .doc = "squared error beyond which it is another ball"});
  d.param("seen_share", o.seen_share, {.min = 0.05, .max = 0.95, .doc = "of the pictures that must show it, at least"});
  d.param("forget_s", o.forget_s,
          {.unit = "s", .min = 0.5, .max = 600, .doc = "a ball out of sight becomes improbable"});
  d.param("evidence_s", o.evidence_s, {.unit = "s", .min = 0.1, .max = 60, .doc = "in which evidence fades"});
  d.state(filter_.state());
}

void TrackBall::take(const msg::SoccerSight& sight, const rt::InQueue<msg::CameraPose>& poses) {
  const std::span<const FieldPoint> predicted = filter_.predict(sight);
  std::array<bool, BallFilter::kMost> shown{};
  for (const msg::CameraPose& pose : poses) {
    if (pose.stamp != sight.stamp) continue;
    const vision::Pinhole camera = vision::Pinhole::from_fov(optics_.fov_y_rad, static_cast<std::uint32_t>(width_px_),
                                                             static_cast<std::uint32_t>(height_px_))
                                       .or_given(optics_.given);
    const GroundView view(camera, pose, {sight.x_m, sight.y_m, sight.heading_rad}, {});
    if (!view.is_upright()) break;
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      const FieldPoint& p = predicted[i];
      const PixelAt at = view.pixel({p.x_m, p.y_m, ball_radius_m_});
      shown[i] = at.depth_m > 0 && at.u_px > kEdge_px && at.v_px > kEdge_px &&
                 at.u_px < static_cast<double>(width_px_) - kEdge_px &&
                 at.v_px < static_cast<double>(height_px_) - kEdge_px && math::hypot(p.x_m, p.y_m) < farthest_m_ &&
                 !may_be_hidden(sight, p);
    }
    break;
  }
  filter_.see(sight, {shown.data(), predicted.size()});
}

rt::StepStatus TrackBall::step(const rt::Step& step) noexcept {
  if (sight_.empty() && sight2_.empty()) return rt::StepStatus::stale;
  {
    const rt::Zone zone(step, "ball");
    for (const msg::SoccerSight& s : sight_) take(s, camera_);
    for (const msg::SoccerSight& s : sight2_) take(s, camera2_);
  }
  msg::BallModel& out = out_.loan();
  out.stamp = {filter_.state().stamp_ns};
  filter_.fill(out);
  if (const msg::FieldPose* f = field_.fresh(step.now)) {
    const FieldPoint at = FieldAt{f->x_m, f->y_m, f->heading_rad}.out(out.x_m, out.y_m);
    out.field_x_m = at.x_m, out.field_y_m = at.y_m;
  }
  return rt::StepStatus::ok;
}

}  // namespace sinew::soccer
