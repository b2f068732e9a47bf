#pragma once
// Writes PNG files for tests.
#include <png.h>

#include <cstdint>
#include <cstring>
#include <vector>

namespace sinew::dataset::test {

/// Encodes rows of `channels` (1 grey, 3 colour, 4 with alpha) at `depth` bits (8, or 16 in network order).
inline std::vector<std::uint8_t> encode_png(const std::vector<std::uint8_t>& rows, std::uint32_t width,
                                            std::uint32_t height, int channels, int depth = 8,
                                            bool interlaced = false) {
  std::vector<std::uint8_t> out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &out,
      [](png_structp p, png_bytep data, png_size_t n) {
        auto* to = static_cast<std::vector<std::uint8_t>*>(png_get_io_ptr(p));
        to->insert(to->end(), data, data + n);
      },
      nullptr);
  const int colour = channels == 1   ? PNG_COLOR_TYPE_GRAY
                     : channels == 3 ? PNG_COLOR_TYPE_RGB
                                     : PNG_COLOR_TYPE_RGB_ALPHA;
  png_set_IHDR(png, info, width, height, depth, colour, interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  const std::size_t stride = std::size_t{width} * unsigned(channels) * unsigned(depth / 8);
  std::vector<std::uint8_t> copy = rows;
  std::vector<png_bytep> row;
  for (std::uint32_t y = 0; y < height; ++y) row.push_back(copy.data() + y * stride);
  png_write_image(png, row.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return out;
}

}  // namespace sinew::dataset::test
