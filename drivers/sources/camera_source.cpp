#include "drivers/sources/camera_source.hpp"

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
  asked_exposure_us_ = kLeftAloneUs, asked_gain_ = kLeftAlone;
  exposure_.reset(), gain_control_.reset();
  controls_ = dynamic_cast<hal::CameraControls*>(camera_);
  if (controls_) exposure_ = controls_->exposure(), gain_control_ = controls_->gain();
  const auto exposure_fits = setup.narrow("exposure_us", exposure_range());
  const auto gain_fits = setup.narrow("gain", gain_range());
  if (!exposure_fits) return exposure_fits;
  if (!gain_fits) return gain_fits;
  set_what_changed();
  return {};
}

/// The range of one control in units of the parameter; only `left_alone` where nobody can set it.
rt::ParamRange CameraSource::range_of(std::optional<std::size_t> control, double unit, double left_alone) const {
  const std::string device = "device '" + device_name_ + "'";
  if (!control)
    return {left_alone,
            left_alone,
            {},
            device + " has no such control" + (controls_ ? "; it has: " + controls_->list() : "")};
  const hal::CameraControl& c = controls_->controls()[*control];
  const std::string which = "control '" + c.name + "' of " + device;
  if (c.read_only) return {left_alone, left_alone, {}, which + " is read only"};
  return {c.min * unit, c.max * unit, left_alone, which};
}

rt::ParamRange CameraSource::exposure_range() const {
  if (!exposure_) return range_of({}, 1, kLeftAloneUs);
  if (exposure_->automatic) {
    const hal::CameraControl& c = controls_->controls()[*exposure_->automatic];
    if (c.read_only || exposure_->manual < c.min || exposure_->manual > c.max)
      return {
          kLeftAloneUs, kLeftAloneUs, {}, "device '" + device_name_ + "' always chooses it by itself: " + to_text(c)};
  }
  return range_of(exposure_->control, unit_us(), kLeftAloneUs);
}

rt::ParamRange CameraSource::gain_range() const { return range_of(gain_control_, 1, kLeftAlone); }

double CameraSource::unit_us() const noexcept {
  return std::chrono::duration<double, std::micro>(exposure_->unit).count();
}

/// The camera takes every value within the ranges; the device itself reports what becomes of it later.
void CameraSource::set_what_changed() noexcept {
  if (exposure_us_ != asked_exposure_us_ && exposure_us_ > kLeftAloneUs) static_cast<void>(set_exposure());
  if (gain_ != asked_gain_ && gain_ > kLeftAlone) static_cast<void>(controls_->request(*gain_control_, gain_));
  asked_exposure_us_ = exposure_us_, asked_gain_ = gain_;
}

hal::Status CameraSource::set_exposure() noexcept {
  if (exposure_->automatic) {
    if (const auto manual = controls_->request(*exposure_->automatic, exposure_->manual); !manual) return manual;
  }
  return controls_->request(exposure_->control, exposure_us_ / unit_us());
}

void CameraSource::collect(rt::Time) noexcept {
  set_what_changed();
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

/// Publishes what the camera has filled, without a copy, and lends the camera other slots. False: from now on pictures
/// are read().
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
