#pragma once
#include "msg/describe.hpp"

namespace sinew::msg {

/// Three coordinates; the name of the field that holds them gives unit and frame.
struct Vec3 {
  double x = 0, y = 0, z = 0;
  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

/// Unit quaternion, Hamilton, order w x y z; `q_world_base` takes base coordinates to world.
struct Quat {
  double w = 1, x = 0, y = 0, z = 0;
  friend constexpr bool operator==(const Quat&, const Quat&) = default;
};

template <>
struct Description<Vec3> {
  static constexpr std::string_view name = "Vec3", doc = "Three coordinates.";
  static constexpr auto fields = describe(field<&Vec3::x>(""), field<&Vec3::y>(""), field<&Vec3::z>(""));
};

template <>
struct Description<Quat> {
  static constexpr std::string_view name = "Quat", doc = "Unit quaternion (Hamilton).";
  static constexpr auto fields =
      describe(field<&Quat::w>("1"), field<&Quat::x>("1"), field<&Quat::y>("1"), field<&Quat::z>("1"));
};

}  // namespace sinew::msg
