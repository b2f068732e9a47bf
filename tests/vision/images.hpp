#pragma once
// Images for tests: pixels in a vector, and scenes painted from a function.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <vector>

#include "math/random.hpp"
#include "vision/colour_table.hpp"
#include "vision/image_view.hpp"

namespace sinew::vision::test {

/// Pixels without a message; `slack` bytes of padding behind each row hold 0xAA.
class Pixels {
 public:
  Pixels(msg::PixelFormat f, std::uint32_t width, std::uint32_t height, std::uint32_t slack = 0)
      : view_{nullptr, width, height, width * msg::bytes_per_pixel(f) + slack, f},
        // A vector of exactly this size, so that a sanitizer sees the first read behind it.
        bytes_(std::size_t{view_.stride} * (height - 1) + view_.stride - slack, 0xAA) {}
  ImageView view() const {
    ImageView v = view_;
    v.data = bytes_.data();
    return v;
  }
  std::uint8_t* row(std::uint32_t y) { return bytes_.data() + std::size_t{y} * view_.stride; }
  std::vector<std::uint8_t>& bytes() { return bytes_; }

 private:
  ImageView view_;
  std::vector<std::uint8_t> bytes_;
};

/// An image message with pixels, as in a slot.
class Message {
 public:
  explicit Message(std::uint32_t capacity)
      : memory_(std::make_unique<std::max_align_t[]>((sizeof(msg::Image) + capacity) / sizeof(std::max_align_t) + 1)),
        image_(new (memory_.get()) msg::Image) {
    image_->set_bulk_capacity(capacity);
  }
  Message(msg::PixelFormat f, std::uint32_t width, std::uint32_t height)
      : Message(width * height * msg::bytes_per_pixel(f)) {
    if (!image_->format_as(f, width, height)) std::abort();
  }
  msg::Image& operator*() { return *image_; }
  msg::Image* operator->() { return image_; }

 private:
  std::unique_ptr<std::max_align_t[]> memory_;
  msg::Image* image_;
};

inline void fill_noise(std::uint8_t* p, std::size_t n, std::uint64_t seed) {
  math::Random random(seed);
  for (std::size_t i = 0; i < n; ++i) p[i] = static_cast<std::uint8_t>(random.next_u32() >> 24);
}

/// Paints yuyv from colour(x, y) -> Rgb, chroma as the mean of two pixels.
template <class Colour>
void paint_yuyv(std::uint8_t* pixels, std::uint32_t width, std::uint32_t height, const Colour& colour) {
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; x += 2) {
      const Yuv a = to_yuv(colour(x, y)), b = to_yuv(colour(x + 1, y));
      std::uint8_t* p = pixels + (std::size_t{y} * width + x) * 2;
      p[0] = static_cast<std::uint8_t>(a.y), p[1] = static_cast<std::uint8_t>((a.u + b.u) / 2);
      p[2] = static_cast<std::uint8_t>(b.y), p[3] = static_cast<std::uint8_t>((a.v + b.v) / 2);
    }
}

}  // namespace sinew::vision::test
