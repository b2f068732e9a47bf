#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "msg/describe.hpp"

namespace sinew::record {

/// A quantity to compare in two messages of a type: a number among the fields or, for each quaternion, two angles.
/// Units:   those of the field; degrees for angles.
struct Quantity {
  enum class What : std::uint8_t {
    number,
    angle,  // of the rotation from one attitude to the other
    tilt,   // between their directions of up (z of the world, seen from the body): the difference without the heading
  };
  std::string path;  // "p_world_m.x", "value[3]", "q_world_base.angle"
  std::string unit;
  What what = What::number;
  msg::Kind kind = msg::Kind::f64;  // of a number
  std::uint32_t offset = 0;

  double value(const void* message) const;  // of a number
};

/// Between two messages, perhaps of different types. Numbers: b - a; angles are not negative.
double difference(const Quantity& of_a, const void* a, const Quantity& of_b, const void* b);

/// In the order of the fields; the quantities of a quaternion follow it.
std::vector<Quantity> quantities(const msg::TypeInfo& type);

/// True if `pattern` means `name`: all of its parts, or some neighbouring ones. "state", "q_world_base.tilt" and "tilt"
/// mean "filter.state.q_world_base.tilt".
bool means(std::string_view pattern, std::string_view name);

/// Interpolates two messages, `share` (0..1) of the way from `a` to `b`: floating-point numbers on a line, quaternions
/// along the shorter way, other fields as in `a`. `out`: type.size bytes.
void interpolate(const msg::TypeInfo& type, const void* a, const void* b, double share, void* out);

}  // namespace sinew::record
