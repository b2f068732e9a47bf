#pragma once
// A picture with a meaning for each pixel, and sums over boxes of it.
#include <vector>

#include "soccer/sight/colours.hpp"
#include "vision/image_view.hpp"

namespace sinew::soccer {

/// Shape:   as the yuyv picture that it was read from, at most `most_pixels`.
/// Thread:  owner; all but the constructor is RT: yes.
class Picture {
 public:
  Picture() : Picture(msg::kMaxImageWidth, msg::kMaxImageHeight) {}
  Picture(std::uint32_t most_width, std::uint32_t most_height);
  /// Looks every pixel up. False: no yuyv, or larger than the constructor's sides. `image` is used until the next read.
  bool read(const vision::ImageView& image, const FieldColours& colours);

  int width() const { return width_; }
  int height() const { return height_; }
  bool holds(double u, double v) const { return u >= 0 && v >= 0 && u <= width_ - 1 && v <= height_ - 1; }
  Colour at(int x, int y) const { return static_cast<Colour>(class_[static_cast<std::size_t>(y * width_ + x)]); }
  int luma(int x, int y) const { return image_.row(static_cast<std::uint32_t>(y))[2 * x]; }
  /// u and v of the pair that the pixel is of.
  const std::uint8_t* pair(int x, int y) const { return image_.row(static_cast<std::uint32_t>(y)) + (x & ~1) * 2; }
  /// Pixels that are not carpet in columns x0..x1 and rows y0..y1, both included, cut to the picture; and of how many.
  struct Count {
    int other = 0, bright = 0, all = 0;  // bright: FieldColours::kBright
  };
  Count not_carpet(int x0, int y0, int x1, int y1) const {
    x0 = x0 < 0 ? 0 : x0, y0 = y0 < 0 ? 0 : y0;
    x1 = x1 < width_ ? x1 + 1 : width_, y1 = y1 < height_ ? y1 + 1 : height_;
    if (x1 <= x0 || y1 <= y0) return {};
    const auto wide = static_cast<std::size_t>(width_ + 1);
    const std::uint64_t *const upper = sum_.data() + static_cast<std::size_t>(y0) * wide, *const lower =
                                                                                              sum_.data() +
                                                                                              static_cast<std::size_t>(
                                                                                                  y1) *
                                                                                                  wide;
    const std::uint64_t n = lower[x1] - upper[x1] - lower[x0] + upper[x0];
    return {static_cast<int>(n & 0xffffffffU), static_cast<int>(n >> 32), (x1 - x0) * (y1 - y0)};
  }

 private:
  std::size_t most_width_, most_height_;
  int width_ = 0, height_ = 0;
  vision::ImageView image_;
  std::vector<std::uint8_t> class_;
  std::vector<std::uint64_t> sum_;  // (width + 1) x (height + 1); bright ones in the upper half
};

}  // namespace sinew::soccer
