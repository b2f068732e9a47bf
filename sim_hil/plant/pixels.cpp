#include "sim_hil/plant/pixels.hpp"

#include <algorithm>
#include <cstddef>

#include "math/random.hpp"

namespace sinew::plant {
namespace {

int luma(int r, int g, int b) { return ((66 * r + 129 * g + 25 * b + 128) >> 8) + 16; }

void row_to_yuyv(const std::uint8_t* in, std::uint32_t pairs, std::uint8_t* out) {
  for (std::uint32_t i = 0; i < pairs; ++i, in += 8, out += 4) {
    const int r0 = in[0], g0 = in[1], b0 = in[2], r1 = in[4], g1 = in[5], b1 = in[6];
    const int r = r0 + r1, g = g0 + g1, b = b0 + b1;  // twice the mean: shift by one more
    out[0] = static_cast<std::uint8_t>(luma(r0, g0, b0));
    out[1] = static_cast<std::uint8_t>(((-38 * r - 74 * g + 112 * b + 256) >> 9) + 128);
    out[2] = static_cast<std::uint8_t>(luma(r1, g1, b1));
    out[3] = static_cast<std::uint8_t>(((112 * r - 94 * g - 18 * b + 256) >> 9) + 128);
  }
}

void row_to_rgb(const std::uint8_t* in, std::uint32_t width, bool bgr, std::uint8_t* out) {
  for (std::uint32_t i = 0; i < width; ++i, in += 4, out += 3) {
    out[0] = in[bgr ? 2 : 0];
    out[1] = in[1];
    out[2] = in[bgr ? 0 : 2];
  }
}

void row_to_mono(const std::uint8_t* in, std::uint32_t width, std::uint8_t* out) {
  for (std::uint32_t i = 0; i < width; ++i, in += 4) out[i] = static_cast<std::uint8_t>(luma(in[0], in[1], in[2]));
}

}  // namespace

void convert_image(const std::uint8_t* rgbx, std::uint32_t width, std::uint32_t height, msg::PixelFormat format,
                   std::uint8_t* out, FirstRow first) {
  const std::size_t out_row = std::size_t{width} * msg::bytes_per_pixel(format);
  for (std::uint32_t y = 0; y < height; ++y, out += out_row) {
    const std::uint8_t* in = rgbx + std::size_t{first == FirstRow::top ? y : height - 1 - y} * width * 4;
    switch (format) {
      case msg::PixelFormat::yuyv:
        row_to_yuyv(in, width / 2, out);
        break;
      case msg::PixelFormat::rgb8:
      case msg::PixelFormat::bgr8:
        row_to_rgb(in, width, format == msg::PixelFormat::bgr8, out);
        break;
      case msg::PixelFormat::mono8:
        row_to_mono(in, width, out);
        break;
      case msg::PixelFormat::none:
        break;
    }
  }
}

bool has_pattern(const std::uint8_t* rgbx, std::uint32_t width, std::uint32_t height) {
  for (std::size_t i = 1; i < std::size_t{width} * height; ++i)
    if (rgbx[4 * i + 1] != rgbx[1]) return true;
  return false;
}

PixelNoise::PixelNoise(double sigma, std::uint64_t seed) : on_(sigma > 0), seed_(seed) {
  math::Random noise(seed, 0x70697865);
  for (std::int8_t& v : table_) {
    const double x = sigma * noise.normal();
    v = static_cast<std::int8_t>(std::clamp(x < 0 ? x - 0.5 : x + 0.5, -127.0, 127.0));
  }
}

void PixelNoise::add(std::uint8_t* image, std::uint32_t row_bytes, std::uint32_t rows, std::uint32_t frame) const {
  math::Random place(seed_, 0x66726d65, frame);
  for (std::uint32_t y = 0; y < rows; ++y, image += row_bytes) {
    const std::int8_t* from = table_ + (place.next_u32() & (kTable - 1));
    // Behind its entry the table holds 4096 values: a longer row begins again at the entry.
    for (std::uint32_t x = 0; x < row_bytes; x += 4096) {
      const std::uint32_t n = std::min(row_bytes - x, 4096u);
      for (std::uint32_t i = 0; i < n; ++i) {
        const int v = image[x + i] + from[i];
        image[x + i] = static_cast<std::uint8_t>(v < 0 ? 0 : v > 255 ? 255 : v);
      }
    }
  }
}

}  // namespace sinew::plant
