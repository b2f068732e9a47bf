#include "soccer/sight/sight.hpp"

#include "rt/zone.hpp"

namespace sinew::soccer {

using namespace std::chrono_literals;

void Sight::declare(rt::Declaration& d) {
  d.in("image", image_);
  d.in("pose", pose_);
  d.in("gait", gait_, {.max_age = 100ms});
  d.out("sight", sight_);
  camera_.declare(d);
  d.param("camera", number_, {.min = 0, .max = 1, .doc = "which of the body's, for those who read the message"});
  d.param("ball_radius_m", options_.ball_radius_m,
          {.unit = "m", .min = 0.02, .max = 0.2, .doc = "of the ball that is played with"});
  d.param("ball_farthest_m", options_.ball_farthest_m,
          {.unit = "m", .min = 0.5, .max = 14, .doc = "beyond it no ball is looked for"});
  d.param("ball_confidence", options_.ball_confidence,
          {.min = 0.01, .max = 0.999, .doc = "sightings that are less sure are left out"});
  d.param("circle_radius_m", options_.circle_radius_m,
          {.unit = "m", .min = 0.2, .max = 3, .doc = "of the centre circle"});
  d.param("tilt_sigma_rad", options_.errors.tilt_rad,
          {.unit = "rad", .min = 0, .max = 0.3, .doc = "by which the camera looks higher or lower than its pose says"});
  d.param("heading_sigma_rad", options_.errors.heading_rad,
          {.unit = "rad", .min = 0, .max = 0.3, .doc = "how sure the camera's heading is, against the body"});
  d.param("pixel_sigma_px", options_.errors.pixel_px, {.unit = "px", .min = 0.1, .max = 20, .doc = "of an edge"});
  d.param("carpet_luma", start_.luma,
          {.min = 6, .max = 235, .doc = "of the carpet, until a picture shows it: sinew-sight colours measures it"});
  d.param("carpet_u", start_.u, {.min = -0.5, .max = 0.06, .doc = "its chroma u, as a share of luma + 16"});
  d.param("carpet_v", start_.v, {.min = -0.6, .max = -0.07, .doc = "its chroma v, likewise"});
  d.param("carpet_spread", start_.spread, {.min = 0.001, .max = 0.2, .doc = "standard deviation of these"});
  d.state(carpet_);
}

hal::Status Sight::configure(rt::Setup&) {
  look_ = std::make_unique<FieldSight>(options_);
  return {};
}

void Sight::reset() { carpet_ = start_; }

rt::StepStatus Sight::step(const rt::Step& step) noexcept {
  const msg::CameraPose* pose = pose_.get();
  const msg::Image* image = image_.get();
  const msg::GaitState* gait = gait_.fresh(step.now);
  if (!pose || !pose_.updated() || !image || !gait || image->stamp != pose->stamp) return rt::StepStatus::stale;
  const vision::ImageView pixels = vision::view(*image);
  if (!pixels || pixels.format != msg::PixelFormat::yuyv || pixels.width > options_.most_width ||
      pixels.height > options_.most_height)
    return rt::StepStatus::fault;

  const double dt = 1e-9 * static_cast<double>(pose->stamp.ns - gait->stamp.ns);
  const math::SinCos t = math::sincos(gait->heading_rad);
  const RobotAt robot{gait->x_m + dt * (t.cos * gait->forward_mps - t.sin * gait->left_mps),
                      gait->y_m + dt * (t.sin * gait->forward_mps + t.cos * gait->left_mps),
                      gait->heading_rad + dt * gait->turn_radps};
  const GroundView view(camera_.of(pixels), *pose, robot, options_.errors);
  msg::SoccerSight& out = sight_.loan();
  out.stamp = pose->stamp;
  out.x_m = robot.x_m, out.y_m = robot.y_m, out.heading_rad = robot.heading_rad;
  out.camera = static_cast<std::uint32_t>(number_);
  look_->options() = options_;
  look_->set_carpet(carpet_);
  {
    const rt::Zone zone(step, "look");
    look_->look(pixels, view, out);
  }
  carpet_ = look_->carpet();
  return rt::StepStatus::ok;
}

}  // namespace sinew::soccer
