#pragma once
#include "math/elementary.hpp"
#include "msg/soccer.hpp"
#include "soccer/world/field_at.hpp"

namespace sinew::gripper {

/// A team's object lies at its goal: somebody has seen it there within the last 5 s, and nobody has it any more.
/// Thread:  any.   RT: yes.
inline bool lies_at(const msg::TeamModel& team, const soccer::FieldPoint& goal, double within_m, msg::Time now) {
  if (team.ball_seen.ns == 0 || msg::seconds(now - team.ball_seen) > 5) return false;
  for (const msg::SoccerReport& mate : team.mate)
    if (mate.stamp.ns > 0 && mate.has_ball != 0 && msg::seconds(now - mate.stamp) < 5) return false;
  return math::hypot(team.ball_x_m - goal.x_m, team.ball_y_m - goal.y_m) < within_m;
}

}  // namespace sinew::gripper
