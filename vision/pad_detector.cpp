#include "vision/pad_detector.hpp"

#include "rt/zone.hpp"

namespace sinew::vision {

void PadDetector::declare(rt::Declaration& d) {
  d.in("image", image_);
  d.out("sighting", sighting_);
  d.param("fx_px", intrinsics_.fx_px, {.unit = "px", .min = 0, .max = 1e5, .doc = "0: from fov_y_rad"});
  d.param("fy_px", intrinsics_.fy_px, {.unit = "px", .min = 0, .max = 1e5, .doc = "0: from fov_y_rad"});
  d.param("cx_px", intrinsics_.cx_px, {.unit = "px", .min = 0, .max = 1e5, .doc = "0: middle of the image"});
  d.param("cy_px", intrinsics_.cy_px, {.unit = "px", .min = 0, .max = 1e5, .doc = "0: middle of the image"});
  d.param("fov_y_rad", fov_y_rad_, {.unit = "rad", .min = 0.05, .max = 3.0, .doc = "from top to bottom"});
  d.param("radius_m", look_.radius_m, {.unit = "m", .min = 0.01, .max = 10, .doc = "of the pad; at the start"});
  d.param("mark_radius_m", look_.mark_radius_m,
          {.unit = "m", .min = 0, .max = 10, .doc = "inner edge of the bright ring, 0: none; at the start"});
  HueSector& c = look_.colour;
  d.param("hue_from_deg", c.hue_from_deg, {.unit = "deg", .min = 0, .max = 360, .doc = "of the pad; at the start"});
  d.param("hue_to_deg", c.hue_to_deg, {.unit = "deg", .min = 0, .max = 360, .doc = "of the pad; at the start"});
  d.param("saturation_min", c.saturation_min, {.min = 0, .max = 1, .doc = "at the start"});
  d.param("value_min", c.value_min, {.min = 0, .max = 1, .doc = "at the start"});
  d.param("min_area_px", min_area_px_, {.unit = "px", .min = 1, .max = 1e6, .doc = "of a region; at the start"});
  d.param("max_runs", max_runs_, {.min = 100, .max = 1e6, .doc = "memory for runs of pixels; at the start"});
}

hal::Status PadDetector::configure(rt::Setup&) {
  const SegmentationLimits limits{.colours = 1,
                                  .max_runs = static_cast<std::uint32_t>(max_runs_),
                                  .min_area_px = static_cast<std::uint32_t>(min_area_px_)};
  finder_ = std::make_unique<PadFinder>(look_, limits);
  return {};
}

Pinhole PadDetector::camera(const ImageView& image) const {
  return Pinhole::from_fov(fov_y_rad_, image.width, image.height).or_given(intrinsics_);
}

PadCircle PadDetector::find(const ImageView& pixels, const rt::Step& step) {
  {
    const rt::Zone zone(step, "segment");
    if (!finder_->segment(pixels)) return {};
  }
  const rt::Zone zone(step, "outline");
  return finder_->outline(pixels);
}

rt::Status PadDetector::step(const rt::Step& step) noexcept {
  const msg::Image* image = image_.get();
  if (image == nullptr || !image_.updated()) return rt::Status::stale;
  const ImageView pixels = view(*image);
  if (!pixels || pixels.format == msg::PixelFormat::mono8) return rt::Status::fault;

  const PadCircle pad = find(pixels, step);
  msg::PadSighting& out = sighting_.loan();
  out.stamp = image->stamp;
  out.blobs = pad.blobs;
  out.range_m = math::kNan;
  if (!pad.found) return rt::Status::ok;
  const Pinhole p = camera(pixels);
  out.found = 1;
  out.u_px = pad.circle.x, out.v_px = pad.circle.y;
  out.radius_px = pad.circle.radius;
  out.direction_optical = p.direction(out.u_px, out.v_px);
  out.range_m = math::sqrt(p.fx_px * p.fy_px) * pad.radius_m / pad.circle.radius / out.direction_optical.z;
  out.confidence = pad.confidence;
  return rt::Status::ok;
}

}  // namespace sinew::vision
