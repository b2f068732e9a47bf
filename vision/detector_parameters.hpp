#pragma once
// Parameters that detectors of a coloured thing have in common.
#include <string_view>

#include "rt/declaration.hpp"
#include "vision/pinhole.hpp"
#include "vision/segmentation.hpp"

namespace sinew::vision {

/// The camera's numbers; they may change between steps.
struct CameraParameters {
  Pinhole given;                    // zeros: from the field of view and the size of the image
  double fov_y_rad = 1.0382921838;  // 2 atan(0.5 / 0.875): the focal length is 0.875 image heights

  void declare(rt::Declaration& d);
  Pinhole of(const ImageView& image) const {
    return Pinhole::from_fov(fov_y_rad, image.width, image.height).or_given(given);
  }
};

/// The colour looked for and the memory of its segmentation; read in configure().
struct ColourParameters {
  std::int64_t min_area_px = 12;
  std::int64_t max_runs = 8192;

  /// `whose`: "of the ball".
  void declare(rt::Declaration& d, HueSector& colour, std::string_view whose);
  SegmentationLimits limits() const {
    return {.colours = 1,
            .max_runs = static_cast<std::uint32_t>(max_runs),
            .min_area_px = static_cast<std::uint32_t>(min_area_px)};
  }
};

}  // namespace sinew::vision
