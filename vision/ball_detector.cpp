#include "vision/ball_detector.hpp"

#include "rt/zone.hpp"

namespace sinew::vision {

void BallDetector::declare(rt::Declaration& d) {
  d.in("image", image_);
  d.out("sighting", sighting_);
  d.param("fx_px", intrinsics_.fx_px, {.unit = "px", .min = 0, .max = 1e5, .doc = "0: from fov_y_rad"});
  d.param("fy_px", intrinsics_.fy_px, {.unit = "px", .min = 0, .max = 1e5, .doc = "0: from fov_y_rad"});
  d.param("cx_px", intrinsics_.cx_px, {.unit = "px", .min = 0, .max = 1e5, .doc = "0: middle of the image"});
  d.param("cy_px", intrinsics_.cy_px, {.unit = "px", .min = 0, .max = 1e5, .doc = "0: middle of the image"});
  d.param("fov_y_rad", fov_y_rad_, {.unit = "rad", .min = 0.05, .max = 3.0, .doc = "from top to bottom"});
  d.param("radius_m", radius_m_, {.unit = "m", .min = 0, .max = 10, .doc = "of the ball; 0: unknown, no range"});
  d.param("range_max_m", range_max_m_,
          {.unit = "m", .min = 0, .max = 1000, .doc = "what would be farther away is no ball; 0: any"});
  HueSector& c = look_.colour;
  d.param("hue_from_deg", c.hue_from_deg, {.unit = "deg", .min = 0, .max = 360, .doc = "of the ball; at the start"});
  d.param("hue_to_deg", c.hue_to_deg, {.unit = "deg", .min = 0, .max = 360, .doc = "of the ball; at the start"});
  d.param("saturation_min", c.saturation_min, {.min = 0, .max = 1, .doc = "at the start"});
  d.param("value_min", c.value_min, {.min = 0, .max = 1, .doc = "at the start"});
  d.param("fill_min", look_.fill_min, {.min = 0.1, .max = 1, .doc = "of its circle that has the colour; at the start"});
  d.param("coverage_min", look_.coverage_min,
          {.min = 0.1, .max = 1, .doc = "of its outline that is round; at the start"});
  d.param("min_area_px", min_area_px_, {.unit = "px", .min = 1, .max = 1e6, .doc = "of a region; at the start"});
  d.param("max_runs", max_runs_, {.min = 100, .max = 1e6, .doc = "memory for runs of pixels; at the start"});
}

hal::Status BallDetector::configure(rt::Setup&) {
  const SegmentationLimits limits{.colours = 1,
                                  .max_runs = static_cast<std::uint32_t>(max_runs_),
                                  .min_area_px = static_cast<std::uint32_t>(min_area_px_)};
  finder_ = std::make_unique<BallFinder>(look_, limits);
  return {};
}

Pinhole BallDetector::camera(const ImageView& image) const {
  return Pinhole::from_fov(fov_y_rad_, image.width, image.height).or_given(intrinsics_);
}

BallImage BallDetector::find(const ImageView& pixels, const Pinhole& camera, const rt::Step& step) {
  {
    const rt::Zone zone(step, "segment");
    if (!finder_->segment(pixels)) return {};
  }
  const rt::Zone zone(step, "outline");
  return finder_->outline(pixels, camera);
}

rt::Status BallDetector::step(const rt::Step& step) noexcept {
  const msg::Image* image = image_.get();
  if (image == nullptr || !image_.updated()) return rt::Status::stale;
  const ImageView pixels = view(*image);
  if (!pixels || pixels.format == msg::PixelFormat::mono8) return rt::Status::fault;

  const BallImage ball = find(pixels, camera(pixels), step);
  msg::BallSighting& out = sighting_.loan();
  out.stamp = image->stamp;
  out.blobs = ball.blobs;
  out.range_m = math::kNan;
  const double range_m = ball.found && radius_m_ > 0 ? radius_m_ / math::sin(ball.angular_radius_rad) : math::kNan;
  if (!ball.found || (range_max_m_ > 0 && range_m > range_max_m_)) return rt::Status::ok;
  out.found = 1;
  out.direction_optical = ball.direction.to<msg::Vec3>();
  out.u_px = ball.u_px, out.v_px = ball.v_px;
  out.radius_px = ball.radius_px;
  out.angular_radius_rad = ball.angular_radius_rad;
  out.range_m = range_m;
  out.confidence = ball.confidence;
  return rt::Status::ok;
}

}  // namespace sinew::vision
