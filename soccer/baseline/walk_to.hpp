#pragma once
// The way to a place, round what stands there. Frame: "robot" of msg/soccer.hpp. Thread:  any.   RT: yes.
#include <span>

#include "math/elementary.hpp"
#include "soccer/world/field_at.hpp"

namespace sinew::soccer::baseline {

struct WalkLimits {
  double forward_mps = 0.3, back_mps = 0.15, side_mps = 0.15, turn_radps = 1;
  double near_m = 0.5;    // farther away it turns to where it goes, nearer it keeps its last heading
  double per_s = 1.2;     // how fast what is missing is walked off: speed for each metre or radian
  double margin_m = 0.2;  // from its own middle to an edge of what it must not touch
};

/// Something round that is in the way.
struct Round {
  FieldPoint at;
  double radius_m = 0;
};

struct WalkSpeed {
  double forward_mps = 0, left_mps = 0, turn_radps = 0;
};

/// The direction in which a robot at 0 has to go to come to `to`: straight there, or past the nearest edge of what is
/// in between. Things whose edges leave no room between them are passed together. Inside of a margin: away from its
/// middle.
double way_rad(const FieldPoint& to, std::span<const Round> in_the_way, double margin_m);

/// The speed that brings it to the pose `to`, and turns it there.
WalkSpeed walk_to(const FieldAt& to, std::span<const Round> in_the_way, const WalkLimits& limits);

}  // namespace sinew::soccer::baseline
