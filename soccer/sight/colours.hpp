#pragma once
// What colours mean on a field, in whatever light: the carpet's green is measured in each picture, and the others are
// told by how they differ from it and from grey.
#include <array>
#include <cstdint>
#include <vector>

#include "soccer/sight/ground_view.hpp"
#include "vision/image_view.hpp"

namespace sinew::soccer {

enum class Colour : std::uint8_t { other = 0, carpet = 1, white = 2, dark = 3, blue = 4, red = 5 };

/// The carpet in a picture. Chroma goes with the light: u and v are of 128, as shares of luma (y + kLumaOffset), so
/// that a shadow or another exposure leaves them as they are.
struct CarpetLook {
  double luma = 92;
  double u = -0.19, v = -0.30;
  double spread = 0.03;  // standard deviation of u and v
  friend bool operator==(const CarpetLook&, const CarpetLook&) = default;
};
inline constexpr double kLumaOffset = 16;

/// A colour table that follows the light: 4 bits of y, 6 of u, 6 of v, 64 KiB, of which a picture uses a few lines of
/// cache.
/// Thread:  owner; all but the constructor is RT: yes.
class FieldColours {
 public:
  FieldColours();
  /// Carpet of the next picture. The table is made for this look in coarse steps, and made anew when a step changes: it
  /// depends on nothing that was before.
  void set(const CarpetLook& look);
  const CarpetLook& look() const { return look_; }
  Colour of(unsigned y, unsigned u, unsigned v) const {
    return static_cast<Colour>(table_[index(y, u, v)] & kColourBits);
  }
  /// Entries: a colour, and kBright for what is no carpet, as bright as it or brighter, and not blue.
  static constexpr std::uint8_t kColourBits = 7, kBright = 8;
  const std::uint8_t* table() const { return table_.data(); }
  static constexpr std::size_t index(unsigned y, unsigned u, unsigned v) {
    return (y >> 4) << 12 | (u >> 2) << 6 | (v >> 2);
  }

 private:
  void build();

  CarpetLook look_, built_;
  std::vector<std::uint8_t> table_;
};

/// Measures the carpet in a yuyv picture: the densest chroma among pixels that show the ground up to 4 m away and may
/// be green. False, and `look` as it was: too little of the picture is such.
/// Thread:  owner.   RT: yes, but the constructor.
class CarpetMeter {
 public:
  CarpetMeter();
  /// Pictures of up to 640 x 480.
  bool measure(const vision::ImageView& image, const GroundView& view, CarpetLook& look);

 private:
  struct Sample {
    std::uint16_t luma8, u4, v4;  // so many, added
  };
  static double luma_of(const Sample& s) { return 0.125 * s.luma8; }

  std::array<std::uint16_t, 64 * 64> count_{};
  std::vector<Sample> sample_;  // of the ground, of a colour that a carpet may have
};

}  // namespace sinew::soccer
