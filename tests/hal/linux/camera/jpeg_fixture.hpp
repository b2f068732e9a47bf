#pragma once
#include <turbojpeg.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace sinew::hal {

struct Rgb {
  std::uint8_t r, g, b;
};

/// The picture's colour at a place: it changes slowly in both directions, so that no subsampling changes it much.
inline Rgb colour_at(std::uint32_t x, std::uint32_t y, std::uint32_t number = 0) {
  return {static_cast<std::uint8_t>(40 + x / 8 + number), static_cast<std::uint8_t>(200 - y / 8),
          static_cast<std::uint8_t>(60 + (x + y) / 16)};
}

/// That picture as the JPEG of a camera.
inline std::vector<std::uint8_t> jpeg_of(std::uint32_t width, std::uint32_t height, int subsampling,
                                         std::uint32_t number = 0) {
  std::vector<std::uint8_t> rgb;
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x) {
      const Rgb c = colour_at(x, y, number);
      rgb.insert(rgb.end(), {c.r, c.g, c.b});
    }
  tjhandle handle = tjInitCompress();
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  tjCompress2(handle, rgb.data(), static_cast<int>(width), 0, static_cast<int>(height), TJPF_RGB, &bytes, &size,
              subsampling, 95, 0);
  std::vector<std::uint8_t> jpeg(bytes, bytes + size);
  tjFree(bytes);
  tjDestroy(handle);
  return jpeg;
}

/// Source:  JFIF 1.02, conversion to and from RGB.
struct Ycc {
  double y, cb, cr;
};
inline Ycc ycc_of(Rgb c) {
  return {0.299 * c.r + 0.587 * c.g + 0.114 * c.b, 128 - 0.168736 * c.r - 0.331264 * c.g + 0.5 * c.b,
          128 + 0.5 * c.r - 0.418688 * c.g - 0.081312 * c.b};
}
inline bool close(double is, double wanted) { return std::fabs(is - wanted) <= 5; }

}  // namespace sinew::hal
