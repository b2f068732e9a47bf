#pragma once
#include "images/encode.hpp"

namespace sinew::images {

/// The checked and clipped Cut of one picture: a part of at least 1 x 1 pixels and its size after scaling.
struct Area {
  std::uint32_t x = 0, y = 0, width = 0, height = 0;
  std::uint32_t out_width = 0, out_height = 0;
  bool scaled() const { return out_width != width || out_height != height; }
};

/// Errors:  bad_argument, as Encoder has it.
hal::Result<Area> area_of(const PixelView& view, const Cut& cut);

}  // namespace sinew::images
