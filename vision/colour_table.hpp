#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "msg/image.hpp"

namespace sinew::vision {

inline constexpr std::uint32_t kMaxColours = 8;

/// A colour as a box in Y, U, V (full range, BT.601), both ends included.
struct ColourBox {
  std::array<std::uint8_t, 3> lo{};  // y, u, v
  std::array<std::uint8_t, 3> hi{};
};

/// A colour as people name it: a sector of hue with enough saturation and value. It keeps its meaning when the light
/// changes; a box in YUV does not.
struct HueSector {
  double hue_from_deg = 0, hue_to_deg = 0;  // 0 red, 120 green, 240 blue; from > to runs through 0
  double saturation_min = 0, saturation_max = 1;
  double value_min = 0, value_max = 1;
};

/// Look-up tables from pixel to colour: 0 is background, 1..kMaxColours the colours, the first that fits wins. One
/// table each for YUV (32 x 64 x 64 cells of y, u, v) and RGB (32 x 64 x 32 cells of r, g, b) from the same colours.
/// Thread:  owner; building is configure only, look-ups are RT: yes.
/// Source:  J. Bruce, T. Balch, M. Veloso, "Fast and inexpensive color image segmentation", IROS 2000 (the idea of
///          thresholds as tables; here one table holds every shape of colour).
class ColourTable {
 public:
  ColourTable();
  /// Colour number of what was added; 0 when there are kMaxColours already.
  std::uint32_t add(const ColourBox& box);
  std::uint32_t add(const HueSector& sector);
  void clear();
  std::uint32_t colours() const { return colours_; }

  static constexpr std::size_t yuv_index(unsigned y, unsigned u, unsigned v) {
    return ((v >> 2) * 64 + (u >> 2)) * 32 + (y >> 3);
  }
  static constexpr std::size_t rgb_index(unsigned r, unsigned g, unsigned b) {
    return ((r >> 3) * 64 + (g >> 2)) * 32 + (b >> 3);
  }
  const std::uint8_t* yuv() const { return yuv_.data(); }
  const std::uint8_t* rgb() const { return rgb_.data(); }

 private:
  template <class Fits>
  std::uint32_t paint(const Fits& fits);

  std::vector<std::uint8_t> yuv_, rgb_;
  std::uint32_t colours_ = 0;
};

struct Rgb {
  int r, g, b;
};
struct Yuv {
  int y, u, v;
};
/// Full-range BT.601 in 1/256 steps, saturated. Integers only, so the same everywhere.
/// Source:  ITU-T T.871 (JFIF) section 7, coefficients times 256, rounded.
Rgb to_rgb(const Yuv& c);
Yuv to_yuv(const Rgb& c);

}  // namespace sinew::vision
