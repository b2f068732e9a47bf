#include "images/box_filter.hpp"

namespace sinew::images {
namespace {

template <std::uint32_t kChannels>
void reduce_pixels(const std::uint32_t* sums, std::uint32_t pixels, std::uint32_t width, std::uint32_t out_width,
                   std::uint32_t height, std::uint8_t* out) {
  // The half makes the quotient exact: it is then further from any whole number than the rounding of the product.
  const std::uint32_t area = width * height;
  const double each = 1.0 / area, half = area / 2 + 0.5;
  std::uint32_t left_of_pixel = out_width;
  for (std::uint32_t x = 0; x < pixels; ++x) {
    std::uint32_t total[kChannels] = {};
    for (std::uint32_t left = width; left > 0;) {
      const std::uint32_t weight = std::min(left, left_of_pixel);
      for (std::uint32_t c = 0; c < kChannels; ++c) total[c] += weight * sums[c];
      left -= weight, left_of_pixel -= weight;
      if (left_of_pixel == 0) sums += kChannels, left_of_pixel = out_width;
    }
    for (std::uint32_t c = 0; c < kChannels; ++c) *out++ = static_cast<std::uint8_t>((total[c] + half) * each);
  }
}

}  // namespace

bool BoxFilter::start(Size in, Size out, std::uint32_t channels) {
  const std::uint32_t across = std::gcd(in.width, out.width), down = std::gcd(in.height, out.height);
  width_ = in.width / across, out_width_ = out.width / across;
  height_ = in.height / down, out_height_ = out.height / down;
  channels_ = channels, pixels_out_ = out.width;
  count_ = std::size_t{in.width} * channels;
  y_ = 0, left_of_row_ = out_height_;
  return sums_.at_least(count_) != nullptr;
}

void BoxFilter::reduce(std::uint8_t* out) const {
  if (channels_ == 1)
    reduce_pixels<1>(sums_.get(), pixels_out_, width_, out_width_, height_, out);
  else
    reduce_pixels<3>(sums_.get(), pixels_out_, width_, out_width_, height_, out);
}

}  // namespace sinew::images
