#pragma once
#include "msg/describe.hpp"
#include "msg/geometry.hpp"

namespace sinew::msg {

/// Where a thing is, and how sure that is: in the frame that the topic says, of a robot or of its team.
struct PlaceEstimate {
  Time stamp;
  Vec3 p_m;
  std::array<double, 9> covariance_m2{};  // 3x3, row by row
};

template <>
struct Description<PlaceEstimate> {
  using M = PlaceEstimate;
  static constexpr std::string_view name = "PlaceEstimate", doc = "Where a thing is, and how sure that is.";
  static constexpr auto fields = describe(field<&M::stamp>("ns"), field<&M::p_m>("m", "in the frame of its topic"),
                                          field<&M::covariance_m2>("m^2", "3x3 by rows"));
};

}  // namespace sinew::msg
