#include "drivers/camera_source.hpp"

namespace sinew::drivers {

hal::Status CameraSource::configure(rt::Setup& setup) {
  auto camera = setup.board().camera(device_name_);
  if (!camera) {
    setup.explain("device '" + device_name_ + "': " + hal::to_string(camera.error().code));
    return camera.error();
  }
  camera_ = *camera;
  return find_controls(setup);
}

hal::Status CameraSource::find_controls(rt::Setup& setup) {
  asked_exposure_us_ = 0, asked_gain_ = -1;
  exposure_.reset(), gain_control_.reset();
  controls_ = dynamic_cast<hal::CameraControls*>(camera_);
  if (controls_) exposure_ = controls_->exposure(), gain_control_ = controls_->gain();
  const auto lacking = [&](const char* param) {
    setup.explain("param '" + std::string(param) + "': the camera has no such control" +
                  (controls_ ? "; it has: " + controls_->list() : ""));
    return hal::Error{hal::Errc::not_supported, "camera control"};
  };
  const auto refused = [&](const char* param, std::size_t control) {
    setup.explain("param '" + std::string(param) + "': the camera allows " + to_text(controls_->controls()[control]));
    return hal::Error{hal::Errc::bad_argument, "camera control"};
  };
  if (exposure_us_ > 0) {
    if (!exposure_) return lacking("exposure_us");
    if (!set_exposure()) return refused("exposure_us", exposure_->control);
  }
  if (gain_ >= 0) {
    if (!gain_control_) return lacking("gain");
    if (!controls_->request(*gain_control_, gain_)) return refused("gain", *gain_control_);
  }
  asked_exposure_us_ = exposure_us_, asked_gain_ = gain_;
  return {};
}

hal::Status CameraSource::set_exposure() noexcept {
  const double unit_us = std::chrono::duration<double, std::micro>(exposure_->unit).count();
  if (exposure_->automatic) {
    if (const auto manual = controls_->request(*exposure_->automatic, exposure_->manual); !manual) return manual;
  }
  return controls_->request(exposure_->control, exposure_us_ / unit_us);
}

void CameraSource::collect(rt::Time) noexcept {
  // A parameter that has changed; what the camera cannot take is not asked for again.
  if (exposure_us_ != asked_exposure_us_ && exposure_us_ > 0 && exposure_) static_cast<void>(set_exposure());
  if (gain_ != asked_gain_ && gain_ >= 0 && gain_control_) static_cast<void>(controls_->request(*gain_control_, gain_));
  asked_exposure_us_ = exposure_us_, asked_gain_ = gain_;
  while (msg::Image* image = raw_.loan()) {
    const auto got = camera_->read(*image);
    if (got && *got) {
      image->stamp = image->stamp + hal::Duration{static_cast<std::int64_t>(time_offset_ms_ * 1e6)};
      continue;
    }
    raw_.cancel();
    return;  // nothing is ready, or this frame is lost: the next cycle goes on
  }
}

}  // namespace sinew::drivers
