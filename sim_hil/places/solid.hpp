#pragma once
// Things that stand in the way: what vehicles touch, and what beams of sensors end at.
#include <cstdint>
#include <span>
#include <vector>

#include "math/linear.hpp"

namespace sinew::plant {

enum class Shape : std::uint8_t { plane, box, cylinder, sphere };

/// A solid body at rest.
/// Shape:   half_m: a box's half edges; a cylinder's radius in x and half length in z, along its z; a sphere's radius
/// in
///          x. A plane is everything below its own z = 0.
/// Frames:  world.
struct Solid {
  Shape shape = Shape::box;
  math::Vec3 p_world_m;
  math::Quat q_world;
  math::Vec3 half_m;

  /// Nothing of it is farther than this from p_world_m; infinite for a plane.
  double reach_m() const;
};

/// From the surface of a solid to a point: how far outside (negative: inside), and in which direction that grows.
struct Clearance {
  double distance_m = 0;
  math::Vec3 out;  // unit vector, world
};

/// RT: yes.
Clearance clearance(const Solid& solid, const math::Vec3& point);

/// Where a beam from outside of the solid meets it.
struct Hit {
  double range_m = 0;
  math::Vec3 normal;  // of the surface, unit vector, world
};

/// `direction` is a unit vector. True: the beam meets the solid within `hit.range_m`, which becomes its range. A beam
/// that begins inside meets it at 0. RT: yes.
bool meets(const Solid& solid, const math::Vec3& from, const math::Vec3& direction, Hit& hit);

}  // namespace sinew::plant
