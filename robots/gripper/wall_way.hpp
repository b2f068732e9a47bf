#pragma once
// The way round a wall whose place is known. Frame: any that the wall and the points are in. Thread:  any.   RT: yes.
#include <cstdint>

#include "soccer/world/field_at.hpp"

namespace sinew::gripper {

/// It stands at x from one y to a larger one; else there is none.
struct Wall {
  double x_m = 0, from_y_m = 0, to_y_m = 0;
  bool stands() const { return to_y_m > from_y_m; }
};

enum class WallEnd : std::uint32_t { none = 0, from = 1, to = 2 };

/// True if the straight way leads nearer than `margin_m` to the wall, along it and across it.
bool is_blocked(const soccer::FieldPoint& at, const soccer::FieldPoint& to, const Wall& wall, double margin_m);

/// Where to go next on the way to `to`: there, or to a corner beside the nearer end of the wall. `end`: the end that it
/// goes past; kept until the way is free, so that it does not change its mind half way.
soccer::FieldPoint way_round(const soccer::FieldPoint& at, const soccer::FieldPoint& to, const Wall& wall,
                             double margin_m, WallEnd& end);

}  // namespace sinew::gripper
