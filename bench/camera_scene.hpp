#pragma once
// What cameras of tests and benches see, as yuyv.
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace sinew::bench {

/// Squares that move, and much noise.
class NoisySquares {
 public:
  /// Paints one row after the other; `row(y)` is where a row goes.
  template <class Row>
  void paint(std::uint32_t frame, std::uint32_t width, std::uint32_t height, const Row& row) {
    for (std::uint32_t y = 0; y < height; ++y) {
      std::uint8_t* const to = row(y);
      for (std::uint32_t x = 0; x < width; ++x) {
        const std::uint32_t square = ((x + 3 * frame) / 24 + y / 24) % 3;
        noise_ = noise_ * 1664525u + 1013904223u;
        to[2 * x] = static_cast<std::uint8_t>(40 + 70 * square + (x + y) / 16 + (noise_ >> 29));
        to[2 * x + 1] = static_cast<std::uint8_t>(x % 2 == 0 ? 128 + 20 * square : 120);
      }
    }
  }

 private:
  std::uint32_t noise_ = 1;
};

/// Soft shading, discs that move, and the noise of a good camera; the pictures repeat.
class ShadedDiscs {
 public:
  ShadedDiscs(std::uint32_t width, std::uint32_t height) : width_(width), height_(height) {
    for (std::uint32_t p = 0; p < pictures_.size(); ++p) paint(p);
  }
  const std::vector<std::uint8_t>& picture(std::uint32_t frame) const { return pictures_[frame % pictures_.size()]; }

 private:
  void paint(std::uint32_t number) {
    std::vector<std::uint8_t>& to = pictures_[number];
    to.resize(std::size_t{2} * width_ * height_);
    for (std::uint32_t i = 0; i < width_ * height_; ++i) {
      const int x = static_cast<int>(i % width_), y = static_cast<int>(i / width_);
      int luma = 70 + x / 13 + y / 12, u = 128, v = 128;
      for (int d = 0; d < 12; ++d) {
        const int dx = x - (50 + d % 4 * 170 + static_cast<int>(3 * number) * (d % 3)), dy = y - (70 + d / 4 * 160);
        const int r = 14 + 3 * d;
        if (dx * dx + dy * dy < r * r) luma = 60 + 12 * d, u = 90 + 60 * (d % 2), v = 100 + 20 * (d % 4);
      }
      to[2 * i] = static_cast<std::uint8_t>(luma + noise(5) - 2);
      to[2 * i + 1] = static_cast<std::uint8_t>((i % 2 == 0 ? u : v) + noise(3) - 1);
    }
  }
  int noise(std::uint32_t levels) {
    noise_ = noise_ * 1664525u + 1013904223u;
    return static_cast<int>((noise_ >> 24) % levels);
  }

  const std::uint32_t width_, height_;
  std::array<std::vector<std::uint8_t>, 8> pictures_;
  std::uint32_t noise_ = 1;
};

}  // namespace sinew::bench
