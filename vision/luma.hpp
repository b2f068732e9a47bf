#pragma once
#include <cstdint>
#include <vector>

#include "rt/declaration.hpp"
#include "vision/image_view.hpp"
#include "vision/simd.hpp"

namespace sinew::vision {

/// Its own grey picture, made from mono8 or the Y of yuyv, averaged over squares of `bin` x `bin` pixels.
/// Thread:  owner.   RT: yes, except the constructor (configure only).
class Luma {
 public:
  Luma() = default;
  explicit Luma(std::size_t max_pixels) : pixels_(max_pixels) {}
  /// False, and empty, for other formats, bins other than 1, 2, 4 and 8, and pictures that do not fit. Scalar and SIMD
  /// give the same bytes.
  bool take(const ImageView& image, std::uint32_t bin, Simd simd = best_simd());
  void declare_state(rt::Declaration& d) { d.state(pixels_, width_, height_); }
  void clear() { width_ = height_ = 0; }
  bool empty() const { return width_ == 0; }
  ImageView view() const {
    if (empty()) return {};
    return {pixels_.data(), width_, height_, width_, msg::PixelFormat::mono8};
  }
  void swap(Luma& other) noexcept {
    pixels_.swap(other.pixels_);
    std::swap(width_, other.width_), std::swap(height_, other.height_);
  }

 private:
  std::vector<std::uint8_t> pixels_;
  std::uint32_t width_ = 0, height_ = 0;
};

namespace detail {
/// Averages bins, of each row as many as fill whole vectors, from the first on. `width` and
/// `height` are the result's. Answers how many columns are done.
using BinColumns = std::uint32_t (*)(const ImageView& image, std::uint32_t width, std::uint32_t height,
                                     std::uint8_t* out);
/// Null: by the scalar kernel alone.
BinColumns bin_columns_avx2(bool yuyv, std::uint32_t bin);
}  // namespace detail

}  // namespace sinew::vision
