// The library that programs load when a robot has a camera of libcamera.
#include "hal/linux/camera/libcamera_plugin.hpp"
#include "hal/linux/libcamera/libcamera_camera.hpp"

extern "C" __attribute__((visibility("default"))) void sinew_open_libcamera(
    const sinew::hal::CameraSpec& spec, sinew::hal::Os& os, std::string& why,
    sinew::hal::Result<std::unique_ptr<sinew::hal::Camera>>& out) {
  auto camera = sinew::hal::open_libcamera_camera(spec, os, why);
  if (camera)
    out = std::unique_ptr<sinew::hal::Camera>(std::move(*camera));
  else
    out = camera.error();
}
