#pragma once
#include <cstdint>
#include <vector>

#include "rt/declaration.hpp"
#include "vision/image_view.hpp"

namespace sinew::vision {

/// Its own grey picture, made from mono8 or the Y of yuyv, averaged over squares of `bin` x `bin` pixels.
/// Thread:  owner.   RT: yes, except the constructor (configure only).
class Luma {
 public:
  Luma() = default;
  explicit Luma(std::size_t max_pixels) : pixels_(max_pixels) {}
  /// False, and empty, for other formats, bins other than 1, 2 and 4, and pictures that do not fit.
  bool take(const ImageView& image, std::uint32_t bin);
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

}  // namespace sinew::vision
