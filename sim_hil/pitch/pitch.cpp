#include "sim_hil/pitch/pitch.hpp"

#include "sim_hil/pitch/dynamic.hpp"
#include "sim_hil/pitch/kinematic.hpp"

namespace sinew::plant {
namespace {

constexpr double kLeastApart_m = 0.1;

/// What is wrong with the bodies; empty: nothing.
std::string trouble_with(std::span<const PitchBody> bodies) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto& links = bodies[i].body.links;
    const std::string robot = "robot " + std::to_string(i);
    if (links.empty() || links.size() > kinematics::kMaxLinks)
      return robot + ": a body has 1 to " + std::to_string(kinematics::kMaxLinks) + " links";
    for (const kinematics::Link& link : links)
      if (!(link.mass_kg > 0)) return robot + ": link " + link.name + ": needs a mass";
    for (std::size_t other = 0; other < i; ++other) {
      const PitchPlace &a = bodies[i].start, &b = bodies[other].start;
      if (math::hypot(a.x_m - b.x_m, a.y_m - b.y_m) < kLeastApart_m)
        return robot + " starts where robot " + std::to_string(other) + " does";
    }
  }
  return {};
}

}  // namespace

hal::Result<std::unique_ptr<Pitch>> Pitch::create(const PitchOptions& options, std::span<const PitchBody> bodies,
                                                  std::uint64_t seed, std::string* why) {
  const std::string trouble = trouble_with(bodies);
  if (!trouble.empty()) {
    if (why) *why = trouble;
    return hal::Error{hal::Errc::bad_argument, "pitch"};
  }
  if (options.kinematic) return create_kinematic_pitch(options, bodies, seed);
  return create_dynamic_pitch(options, bodies, seed);
}

}  // namespace sinew::plant
