#include "robots/mixed/orange_ball.hpp"

#include "soccer/sight/ground_view.hpp"

namespace sinew::mixed {

using namespace std::chrono_literals;

void OrangeBall::declare(rt::Declaration& d) {
  d.in("game", sight_, {.max_age = 1s});
  d.in("ball", ball_, {.max_age = 1s});
  d.in("camera", camera_, {.depth = 4});
  d.out("sight", out_);
  optics_.declare(d);
  d.param("width_px", width_px_, {.unit = "px", .min = 16, .max = 8192, .doc = "of the pictures"});
  d.param("height_px", height_px_, {.unit = "px", .min = 16, .max = 8192, .doc = "of the pictures"});
  d.param("ball_radius_m", radius_m_, {.unit = "m", .min = 0.02, .max = 0.2, .doc = "of the ball"});
  d.param("confidence", confidence_, {.min = 0.05, .max = 1, .doc = "the share of such sightings that are the ball"});
}

rt::StepStatus OrangeBall::step(const rt::Step& step) noexcept {
  const msg::SoccerSight* sight = sight_.fresh(step.now);
  const msg::BallSighting* ball = ball_.fresh(step.now);
  if (!sight || !ball || ball->stamp != sight->stamp) return rt::StepStatus::stale;
  const msg::CameraPose* pose = nullptr;
  for (const msg::CameraPose& p : camera_)
    if (p.stamp == sight->stamp) pose = &p;
  if (!pose) return rt::StepStatus::stale;
  msg::SoccerSight& out = out_.loan();
  out = *sight;
  out.balls = 0;
  if (ball->found == 0) return rt::StepStatus::ok;
  const vision::Pinhole camera = vision::Pinhole::from_fov(optics_.fov_y_rad, static_cast<std::uint32_t>(width_px_),
                                                           static_cast<std::uint32_t>(height_px_))
                                     .or_given(optics_.given);
  const soccer::GroundView view(camera, *pose, {sight->x_m, sight->y_m, sight->heading_rad}, {});
  const auto at = view.is_upright() ? view.at_height(ball->u_px, ball->v_px, radius_m_) : std::nullopt;
  if (!at) return rt::StepStatus::ok;
  out.balls = 1;
  msg::SeenBall& seen = out.ball[0];
  seen.at = view.with_covariance(*at, view.errors().pixel_px, radius_m_);
  seen.u_px = static_cast<float>(ball->u_px), seen.v_px = static_cast<float>(ball->v_px);
  seen.radius_px = static_cast<float>(ball->radius_px);
  seen.confidence = static_cast<float>(confidence_);
  return rt::StepStatus::ok;
}

}  // namespace sinew::mixed
