#pragma once
// Shapes as triangles, for Raster. Winding: counter-clockwise seen from outside.
#include <array>
#include <cstdint>
#include <vector>

#include "kinematics/body.hpp"
#include "math/linear.hpp"

namespace sinew::raster {

struct Mesh {
  struct Triangle {
    std::array<std::uint32_t, 3> corner{};
    math::Vec3 normal;  // unit length, outwards
  };
  std::vector<math::Vec3> points{};
  std::vector<Triangle> triangles{};
  math::Vec3 middle;  // of a sphere around all points
  double radius_m = 0;

  /// Moves and turns all of it.
  Mesh moved(const kinematics::Pose& pose) const;
  /// All of `other` as well.
  void add(const Mesh& other);
};

/// Full lengths.
Mesh box(const math::Vec3& size_m);
/// From pole to pole `stacks` rings of `slices` faces.
Mesh sphere(double radius_m, int slices = 10, int stacks = 6);
/// Along z; `length_m` between the middles of its ends.
Mesh capsule(double radius_m, double length_m, int slices = 8, int stacks = 2);
/// Along z, closed.
Mesh cylinder(double radius_m, double length_m, int slices = 12);
/// In the plane z = 0, seen from above; corners counter-clockwise.
Mesh polygon(const std::vector<math::Vec3>& corners);
/// A flat ring in the plane z = 0, seen from above.
Mesh ring(double inner_m, double outer_m, int slices = 48);

}  // namespace sinew::raster
