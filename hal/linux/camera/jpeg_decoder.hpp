#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "msg/image.hpp"

namespace sinew::hal {

/// Decodes the JPEG pictures of cameras (MJPEG) straight into images of one format and size, in one pass: mono8, rgb8,
/// bgr8. Not yuyv: the library has no packed luma and chroma, so it would take planes of our own and a second pass.
/// Values:  mono8 is JPEG's Y, over the full range 0 to 255 (JFIF).
/// Thread:  one at a time.
/// RT:      bounded by the size of the picture; our code does not allocate, but libjpeg-turbo does for each picture.
/// Errors:  a picture that is broken in any way (also one that the library would only warn about), or of another size
///          than the image, is refused; the pixels then are unspecified.
/// Source:  ITU-T T.81 by libjpeg-turbo's TurboJPEG interface, if Sinew was built with it.
class JpegDecoder {
 public:
  /// True if this build can decode at all.
  static bool built();
  /// True if it can decode into such images.
  static bool gives(msg::PixelFormat format);

  struct Shape {
    std::uint32_t width = 0, height = 0;
    bool is_grey = false;
  };
  /// What the picture's head says. None: it has none that can be read.
  static std::optional<Shape> shape_of(std::span<const std::uint8_t> jpeg);

  JpegDecoder(msg::PixelFormat format, std::uint32_t width, std::uint32_t height);
  ~JpegDecoder();
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  /// `out` is already described with the decoder's format and size.
  bool decode(std::span<const std::uint8_t> jpeg, msg::Image& out) noexcept;

 private:
  struct Library;
  std::unique_ptr<Library> library_;  // null: not built, or no memory
};

}  // namespace sinew::hal
