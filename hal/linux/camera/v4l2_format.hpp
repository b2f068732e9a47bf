#pragma once
// The identity of a V4L2 device, and the picture agreed with it.
#include <cstdint>
#include <string>
#include <vector>

#include "hal/connectors.hpp"
#include "hal/linux/camera/v4l2_port.hpp"

namespace sinew::hal {

/// The device's own description (VIDIOC_QUERYCAP).
struct V4l2Identity {
  std::string card, driver, bus_info;
  bool captures = false;     // gives pictures, in buffers of one plane
  bool multiplanar = false;  // gives them in buffers of several planes only: not supported here
  bool streams = false;
};
/// Errors:  not_supported: not a video device; closed: gone; io.
Result<V4l2Identity> v4l2_identify(V4l2Port& port, int fd);

/// The picture as agreed with the driver.
struct V4l2Picture {
  msg::PixelFormat format = msg::PixelFormat::none;
  std::uint32_t width = 0, height = 0;
  bool is_jpeg = false;              // comes as MJPEG, and is decoded into `format`
  std::uint32_t bytes_per_line = 0;  // >= width * bytes per pixel; 0 for a JPEG
  std::uint32_t image_bytes = 0;
  double rate_hz = 0;  // 0: the driver does not say
};

/// Brings the device to the asked format, size and rate: exactly these, or an error with what it offers. The format is
/// not changed before it is known to be offered. A picture that the device has only as MJPEG is taken so, where it can
/// be decoded.
/// Errors:  not_supported: the device has no such format; bad_argument: not this size or rate; busy; io. `why` names
///          what was asked, what was got and what there is.
/// Source:  Linux Media Infrastructure userspace API, part I: 1.21 Data Formats, VIDIOC_ENUM_FMT,
///          VIDIOC_ENUM_FRAMESIZES, VIDIOC_ENUM_FRAMEINTERVALS, VIDIOC_S_FMT, VIDIOC_S_PARM.
Result<V4l2Picture> v4l2_agree(V4l2Port& port, int fd, const CameraSpec& spec, std::string& why);

/// "YUYV (YUYV 4:2:2): 640x480 at 30, 15 frames/s, 320x240 ...; MJPG ...", for people.
std::string v4l2_offers(V4l2Port& port, int fd);

/// The V4L2 name of a format that images can have; 0: none.
std::uint32_t v4l2_code(msg::PixelFormat format);

}  // namespace sinew::hal
