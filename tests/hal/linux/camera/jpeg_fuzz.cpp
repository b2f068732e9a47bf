// Any bytes as a camera's JPEG: the first one chooses the format of the decoded picture.
#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/linux/camera/jpeg_decoder.hpp"
#include "msg/image_buffer.hpp"

using namespace sinew;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::uint32_t kWidth = 33, kHeight = 17;
  constexpr std::array kFormats{msg::PixelFormat::mono8, msg::PixelFormat::rgb8, msg::PixelFormat::bgr8};
  if (size == 0) return 0;
  const msg::PixelFormat format = kFormats[data[0] % kFormats.size()];
  static std::array<hal::JpegDecoder, 3> decoders{
      {{kFormats[0], kWidth, kHeight}, {kFormats[1], kWidth, kHeight}, {kFormats[2], kWidth, kHeight}}};
  msg::ImageBuffer image(format, kWidth, kHeight);  // of exactly this size: the sanitizer sees a byte beyond
  decoders[data[0] % kFormats.size()].decode({data + 1, size - 1}, *image);
  return 0;
}
