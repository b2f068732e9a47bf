#include "vision/luma.hpp"

#include <cstring>

namespace sinew::vision {
namespace {

/// `step` bytes from one grey value to the next: 1 for mono8, 2 for yuyv.
void bin_row(const ImageView& image, std::uint32_t y, std::uint32_t step, std::uint32_t bin, std::uint32_t width,
             std::uint8_t* out) {
  const std::uint32_t half = bin * bin / 2;
  for (std::uint32_t x = 0; x < width; ++x) {
    std::uint32_t sum = half;
    for (std::uint32_t i = 0; i < bin; ++i) {
      const std::uint8_t* p = image.row(y * bin + i) + std::size_t{x} * bin * step;
      for (std::uint32_t k = 0; k < bin; ++k) sum += p[std::size_t{k} * step];
    }
    out[x] = static_cast<std::uint8_t>(sum / (bin * bin));
  }
}

}  // namespace

bool Luma::take(const ImageView& image, std::uint32_t bin) {
  clear();
  using msg::PixelFormat;
  if (!image || (image.format != PixelFormat::mono8 && image.format != PixelFormat::yuyv)) return false;
  if (bin != 1 && bin != 2 && bin != 4) return false;
  const std::uint32_t width = image.width / bin, height = image.height / bin;
  if (width == 0 || height == 0 || std::size_t{width} * height > pixels_.size()) return false;
  const std::uint32_t step = image.format == PixelFormat::yuyv ? 2 : 1;
  for (std::uint32_t y = 0; y < height; ++y) {
    std::uint8_t* out = pixels_.data() + std::size_t{y} * width;
    if (step == 1 && bin == 1)
      std::memcpy(out, image.row(y), width);
    else if (bin == 1)
      for (std::uint32_t x = 0; x < width; ++x) out[x] = image.row(y)[2 * x];
    else
      bin_row(image, y, step, bin, width, out);
  }
  width_ = width, height_ = height;
  return true;
}

}  // namespace sinew::vision
