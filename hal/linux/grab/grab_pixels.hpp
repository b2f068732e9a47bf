#pragma once
#include <vector>

#include "hal/linux/grab/grab_view.hpp"
#include "msg/image.hpp"

namespace sinew::hal {

/// Turns a grabbed picture into the image of a camera: of any of its formats and any size, in one pass over the pixels.
/// A smaller image has in each pixel the mean of the area that it stands for, a larger one repeats pixels. Parts of the
/// region outside of the window are black.
/// Values:  mono8 and yuyv: luma of BT.601, yuyv with limited range (16 to 235) as cameras have it.
/// Thread:  owner.   RT: yes, but for the first picture of a size: see reserve().
class GrabPixels {
 public:
  /// Images as large as these later allocate nothing.
  void reserve(std::uint32_t width, std::uint32_t height);
  /// `region`: what was asked for, in the window; the picture is the part of it inside of the window. `out` has its
  /// format and size.
  void convert(const GrabPicture& picture, const GrabRegion& region, msg::Image& out) noexcept;

 private:
  struct Span {
    std::uint32_t first = 0, count = 0;  // pixels of the picture; none: black
  };
  static void spans_of(std::uint32_t from, std::int64_t offset, std::uint32_t inside,
                       std::vector<Span>& spans) noexcept;
  struct Rgb {
    std::uint8_t r = 0, g = 0, b = 0;
  };
  template <bool kRgb>
  void rows(const GrabPicture& picture, msg::Image& out) noexcept;

  std::vector<Span> columns_, lines_;
  std::vector<std::uint32_t> sums_;  // of one row of the image: three channels and how many pixels
  std::vector<std::uint8_t> row_;    // r, g, b of one row
};

}  // namespace sinew::hal
