#include "drivers/camera_source.hpp"

namespace sinew::drivers {

hal::Status CameraSource::configure(rt::Setup& setup) {
  auto camera = setup.board().camera(device_name_);
  if (!camera) {
    setup.explain("device '" + device_name_ + "': " + hal::to_string(camera.error().code));
    return camera.error();
  }
  camera_ = *camera;
  return {};
}

void CameraSource::collect(rt::Time) noexcept {
  while (msg::Image* image = raw_.loan()) {
    const auto got = camera_->read(*image);
    if (got && *got) continue;
    raw_.cancel();
    return;  // nothing is ready, or this frame is lost: the next cycle goes on
  }
}

}  // namespace sinew::drivers
