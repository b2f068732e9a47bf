#include "vision/ball_detector.hpp"

#include "rt/zone.hpp"

namespace sinew::vision {

void BallDetector::declare(rt::Declaration& d) {
  d.in("image", image_);
  d.out("sighting", sighting_);
  camera_.declare(d);
  d.param("radius_m", radius_m_, {.unit = "m", .min = 0, .max = 10, .doc = "of the ball; 0: unknown, no range"});
  d.param("range_max_m", range_max_m_,
          {.unit = "m", .min = 0, .max = 1000, .doc = "what would be farther away is no ball; 0: any"});
  colour_.declare(d, look_.colour, "of the ball");
  d.param("fill_min", look_.fill_min, {.min = 0.1, .max = 1, .doc = "of its circle that has the colour; at the start"});
  d.param("coverage_min", look_.coverage_min,
          {.min = 0.1, .max = 1, .doc = "of its outline that is round; at the start"});
}

hal::Status BallDetector::configure(rt::Setup&) {
  finder_ = std::make_unique<BallFinder>(look_, colour_.limits());
  return {};
}

BallImage BallDetector::find(const ImageView& pixels, const Pinhole& camera, const rt::Step& step) {
  {
    const rt::Zone zone(step, "segment");
    if (!finder_->segment(pixels)) return {};
  }
  const rt::Zone zone(step, "outline");
  return finder_->outline(pixels, camera);
}

rt::StepStatus BallDetector::step(const rt::Step& step) noexcept {
  const msg::Image* image = image_.get();
  if (image == nullptr || !image_.updated()) return rt::StepStatus::stale;
  const ImageView pixels = view(*image);
  if (!pixels || pixels.format == msg::PixelFormat::mono8) return rt::StepStatus::fault;

  const BallImage ball = find(pixels, camera_.of(pixels), step);
  msg::BallSighting& out = sighting_.loan();
  out.stamp = image->stamp;
  out.blobs = ball.blobs;
  out.range_m = math::kNan;
  const double range_m = ball.found && radius_m_ > 0 ? radius_m_ / math::sin(ball.angular_radius_rad) : math::kNan;
  if (!ball.found || (range_max_m_ > 0 && range_m > range_max_m_)) return rt::StepStatus::ok;
  out.found = 1;
  out.direction_optical = ball.direction.to<msg::Vec3>();
  out.u_px = ball.u_px, out.v_px = ball.v_px;
  out.radius_px = ball.radius_px;
  out.angular_radius_rad = ball.angular_radius_rad;
  out.range_m = range_m;
  out.confidence = ball.confidence;
  return rt::StepStatus::ok;
}

}  // namespace sinew::vision
