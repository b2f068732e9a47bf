#include "vision/pad_detector.hpp"

#include "rt/zone.hpp"

namespace sinew::vision {

void PadDetector::declare(rt::Declaration& d) {
  d.in("image", image_);
  d.out("sighting", sighting_);
  camera_.declare(d);
  d.param("radius_m", look_.radius_m, {.unit = "m", .min = 0.01, .max = 10, .doc = "of the pad; at the start"});
  d.param("mark_radius_m", look_.mark_radius_m,
          {.unit = "m", .min = 0, .max = 10, .doc = "inner edge of the bright ring, 0: none; at the start"});
  colour_.declare(d, look_.colour, "of the pad");
}

hal::Status PadDetector::configure(rt::Setup&) {
  finder_ = std::make_unique<PadFinder>(look_, colour_.limits());
  return {};
}

PadCircle PadDetector::find(const ImageView& pixels, const rt::Step& step) {
  {
    const rt::Zone zone(step, "segment");
    if (!finder_->segment(pixels)) return {};
  }
  const rt::Zone zone(step, "outline");
  return finder_->outline(pixels);
}

rt::StepStatus PadDetector::step(const rt::Step& step) noexcept {
  const msg::Image* image = image_.get();
  if (image == nullptr || !image_.updated()) return rt::StepStatus::stale;
  const ImageView pixels = view(*image);
  if (!pixels || pixels.format == msg::PixelFormat::mono8) return rt::StepStatus::fault;

  const PadCircle pad = find(pixels, step);
  msg::PadSighting& out = sighting_.loan();
  out.stamp = image->stamp;
  out.blobs = pad.blobs;
  out.range_m = math::kNan;
  if (!pad.found) return rt::StepStatus::ok;
  const Pinhole p = camera_.of(pixels);
  out.found = 1;
  out.u_px = pad.circle.x, out.v_px = pad.circle.y;
  out.radius_px = pad.circle.radius;
  out.direction_optical = p.direction(out.u_px, out.v_px);
  out.range_m = math::sqrt(p.fx_px * p.fy_px) * pad.radius_m / pad.circle.radius / out.direction_optical.z;
  out.confidence = pad.confidence;
  return rt::StepStatus::ok;
}

}  // namespace sinew::vision
