// Where a robot is on the field, by what it sees: here corners and a line of the own half, from one place, for two
// seconds. docs/soccer-world.md.
#include <cstdio>

#include "soccer/world/locator.hpp"

namespace {

using namespace sinew;

constexpr soccer::FieldAt kTruth{-2.2, 0.6, 2.9};  // m, m, rad: it looks at its own goal
constexpr double kSeesTo_m = 3;
constexpr float kVariance_m2 = 0.0025F;

msg::GroundPoint seen_from_there(const soccer::FieldPoint& p) {
  const soccer::FieldPoint at = kTruth.in(p.x_m, p.y_m);
  return {static_cast<float>(at.x_m), static_cast<float>(at.y_m), kVariance_m2, 0, kVariance_m2};
}

/// What a camera would show that looks ahead: each corner and each mark within three metres.
msg::SoccerSight look(const soccer::Field& field, msg::Time stamp) {
  msg::SoccerSight sight;
  sight.stamp = stamp;
  for (const soccer::FieldCorner& c : field.corners()) {
    const soccer::FieldPoint at = kTruth.in(c.at.x_m, c.at.y_m);
    if (at.x_m < math::fabs(at.y_m) || at.x_m > kSeesTo_m || sight.marks == sight.mark.size()) continue;
    msg::SeenMark& m = sight.mark[sight.marks++];
    m.at = seen_from_there(c.at);
    m.kind = c.kind;
    m.heading_rad = static_cast<float>(math::wrap_pi(c.heading_rad - kTruth.heading_rad));
    m.heading_sigma_rad = 0.1F;
  }
  const soccer::FieldLine& line = field.lines()[5];  // before the own goal area
  sight.line[sight.lines++] = {seen_from_there(line.from), seen_from_there(line.to)};
  return sight;
}

}  // namespace

int main() {
  const soccer::Field field;
  soccer::Locator locator(field);
  locator.forget(true);  // it knows nothing but that it is in its own half
  for (int picture = 1; picture <= 40; ++picture) locator.see(look(field, {picture * 50'000'000LL}), true);
  msg::FieldPose pose;
  locator.fill(pose);
  std::printf("%s at %.2f, %.2f m, heading %.2f rad; known to %.0f mm; the other half: %.0f %%\n",
              pose.found != 0 ? "found" : "not found", pose.x_m, pose.y_m, pose.heading_rad,
              1e3 * math::sqrt(pose.covariance[0]), 100 * pose.mirrored);
  const double off = distance_m({pose.x_m, pose.y_m, 0}, kTruth);
  return pose.found != 0 && off < 0.05 ? 0 : 1;
}
