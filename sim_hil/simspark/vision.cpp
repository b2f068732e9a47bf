#include "sim_hil/simspark/vision.hpp"

#include <algorithm>

#include "sim_hil/simspark/frame.hpp"

namespace sinew::simspark {
namespace {

using math::Vec3;
using wire::SparkPercepts;
using wire::SparkPolar;
using wire::SparkSeen;

constexpr double kDistanceShare = 0.000965, kAzimuth_deg = 0.1225, kElevation_deg = 0.1480, kOffset_m = 0.005;
constexpr double kHalf_deg = 60, kNearest_m = 0.1;
constexpr double kTan60 = 1.7320508075688772;

bool in_view(const SparkPolar& at) {
  return at.distance_m > kNearest_m && math::fabs(at.azimuth_deg) <= kHalf_deg &&
         math::fabs(at.elevation_deg) <= kHalf_deg;
}

void make_noise(SparkPolar& at, math::Random& random) {
  at.distance_m *= 1 + kDistanceShare * random.normal();
  at.azimuth_deg += kAzimuth_deg * random.normal();
  at.elevation_deg += kElevation_deg * random.normal();
}

/// The part of a line before the eye within the view's four planes; false: none.
bool clip(Vec3& from, Vec3& to) {
  double begin = 0, end = 1;
  const auto keep = [&](double at_from, double at_to) {  // where it is not negative
    if (at_from < 0 && at_to < 0) return false;
    if (at_from < 0) begin = std::max(begin, at_from / (at_from - at_to));
    if (at_to < 0) end = std::min(end, at_from / (at_from - at_to));
    return true;
  };
  const bool some =
      keep(from.x - kNearest_m, to.x - kNearest_m) && keep(kTan60 * from.x - from.y, kTan60 * to.x - to.y) &&
      keep(kTan60 * from.x + from.y, kTan60 * to.x + to.y) && keep(kTan60 * from.x - from.z, kTan60 * to.x - to.z) &&
      keep(kTan60 * from.x + from.z, kTan60 * to.x + to.z);
  if (!some || begin >= end) return false;
  const Vec3 way = to - from, start = from;
  from = start + way * begin, to = start + way * end;
  return true;
}

void add(SparkPercepts& out, const SparkSeen& seen) {
  if (out.sightings < out.seen.size()) out.seen[out.sightings++] = seen;
}

}  // namespace

SparkPolar polar_of(const Vec3& p) {
  const double flat = math::hypot(p.x, p.y);
  return {math::hypot(flat, p.z), kDegrees * math::atan2(p.y, p.x), kDegrees * math::atan2(p.z, flat)};
}

Vec3 point_of(const SparkPolar& at) {
  const auto azimuth = math::sincos(at.azimuth_deg / kDegrees), elevation = math::sincos(at.elevation_deg / kDegrees);
  return Vec3{elevation.cos * azimuth.cos, elevation.cos * azimuth.sin, elevation.sin} * at.distance_m;
}

SparkVision::SparkVision(math::Random& random)
    : offset_m_(random.uniform(-kOffset_m, kOffset_m), random.uniform(-kOffset_m, kOffset_m),
                random.uniform(-kOffset_m, kOffset_m)) {}

void SparkVision::see(const kinematics::Pose& eye, const Vec3& ball_m, std::span<const SeenPlayer> players,
                      math::Random& random, SparkPercepts& out) const {
  const kinematics::Pose to_eye = eye.inverse();
  out.has_see = true;
  const auto look = [&](SparkSeen seen, const Vec3& at_m) {
    seen.at = polar_of(to_eye.of(at_m) + offset_m_);
    if (!in_view(seen.at)) return;
    make_noise(seen.at, random);
    add(out, seen);
  };
  for (const Landmark& mark : kLandmarks)
    look({.kind = SparkSeen::Kind::landmark, .name = mark.name, .team = {}, .at = {}, .to = {}}, mark.at_m);
  look({.kind = SparkSeen::Kind::ball, .name = "B", .team = {}, .at = {}, .to = {}}, ball_m);
  for (const SeenPlayer& player : players)
    for (std::size_t i = 0; i < kParts.size(); ++i)
      look({.kind = SparkSeen::Kind::player,
            .name = kParts[i],
            .team = player.team,
            .number = player.number,
            .at = {},
            .to = {}},
           player.part_m[i]);
  for (const SparkLine& line : spark_lines()) {
    Vec3 from = to_eye.of(line.from_m), to = to_eye.of(line.to_m);
    if (!clip(from, to)) continue;
    SparkSeen seen{.kind = SparkSeen::Kind::line, .name = "L", .team = {}, .at = polar_of(from), .to = polar_of(to)};
    make_noise(seen.at, random);
    make_noise(seen.to, random);
    add(out, seen);
  }
}

}  // namespace sinew::simspark
