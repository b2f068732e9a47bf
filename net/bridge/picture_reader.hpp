#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "dataset/png_image.hpp"
#include "hal/linux/camera/jpeg_decoder.hpp"
#include "msg/image.hpp"

namespace sinew::net {

/// Pictures that come as files, JPEG or PNG, into images: grey to mono8, colour to rgb8. What a file is, its first
/// bytes say. Keeps its buffers. Thread:  one at a time.   RT: no.
class PictureReader {
 public:
  /// Null: done. Else why not: neither kind, damaged, too large for the image, or this build has no JPEG.
  const char* read(std::span<const std::uint8_t> file, msg::Image& out);

 private:
  const char* read_jpeg(std::span<const std::uint8_t> file, msg::Image& out);
  const char* read_png(std::span<const std::uint8_t> file, msg::Image& out);

  std::unique_ptr<hal::JpegDecoder> jpeg_;  // for pictures such as the last one
  hal::JpegDecoder::Shape jpeg_shape_;
  dataset::DecodedImage png_;
};

}  // namespace sinew::net
