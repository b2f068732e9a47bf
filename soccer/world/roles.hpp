#pragma once
// Who plays what. Each robot decides for itself by what all have said, so that nobody leads: robots that heard the same
// come to the same. Thread:  any.   RT: yes.
#include <cstdint>
#include <span>

#include "msg/soccer.hpp"

namespace sinew::soccer {

/// A robot of the team, the own one among them.
struct Player {
  std::uint32_t number = 0;
  double to_ball_s = 0;  // infinite: it knows of no ball, or is not believed
  msg::SoccerRole role = msg::SoccerRole::none;
  bool plays = false;  // on its feet, not penalised, and heard lately
};

struct RoleOptions {
  std::size_t goalie_from = 2;  // so many must play before one of them keeps the goal
  double keeps_s = 1.5;         // a striker remains until another robot is at the ball by so much sooner
};

/// The role of the robot `own`. none: it does not play. Goalie: the lowest number of those that play. Striker: of the
/// others, who is at the ball soonest; the lowest number where nobody knows of one. All others support.
msg::SoccerRole choose_role(std::span<const Player> players, std::uint32_t own, const RoleOptions& options);

}  // namespace sinew::soccer
