#pragma once
#include <cstdint>

#include "msg/image.hpp"

namespace sinew::vision {

/// The pixels that a kernel may read. Made from a message only when its fields are consistent, so that kernels need no
/// checks of their own and a hostile header cannot lead them outside of the slot.
/// Shape:   height x width, row-major, `stride` bytes from row to row.
/// Owner:   the pixels' owner; a view never outlives a step.
struct ImageView {
  const std::uint8_t* data = nullptr;
  std::uint32_t width = 0, height = 0, stride = 0;
  msg::PixelFormat format = msg::PixelFormat::none;

  explicit operator bool() const { return data != nullptr; }
  const std::uint8_t* row(std::uint32_t y) const { return data + std::size_t{y} * stride; }
};

/// Empty (false) when the message has no pixels, is larger than the capacity says, or is yuyv of odd width.
inline ImageView view(const msg::Image& image) {
  const std::uint64_t row = std::uint64_t{image.width} * msg::bytes_per_pixel(image.format);
  const bool good = row > 0 && image.height > 0 && image.width <= msg::kMaxImageWidth &&
                    image.height <= msg::kMaxImageHeight && image.stride >= row &&
                    std::uint64_t{image.stride} * (image.height - 1) + row <= image.capacity_bytes &&
                    (image.format != msg::PixelFormat::yuyv || image.width % 2 == 0);
  if (!good) return {};
  return {image.pixels(), image.width, image.height, image.stride, image.format};
}

}  // namespace sinew::vision
