#include "vision/detector_parameters.hpp"

#include <string>

namespace sinew::vision {

void CameraParameters::declare(rt::Declaration& d) {
  d.param("fx_px", given.fx_px, {.unit = "px", .min = 0, .max = 1e5, .doc = "0: from fov_y_rad"});
  d.param("fy_px", given.fy_px, {.unit = "px", .min = 0, .max = 1e5, .doc = "0: from fov_y_rad"});
  d.param("cx_px", given.cx_px, {.unit = "px", .min = 0, .max = 1e5, .doc = "0: middle of the image"});
  d.param("cy_px", given.cy_px, {.unit = "px", .min = 0, .max = 1e5, .doc = "0: middle of the image"});
  d.param("fov_y_rad", fov_y_rad, {.unit = "rad", .min = 0.05, .max = 3.0, .doc = "from top to bottom"});
}

void ColourParameters::declare(rt::Declaration& d, HueSector& colour, std::string_view whose) {
  const std::string doc = std::string(whose) + "; at the start";
  d.param("hue_from_deg", colour.hue_from_deg, {.unit = "deg", .min = 0, .max = 360, .doc = doc});
  d.param("hue_to_deg", colour.hue_to_deg, {.unit = "deg", .min = 0, .max = 360, .doc = doc});
  d.param("saturation_min", colour.saturation_min, {.min = 0, .max = 1, .doc = "at the start"});
  d.param("value_min", colour.value_min, {.min = 0, .max = 1, .doc = "at the start"});
  d.param("min_area_px", min_area_px, {.unit = "px", .min = 1, .max = 1e6, .doc = "of a region; at the start"});
  d.param("max_runs", max_runs, {.min = 100, .max = 1e6, .doc = "memory for runs of pixels; at the start"});
}

}  // namespace sinew::vision
