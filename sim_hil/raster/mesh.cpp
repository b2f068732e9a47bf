#include "sim_hil/raster/mesh.hpp"

#include <algorithm>

namespace sinew::raster {
namespace {

using math::Vec3;

constexpr double kTurn = 2 * math::kPi;

/// Collects triangles; finish() gives them their normals.
class Builder {
 public:
  std::uint32_t point(const Vec3& p) {
    mesh_.points.push_back(p);
    return static_cast<std::uint32_t>(mesh_.points.size() - 1);
  }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) { mesh_.triangles.push_back({{a, b, c}, {}}); }
  void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }
  Mesh finish() {
    Vec3 low = mesh_.points.front(), high = low;
    for (const Vec3& p : mesh_.points)
      for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
    mesh_.middle = (low + high) * 0.5;
    for (const Vec3& p : mesh_.points) mesh_.radius_m = std::max(mesh_.radius_m, norm(p - mesh_.middle));
    for (Mesh::Triangle& t : mesh_.triangles) {
      const Vec3 &a = mesh_.points[t.corner[0]], &b = mesh_.points[t.corner[1]], &c = mesh_.points[t.corner[2]];
      t.normal = math::normalized(cross(b - a, c - a));
    }
    return std::move(mesh_);
  }

 private:
  Mesh mesh_;
};

/// A ring of points at height z.
std::vector<std::uint32_t> ring_of(Builder& out, double radius_m, double z_m, int slices) {
  std::vector<std::uint32_t> points;
  for (int i = 0; i < slices; ++i) {
    const math::SinCos a = math::sincos(kTurn * i / slices);
    points.push_back(out.point({radius_m * a.cos, radius_m * a.sin, z_m}));
  }
  return points;
}

void band(Builder& out, const std::vector<std::uint32_t>& lower, const std::vector<std::uint32_t>& upper) {
  const std::size_t n = lower.size();
  for (std::size_t i = 0; i < n; ++i) out.quad(lower[i], lower[(i + 1) % n], upper[(i + 1) % n], upper[i]);
}

/// A surface of revolution between two points on z: rings of (radius, height) from below.
Mesh revolved(const std::vector<std::pair<double, double>>& rings, double bottom_m, double top_m, int slices) {
  Builder out;
  const std::uint32_t bottom = out.point({0, 0, bottom_m});
  std::vector<std::vector<std::uint32_t>> all;
  for (const auto& [radius, z] : rings) all.push_back(ring_of(out, radius, z, slices));
  const std::uint32_t top = out.point({0, 0, top_m});
  const auto n = static_cast<std::size_t>(slices);
  for (std::size_t i = 0; i < n; ++i) out.triangle(bottom, all.front()[(i + 1) % n], all.front()[i]);
  for (std::size_t r = 0; r + 1 < all.size(); ++r) band(out, all[r], all[r + 1]);
  for (std::size_t i = 0; i < n; ++i) out.triangle(top, all.back()[i], all.back()[(i + 1) % n]);
  return out.finish();
}

}  // namespace

Mesh Mesh::moved(const kinematics::Pose& pose) const {
  Mesh out = *this;
  for (Vec3& p : out.points) p = pose.of(p);
  for (Triangle& t : out.triangles) t.normal = pose.q.rotate(t.normal);
  out.middle = pose.of(middle);
  return out;
}

void Mesh::add(const Mesh& other) {
  const auto first = static_cast<std::uint32_t>(points.size());
  points.insert(points.end(), other.points.begin(), other.points.end());
  for (Triangle t : other.triangles) {
    for (std::uint32_t& c : t.corner) c += first;
    triangles.push_back(t);
  }
  if (first == 0) {
    middle = other.middle, radius_m = other.radius_m;
    return;
  }
  // A sphere around both.
  const Vec3 way = other.middle - middle;
  const double far = norm(way);
  if (far + other.radius_m <= radius_m) return;
  if (far + radius_m <= other.radius_m) {
    middle = other.middle, radius_m = other.radius_m;
    return;
  }
  const double radius = (far + radius_m + other.radius_m) / 2;
  middle += way * ((radius - radius_m) / far);
  radius_m = radius;
}

Mesh box(const Vec3& size_m) {
  Builder out;
  const Vec3 h = size_m * 0.5;
  std::uint32_t p[8];
  for (int i = 0; i < 8; ++i) p[i] = out.point({i & 1 ? h.x : -h.x, i & 2 ? h.y : -h.y, i & 4 ? h.z : -h.z});
  out.quad(p[0], p[2], p[3], p[1]);
  out.quad(p[4], p[5], p[7], p[6]);
  out.quad(p[0], p[1], p[5], p[4]);
  out.quad(p[2], p[6], p[7], p[3]);
  out.quad(p[0], p[4], p[6], p[2]);
  out.quad(p[1], p[3], p[7], p[5]);
  return out.finish();
}

Mesh sphere(double radius_m, int slices, int stacks) {
  std::vector<std::pair<double, double>> rings;
  for (int i = 1; i < stacks; ++i) {
    const math::SinCos a = math::sincos(math::kPi * i / stacks);
    rings.emplace_back(radius_m * a.sin, -radius_m * a.cos);
  }
  return revolved(rings, -radius_m, radius_m, slices);
}

Mesh capsule(double radius_m, double length_m, int slices, int stacks) {
  std::vector<std::pair<double, double>> rings;
  for (const double side : {-1.0, 1.0}) {
    for (int i = 0; i < stacks; ++i) {
      const int up = side < 0 ? i + 1 : stacks - 1 - i + 1;
      const math::SinCos a = math::sincos(math::kPi / 2 * up / stacks);
      rings.emplace_back(radius_m * a.sin, side * (length_m / 2 + radius_m * a.cos));
    }
  }
  return revolved(rings, -length_m / 2 - radius_m, length_m / 2 + radius_m, slices);
}

Mesh cylinder(double radius_m, double length_m, int slices) {
  return revolved({{radius_m, -length_m / 2}, {radius_m, length_m / 2}}, -length_m / 2, length_m / 2, slices);
}

Mesh polygon(const std::vector<Vec3>& corners) {
  Builder out;
  for (const Vec3& c : corners) out.point(c);
  for (std::uint32_t i = 2; i < corners.size(); ++i) out.triangle(0, i - 1, i);
  return out.finish();
}

Mesh ring(double inner_m, double outer_m, int slices) {
  Builder out;
  const auto inner = ring_of(out, inner_m, 0, slices), outer = ring_of(out, outer_m, 0, slices);
  band(out, outer, inner);
  return out.finish();
}

}  // namespace sinew::raster
