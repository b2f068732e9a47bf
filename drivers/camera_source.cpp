#include "drivers/camera_source.hpp"

namespace sinew::drivers {

hal::Status CameraSource::configure(rt::Setup& setup) {
  auto camera = setup.board().camera(device_name_);
  if (!camera) {
    setup.explain("device '" + device_name_ + "': " + hal::to_string(camera.error().code));
    return camera.error();
  }
  camera_ = *camera;
  if (auto found = find_memory(setup); !found) return found;
  return find_controls(setup);
}

hal::Status CameraSource::find_memory(rt::Setup& setup) {
  memory_ = dynamic_cast<hal::CameraMemory*>(camera_);
  if (!memory_) return {};
  std::string why;
  const auto images = memory_->begin_lending(setup.image_bytes(raw_), why);
  if (images) {
    setup.hold(raw_, *images);
    return {};
  }
  memory_ = nullptr;
  if (images.error().code != hal::Errc::bad_argument) return {};  // read() copies
  setup.explain("device '" + device_name_ + "': " + why);
  return images.error();
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
  if (memory_ && collect_lent()) return;
  while (msg::Image* image = raw_.loan()) {
    const auto got = camera_->read(*image);
    if (got && *got) {
      shift(*image);
      continue;
    }
    raw_.cancel();
    return;  // nothing is ready, or this frame is lost: the next cycle goes on
  }
}

void CameraSource::shift(msg::Image& image) const noexcept {
  image.stamp = image.stamp + hal::Duration{static_cast<std::int64_t>(time_offset_ms_ * 1e6)};
}

/// What the camera has filled is published where it lies, and the camera gets other slots for it. False: pictures are
/// read() from now on.
bool CameraSource::collect_lent() noexcept {
  bool goes_on = true;
  for (std::uint32_t i = 0; i < kBurst; ++i) {
    const auto filled = memory_->take_filled();
    if (!filled) goes_on = filled.error().code != hal::Errc::not_supported;
    if (!filled || !*filled) break;
    shift(**filled);
    static_cast<void>(raw_.publish(**filled));  // within the burst
  }
  while (msg::Image* image = goes_on ? raw_.hold() : nullptr) {
    const auto lent = memory_->lend(*image);
    if (lent) continue;
    raw_.put_back(*image);
    goes_on = lent.error().code != hal::Errc::not_supported;
    break;  // the next cycle tries again
  }
  if (goes_on) return true;
  take_back();
  return false;
}

void CameraSource::take_back() noexcept {
  while (msg::Image* image = memory_->take_back()) raw_.put_back(*image);
}

void CameraSource::rest(rt::Time) noexcept {
  if (memory_) take_back();
}

void CameraSource::end() noexcept {
  if (!memory_) return;
  memory_->stop_lending();
  take_back();
}

}  // namespace sinew::drivers
