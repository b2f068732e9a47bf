#include "soccer/world/roles.hpp"

#include "math/elementary.hpp"

namespace sinew::soccer {

using msg::SoccerRole;

SoccerRole choose_role(std::span<const Player> players, std::uint32_t own, const RoleOptions& o) {
  const Player* goalie = nullptr;
  const Player* self = nullptr;
  std::size_t playing = 0;
  for (const Player& p : players) {
    if (!p.plays) continue;
    ++playing;
    if (p.number == own) self = &p;
    if (!goalie || p.number < goalie->number) goalie = &p;
  }
  if (!self) return SoccerRole::none;
  if (playing < o.goalie_from) goalie = nullptr;
  if (self == goalie) return SoccerRole::goalie;
  const auto takes_s = [&](const Player& p) { return p.to_ball_s - (p.role == SoccerRole::striker ? o.keeps_s : 0); };
  const Player* striker = nullptr;
  for (const Player& p : players) {
    if (!p.plays || &p == goalie) continue;
    if (!striker || takes_s(p) < takes_s(*striker) || (takes_s(p) == takes_s(*striker) && p.number < striker->number))
      striker = &p;
  }
  return self == striker ? SoccerRole::striker : SoccerRole::supporter;
}

}  // namespace sinew::soccer
