#include "vision/colour_table.hpp"

#include <algorithm>

namespace sinew::vision {

Rgb to_rgb(const Yuv& c) {
  const int u = c.u - 128, v = c.v - 128;
  return {std::clamp(c.y + ((359 * v + 128) >> 8), 0, 255), std::clamp(c.y - ((88 * u + 183 * v + 128) >> 8), 0, 255),
          std::clamp(c.y + ((454 * u + 128) >> 8), 0, 255)};
}

Yuv to_yuv(const Rgb& c) {
  return {std::clamp((77 * c.r + 150 * c.g + 29 * c.b + 128) >> 8, 0, 255),
          std::clamp(128 + ((-43 * c.r - 85 * c.g + 128 * c.b + 128) >> 8), 0, 255),
          std::clamp(128 + ((128 * c.r - 107 * c.g - 21 * c.b + 128) >> 8), 0, 255)};
}

namespace {

bool inside(const ColourBox& box, const Yuv& c) {
  return c.y >= box.lo[0] && c.y <= box.hi[0] && c.u >= box.lo[1] && c.u <= box.hi[1] && c.v >= box.lo[2] &&
         c.v <= box.hi[2];
}

bool inside(const HueSector& s, const Rgb& c) {
  const int hi = std::max({c.r, c.g, c.b}), lo = std::min({c.r, c.g, c.b});
  const double value = hi / 255.0;
  const double saturation = hi > 0 ? double(hi - lo) / hi : 0.0;
  if (value < s.value_min || value > s.value_max || saturation < s.saturation_min || saturation > s.saturation_max)
    return false;
  const double span = s.hue_to_deg - s.hue_from_deg;
  if (hi == lo) return span >= 360.0 || span <= -360.0;  // grey has no hue: only the full circle holds it
  const double chroma = hi - lo;
  double hue_deg = 0;
  if (hi == c.r)
    hue_deg = 60.0 * ((c.g - c.b) / chroma);
  else if (hi == c.g)
    hue_deg = 60.0 * ((c.b - c.r) / chroma) + 120.0;
  else
    hue_deg = 60.0 * ((c.r - c.g) / chroma) + 240.0;
  if (hue_deg < 0) hue_deg += 360.0;
  if (s.hue_from_deg <= s.hue_to_deg) return hue_deg >= s.hue_from_deg && hue_deg <= s.hue_to_deg;
  return hue_deg >= s.hue_from_deg || hue_deg <= s.hue_to_deg;
}

}  // namespace

ColourTable::ColourTable() : yuv_(32 * 64 * 64), rgb_(32 * 64 * 32) {}

void ColourTable::clear() {
  std::fill(yuv_.begin(), yuv_.end(), std::uint8_t{0});
  std::fill(rgb_.begin(), rgb_.end(), std::uint8_t{0});
  colours_ = 0;
}

// A cell belongs to the colour of its centre.
template <class Fits>
std::uint32_t ColourTable::paint(const Fits& fits) {
  if (colours_ == kMaxColours) return 0;
  const auto colour = static_cast<std::uint8_t>(++colours_);
  for (int v = 2; v < 256; v += 4)
    for (int u = 2; u < 256; u += 4)
      for (int y = 4; y < 256; y += 8) {
        const Yuv c{y, u, v};
        std::uint8_t& cell = yuv_[yuv_index(unsigned(y), unsigned(u), unsigned(v))];
        if (cell == 0 && fits(c, to_rgb(c))) cell = colour;
      }
  for (int r = 4; r < 256; r += 8)
    for (int g = 2; g < 256; g += 4)
      for (int b = 4; b < 256; b += 8) {
        const Rgb c{r, g, b};
        std::uint8_t& cell = rgb_[rgb_index(unsigned(r), unsigned(g), unsigned(b))];
        if (cell == 0 && fits(to_yuv(c), c)) cell = colour;
      }
  return colour;
}

std::uint32_t ColourTable::add(const ColourBox& box) {
  return paint([&](const Yuv& yuv, const Rgb&) { return inside(box, yuv); });
}

std::uint32_t ColourTable::add(const HueSector& sector) {
  return paint([&](const Yuv&, const Rgb& rgb) { return inside(sector, rgb); });
}

}  // namespace sinew::vision
