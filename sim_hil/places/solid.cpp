#include "sim_hil/places/solid.hpp"

#include <algorithm>

namespace sinew::plant {

using math::Vec3;

namespace {

constexpr double kFarAway_m = 1e12;

double sign_of(double x) { return x < 0 ? -1.0 : 1.0; }

/// In the box's axes.
Clearance box_clearance(const Vec3& p, const Vec3& half) {
  const Vec3 nearest{std::clamp(p.x, -half.x, half.x), std::clamp(p.y, -half.y, half.y),
                     std::clamp(p.z, -half.z, half.z)};
  const Vec3 off = p - nearest;
  const double distance = math::norm(off);
  if (distance > 0) return {distance, off / distance};
  // Inside: out by the nearest face.
  const double dx = half.x - math::fabs(p.x), dy = half.y - math::fabs(p.y), dz = half.z - math::fabs(p.z);
  if (dx <= dy && dx <= dz) return {-dx, {sign_of(p.x), 0, 0}};
  if (dy <= dz) return {-dy, {0, sign_of(p.y), 0}};
  return {-dz, {0, 0, sign_of(p.z)}};
}

Clearance cylinder_clearance(const Vec3& p, double radius, double half_length) {
  const double r = math::hypot(p.x, p.y);
  const Vec3 outward = r > 0 ? Vec3{p.x / r, p.y / r, 0} : Vec3{1, 0, 0};
  const double beside = r - radius, above = math::fabs(p.z) - half_length;
  const Vec3 up{0, 0, sign_of(p.z)};
  if (beside <= 0 && above <= 0) return beside > above ? Clearance{beside, outward} : Clearance{above, up};
  if (beside <= 0) return {above, up};
  if (above <= 0) return {beside, outward};
  const double distance = math::hypot(beside, above);
  return {distance, (beside / distance) * outward + (above / distance) * up};
}

/// Cuts the beam at the two planes coordinate = -half and half; false: nothing is left of it.
bool cut(double from, double along, double half, const Vec3& axis, double& begin, double& end, Vec3& normal) {
  if (math::fabs(along) < 1e-12) return math::fabs(from) <= half;
  double first = (-half - from) / along, last = (half - from) / along;
  if (first > last) std::swap(first, last);
  if (first > begin) begin = first, normal = -sign_of(along) * axis;
  end = std::min(end, last);
  return begin <= end;
}

struct Beam {
  double range_m = -1;  // negative: misses
  Vec3 normal;
};

Beam box_beam(const Vec3& from, const Vec3& along, const Vec3& half) {
  double begin = -kFarAway_m, end = kFarAway_m;
  Vec3 normal;
  if (!cut(from.x, along.x, half.x, {1, 0, 0}, begin, end, normal) ||
      !cut(from.y, along.y, half.y, {0, 1, 0}, begin, end, normal) ||
      !cut(from.z, along.z, half.z, {0, 0, 1}, begin, end, normal) || end < 0)
    return {};
  return {std::max(begin, 0.0), normal};
}

Beam cylinder_beam(const Vec3& from, const Vec3& along, double radius, double half_length) {
  double begin = -kFarAway_m, end = kFarAway_m;
  Vec3 normal;
  if (!cut(from.z, along.z, half_length, {0, 0, 1}, begin, end, normal)) return {};
  const double a = along.x * along.x + along.y * along.y, b = from.x * along.x + from.y * along.y,
               c = from.x * from.x + from.y * from.y - radius * radius;
  if (a < 1e-12) {
    if (c > 0) return {};
  } else {
    const double inside = b * b - a * c;
    if (inside < 0) return {};
    const double root = math::sqrt(inside), first = (-b - root) / a, last = (-b + root) / a;
    if (first > begin) {
      begin = first;
      normal = Vec3{from.x + first * along.x, from.y + first * along.y, 0} / radius;
    }
    end = std::min(end, last);
  }
  if (begin > end || end < 0) return {};
  return {std::max(begin, 0.0), normal};
}

Beam sphere_beam(const Vec3& from, const Vec3& along, double radius) {
  const double b = dot(from, along), c = math::squared_norm(from) - radius * radius, inside = b * b - c;
  if (inside < 0) return {};
  const double first = -b - math::sqrt(inside);
  if (first < 0 && c > 0) return {};
  const double range = std::max(first, 0.0);
  return {range, (from + range * along) / radius};
}

Beam plane_beam(const Vec3& from, const Vec3& along) {
  if (from.z <= 0) return {0, {0, 0, 1}};
  if (along.z >= -1e-12) return {};
  return {-from.z / along.z, {0, 0, 1}};
}

}  // namespace

double Solid::reach_m() const {
  switch (shape) {
    case Shape::plane:
      return kFarAway_m;
    case Shape::box:
      return math::norm(half_m);
    case Shape::cylinder:
      return math::hypot(half_m.x, half_m.z);
    case Shape::sphere:
      break;
  }
  return half_m.x;
}

Clearance clearance(const Solid& solid, const Vec3& point) {
  const Vec3 p = solid.q_world.conjugate().rotate(point - solid.p_world_m);
  Clearance local{p.z, {0, 0, 1}};
  if (solid.shape == Shape::box) {
    local = box_clearance(p, solid.half_m);
  } else if (solid.shape == Shape::cylinder) {
    local = cylinder_clearance(p, solid.half_m.x, solid.half_m.z);
  } else if (solid.shape == Shape::sphere) {
    const double r = math::norm(p);
    local = {r - solid.half_m.x, r > 0 ? p / r : Vec3{0, 0, 1}};
  }
  return {local.distance_m, solid.q_world.rotate(local.out)};
}

bool meets(const Solid& solid, const Vec3& from, const Vec3& direction, Hit& hit) {
  if (solid.shape != Shape::plane) {  // most are nowhere near the beam
    const Vec3 to = solid.p_world_m - from;
    const double along = dot(to, direction), reach = solid.reach_m();
    if (along < -reach || along > hit.range_m + reach) return false;
    if (math::squared_norm(to) - along * along > reach * reach) return false;
  }
  const math::Quat q_solid = solid.q_world.conjugate();
  const Vec3 p = q_solid.rotate(from - solid.p_world_m), d = q_solid.rotate(direction);
  Beam beam;
  switch (solid.shape) {
    case Shape::plane:
      beam = plane_beam(p, d);
      break;
    case Shape::box:
      beam = box_beam(p, d, solid.half_m);
      break;
    case Shape::cylinder:
      beam = cylinder_beam(p, d, solid.half_m.x, solid.half_m.z);
      break;
    case Shape::sphere:
      beam = sphere_beam(p, d, solid.half_m.x);
      break;
  }
  if (beam.range_m < 0 || beam.range_m > hit.range_m) return false;
  hit = {beam.range_m, solid.q_world.rotate(beam.normal)};
  return true;
}

}  // namespace sinew::plant
