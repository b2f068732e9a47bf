#include "soccer/sight/picture.hpp"

#include <algorithm>

namespace sinew::soccer {

Picture::Picture(std::uint32_t most_width, std::uint32_t most_height)
    : most_width_(most_width),
      most_height_(most_height),
      class_(most_width_ * most_height_),
      sum_((most_width_ + 1) * (most_height_ + 1)) {}

bool Picture::read(const vision::ImageView& image, const FieldColours& colours) {
  if (!image || image.format != msg::PixelFormat::yuyv || image.width > most_width_ || image.height > most_height_)
    return false;
  image_ = image;
  width_ = static_cast<int>(image.width), height_ = static_cast<int>(image.height);
  const std::uint8_t* const table = colours.table();
  const std::size_t pairs = image.width / 2, wide = image.width + 1;
  std::fill_n(sum_.begin(), wide, 0);
  for (std::uint32_t y = 0; y < image.height; ++y) {
    const std::uint8_t* in = image.row(y);
    std::uint8_t* out = class_.data() + std::size_t{y} * image.width;
    const std::uint32_t* above = sum_.data() + y * wide + 1;
    std::uint32_t* sum = sum_.data() + (y + 1) * wide;
    *sum++ = 0;
    std::uint32_t row = 0;
    for (std::size_t p = 0; p < pairs; ++p, in += 4, out += 2, sum += 2, above += 2) {
      const std::uint8_t* chroma = table + (static_cast<std::size_t>(in[1] >> 2) << 6 | in[3] >> 2);
      out[0] = chroma[static_cast<std::size_t>(in[0] >> 4) << 12];
      out[1] = chroma[static_cast<std::size_t>(in[2] >> 4) << 12];
      row += out[0] != static_cast<std::uint8_t>(Colour::carpet);
      sum[0] = row + above[0];
      row += out[1] != static_cast<std::uint8_t>(Colour::carpet);
      sum[1] = row + above[1];
    }
  }
  return true;
}

Picture::Count Picture::not_carpet(int x0, int y0, int x1, int y1) const {
  x0 = std::max(x0, 0), y0 = std::max(y0, 0);
  x1 = std::min(x1, width_ - 1), y1 = std::min(y1, height_ - 1);
  if (x1 < x0 || y1 < y0) return {};
  const auto wide = static_cast<std::size_t>(width_ + 1);
  const auto sum = [&](int x, int y) { return sum_[static_cast<std::size_t>(y) * wide + static_cast<std::size_t>(x)]; };
  const std::uint32_t n = sum(x1 + 1, y1 + 1) - sum(x0, y1 + 1) - sum(x1 + 1, y0) + sum(x0, y0);
  return {static_cast<int>(n), (x1 - x0 + 1) * (y1 - y0 + 1)};
}

}  // namespace sinew::soccer
