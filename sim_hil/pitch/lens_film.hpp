#pragma once
// Pictures through a lens: drawn finer and wider than they are, then bent, each pixel the mean of what falls on it.
#include <cstdint>
#include <span>
#include <vector>

#include "math/lens.hpp"
#include "sim_hil/raster/raster.hpp"

namespace sinew::plant {

/// Thread:  owner.
class LensFilm {
 public:
  /// A picture of this size with this focal length, the axis in its middle.
  LensFilm(std::uint32_t width, std::uint32_t height, double focal_px, const math::LensDistortion& lens);

  /// Draw on it without a lens, with this focal length and the axis in its middle.
  raster::Raster& raster() { return fine_; }
  double focal_px() const { return kFiner * focal_px_; }
  /// The picture, row after row, as Raster::pixels(). What a pixel shows is what its middle does.
  std::span<const std::uint32_t> develop();

 private:
  static constexpr int kFiner = 6;  // samples across a pixel; 3 leave corners off by 0.18 px, 6 by 0.11
  static raster::Raster large_enough(std::uint32_t width, std::uint32_t height, double focal_px,
                                     const math::LensDistortion& lens);

  double focal_px_;
  raster::Raster fine_;
  std::vector<std::uint32_t> from_;  // of each sample of each pixel: where in the fine picture
  std::vector<std::uint32_t> picture_;
};

}  // namespace sinew::plant
