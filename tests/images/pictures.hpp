#pragma once
// Pictures for tests, and what each pixel of them is by the definition of their format.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "images/encode.hpp"

namespace sinew::images::test {

using Rgb = std::array<int, 3>;

/// A slope with some texture, rows `slack` bytes longer than they need; the padding holds 0xAA. The vector ends with
/// the last row's pixels, so that a sanitizer sees the first read behind them.
class Picture {
 public:
  Picture(msg::PixelFormat format, std::uint32_t width, std::uint32_t height, std::uint32_t slack = 0)
      : format_(format), width_(width), height_(height) {
    const std::uint32_t whole = format == msg::PixelFormat::yuyv ? (width + 1) / 2 * 2 : width;
    const std::uint32_t row = whole * msg::bytes_per_pixel(format);
    stride_ = row + slack;
    bytes_.assign(std::size_t{stride_} * (height - 1) + row, 0xAA);
    for (std::uint32_t y = 0; y < height; ++y)
      for (std::uint32_t i = 0; i < row; ++i) {
        const std::uint32_t channels = format == msg::PixelFormat::yuyv ? 4 : msg::bytes_per_pixel(format);
        const std::uint32_t texture = (i / channels * 5 + y * 3) % 7;  // of luma: JPEG halves the colour's resolution
        bytes_[std::size_t{stride_} * y + i] =
            static_cast<std::uint8_t>(40 + 30 * (i % channels) + 70 * i / row + 40 * y / height + texture);
      }
  }
  PixelView view() const { return {bytes_, width_, height_, stride_, format_}; }
  std::vector<std::uint8_t>& bytes() { return bytes_; }

  /// BT.601 with limited range, in doubles, for yuyv.
  Rgb at(std::uint32_t x, std::uint32_t y) const {
    const std::uint8_t* p = bytes_.data() + std::size_t{stride_} * y;
    switch (format_) {
      case msg::PixelFormat::mono8:
        return {p[x], p[x], p[x]};
      case msg::PixelFormat::rgb8:
        return {p[3 * x], p[3 * x + 1], p[3 * x + 2]};
      case msg::PixelFormat::bgr8:
        return {p[3 * x + 2], p[3 * x + 1], p[3 * x]};
      default:
        break;
    }
    const std::uint8_t* pair = p + x / 2 * 4;
    const double luma = (pair[x % 2 * 2] - 16.0) * 255 / 219, u = (pair[1] - 128.0) * 255 / 224,
                 v = (pair[3] - 128.0) * 255 / 224;
    const auto whole = [](double value) { return static_cast<int>(std::clamp(value, 0.0, 255.0) + 0.5); };
    return {whole(luma + 1.402 * v), whole(luma - 0.344136 * u - 0.714136 * v), whole(luma + 1.772 * u)};
  }

  /// The average of an area of k x k pixels, rounded.
  Rgb mean(std::uint32_t left, std::uint32_t top, std::uint32_t k) const {
    Rgb sum{};
    for (std::uint32_t y = 0; y < k; ++y)
      for (std::uint32_t x = 0; x < k; ++x)
        for (std::size_t c = 0; c < 3; ++c) sum[c] += at(left + x, top + y)[c];
    const int area = int(k * k);
    for (int& value : sum) value = (value + area / 2) / area;
    return sum;
  }

 private:
  msg::PixelFormat format_;
  std::uint32_t width_, height_, stride_ = 0;
  std::vector<std::uint8_t> bytes_;
};

inline constexpr msg::PixelFormat kFormats[] = {msg::PixelFormat::mono8, msg::PixelFormat::rgb8, msg::PixelFormat::bgr8,
                                                msg::PixelFormat::yuyv};

/// What a decoder made of a file.
struct Decoded {
  std::uint32_t width = 0, height = 0, channels = 0;
  std::vector<std::uint8_t> pixels;  // grey or R, G, B
  Rgb at(std::uint32_t x, std::uint32_t y) const {
    const std::size_t i = (std::size_t{width} * y + x) * channels;
    return channels == 1 ? Rgb{pixels[i], pixels[i], pixels[i]} : Rgb{pixels[i], pixels[i + 1], pixels[i + 2]};
  }
};

/// The largest difference of any channel; rgb(x, y) is what the pixel should be.
template <class Expected>
int largest_difference(const Decoded& image, const Expected& rgb) {
  int largest = 0;
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const Rgb is = image.at(x, y), should = rgb(x, y);
      for (std::size_t c = 0; c < 3; ++c) largest = std::max(largest, std::abs(is[c] - should[c]));
    }
  return largest;
}

/// Peak signal to noise ratio in dB.
template <class Expected>
double psnr_db(const Decoded& image, const Expected& rgb) {
  double sum = 0;
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const Rgb is = image.at(x, y), should = rgb(x, y);
      for (std::size_t c = 0; c < 3; ++c) sum += (is[c] - should[c]) * (is[c] - should[c]);
    }
  const double mean = sum / (3.0 * image.width * image.height);
  return mean == 0 ? 99 : 10 * std::log10(255 * 255 / mean);
}

}  // namespace sinew::images::test
