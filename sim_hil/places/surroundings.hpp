#pragma once
#include <limits>
#include <optional>
#include <span>

#include "sim_hil/places/solid.hpp"

namespace sinew::plant {

/// What a vehicle has around it in one step: the solids of the place and the things and vehicles that are in it.
/// Owner:  the place's; valid during the step.
struct Surroundings {
  std::span<const Solid> fixed, moving;
  const Solid* self = nullptr;  // of moving: not in its own way

  /// Calls with each solid that is not further than `reach_m` from a point.
  template <class Call>
  void near(const math::Vec3& point, double reach_m, Call&& call) const {
    const auto all = [&](std::span<const Solid> solids) {
      for (const Solid& s : solids) {
        if (&s == self) continue;
        if (s.shape != Shape::plane) {
          const double far = reach_m + s.reach_m();
          if (math::squared_norm(s.p_world_m - point) > far * far) continue;
        }
        call(s);
      }
    };
    all(fixed);
    all(moving);
  }
  /// The nearest surface along a beam of a unit direction. Nothing: none within `most_m`.
  std::optional<Hit> beam(const math::Vec3& from, const math::Vec3& direction, double most_m) const {
    Hit hit{most_m, {}};
    bool any = false;
    for (const auto solids : {fixed, moving})
      for (const Solid& s : solids)
        if (&s != self) any = meets(s, from, direction, hit) || any;
    return any ? std::optional(hit) : std::nullopt;
  }
};

}  // namespace sinew::plant
