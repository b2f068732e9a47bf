#pragma once
#include "msg/describe.hpp"

namespace sinew::msg {

/// A pinhole camera with lens distortion, of pictures of this size.
/// Units:   pixels; pixel (0, 0) has its centre at 0, 0. Frames: camera optical, z forward, x right, y down.
/// Source:  D. C. Brown, Decentering Distortion of Lenses, 1966; as OpenCV and ROS ("plumb_bob") count its terms.
struct CameraModel {
  Time stamp;
  std::uint32_t width = 0, height = 0;
  double fx_px = 0, fy_px = 0, cx_px = 0, cy_px = 0;
  std::array<double, 5> distortion{};  // k1, k2, p1, p2, k3
};

template <>
struct Description<CameraModel> {
  using M = CameraModel;
  static constexpr std::string_view name = "CameraModel", doc = "A pinhole camera with lens distortion.";
  static constexpr auto fields = describe(field<&M::stamp>("ns"), field<&M::width>("px"), field<&M::height>("px"),
                                          field<&M::fx_px>("px"), field<&M::fy_px>("px"), field<&M::cx_px>("px"),
                                          field<&M::cy_px>("px"), field<&M::distortion>("1", "k1, k2, p1, p2, k3"));
};

}  // namespace sinew::msg
