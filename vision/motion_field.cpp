#include "vision/motion_field.hpp"

namespace sinew::vision {

void MotionField::declare(rt::Declaration& d) {
  d.in("image", image_);
  d.out("field", field_);
  older_.declare_state(d);
  d.state(detector_, older_stamp_);
  d.param(
      "bin", bin_,
      {.unit = "px",
       .min = 1,
       .max = 4,
       .doc = "1, 2 or 4: averages squares of so many pixels first; sees faster motion, less texture; at the start"});
  d.param("noise_grey", options_.noise_grey,
          {.min = 0.1, .max = 50, .doc = "deviation of a pixel between frames of a still scene, grey levels"});
  d.param("significance", options_.significance, {.min = 1, .max = 100, .doc = "in deviations of noise"});
  d.param("min_speed_px", options_.min_speed_px,
          {.unit = "px", .min = 0, .max = 10, .doc = "per frame; slower is still"});
  d.param("moving_fraction", options_.moving_fraction,
          {.min = 0.01, .max = 1, .doc = "share of the textured cells that must move"});
  d.param("travel_smoothing", travel_.smoothing, {.min = 0.01, .max = 1, .doc = "weight of the newest frame"});
  d.param("travel_speed_px", travel_.speed_px, {.unit = "px", .min = 0, .max = 50, .doc = "per frame, smoothed"});
}

hal::Status MotionField::configure(rt::Setup& setup) {
  if (bin_ != 1 && bin_ != 2 && bin_ != 4) {
    setup.explain("bin: 1, 2 or 4");
    return hal::Error{hal::Errc::bad_argument, "vision::MotionField: bin", bin_};
  }
  const std::size_t pixels = setup.image_pixels(image_) / static_cast<std::size_t>(bin_ * bin_);
  older_ = Luma(pixels);
  newer_ = Luma(pixels);
  return {};
}

void MotionField::reset() {
  older_.clear();
  detector_.reset();
}

void MotionField::scale(msg::MotionField& field) const {
  const double s = static_cast<double>(bin_);
  field.mean_x *= s, field.mean_y *= s;
  field.speed_x_px *= s, field.speed_y_px *= s;
  for (float& v : field.x) v *= static_cast<float>(bin_);
  for (float& v : field.y) v *= static_cast<float>(bin_);
}

rt::StepStatus MotionField::step(const rt::Step&) noexcept {
  const msg::Image* image = image_.get();
  if (image == nullptr || !image_.updated()) return rt::StepStatus::stale;
  if (!newer_.take(view(*image), static_cast<std::uint32_t>(bin_))) return rt::StepStatus::fault;
  const msg::Duration interval = image->stamp - older_stamp_;
  const bool first = older_.empty();
  if (!first && interval.count() <= 0) return rt::StepStatus::fault;

  msg::MotionField& out = field_.loan();
  const bool done = !first && estimate_motion(older_.view(), newer_.view(), options_, out);
  older_.swap(newer_);
  older_stamp_ = image->stamp;
  if (!done) return rt::StepStatus::stale;
  out.stamp = image->stamp;
  out.interval_ns = interval.count();
  scale(out);
  out.moving = detector_.update(out, travel_);
  return rt::StepStatus::ok;
}

}  // namespace sinew::vision
