#include "soccer/sight/picture.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

/// What an entry of the table adds to the sums.
constexpr std::array<std::uint64_t, 16> kCounts = [] {
  std::array<std::uint64_t, 16> out{};
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = ((i & FieldColours::kColourBits) != static_cast<std::size_t>(Colour::carpet) ? 1 : 0) |
             std::uint64_t{(i & FieldColours::kBright) != 0} << 32;
  return out;
}();

}  // namespace

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
    const std::uint64_t* above = sum_.data() + y * wide + 1;
    std::uint64_t* sum = sum_.data() + (y + 1) * wide;
    *sum++ = 0;
    std::uint64_t row = 0;
    for (std::size_t p = 0; p < pairs; ++p, in += 4, out += 2, sum += 2, above += 2) {
      const std::uint8_t* chroma = table + (static_cast<std::size_t>(in[1] >> 2) << 6 | in[3] >> 2);
      const std::uint8_t a = chroma[static_cast<std::size_t>(in[0] >> 4) << 12];
      const std::uint8_t b = chroma[static_cast<std::size_t>(in[2] >> 4) << 12];
      out[0] = a & FieldColours::kColourBits, out[1] = b & FieldColours::kColourBits;
      row += kCounts[a];
      sum[0] = row + above[0];
      row += kCounts[b];
      sum[1] = row + above[1];
    }
  }
  return true;
}

}  // namespace sinew::soccer
