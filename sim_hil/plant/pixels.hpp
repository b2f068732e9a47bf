#pragma once
#include <cstdint>

#include "msg/image.hpp"

namespace sinew::plant {

/// Which row of a picture comes first in memory: OpenGL's bottom, or the top.
enum class FirstRow : std::uint8_t { bottom, top };

/// Turns pixels of R, G, B, x bytes into a camera's image (top row first, no padding) in one pass. YUYV is BT.601 with
/// the limited range of ordinary cameras: Y 16..235, U and V 16..240; chroma is the mean of a pair. mono8 is the same
/// Y. Shape:   width x height pixels of 4 bytes in, of bytes_per_pixel(format) out; even width for yuyv.
void convert_image(const std::uint8_t* rgbx, std::uint32_t width, std::uint32_t height, msg::PixelFormat format,
                   std::uint8_t* out, FirstRow first = FirstRow::bottom);

/// Whether any two of the pixels that OpenGL reads back differ in green.
bool has_pattern(const std::uint8_t* rgbx, std::uint32_t width, std::uint32_t height);

/// Adds sensor noise to an image: a fixed table of normal deviates (sigma in grey levels), entered at a random place
/// per row. Chroma bytes of yuyv get it as well. The same bytes for the same seed and frame.
class PixelNoise {
 public:
  PixelNoise(double sigma, std::uint64_t seed);
  void add(std::uint8_t* image, std::uint32_t row_bytes, std::uint32_t rows, std::uint32_t frame) const;
  bool on() const { return on_; }

 private:
  static constexpr std::uint32_t kTable = 1u << 14;
  bool on_;
  std::uint64_t seed_;
  std::int8_t table_[kTable + 4096];
};

}  // namespace sinew::plant
