#include "soccer/world/roles.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "math/elementary.hpp"

namespace sinew::soccer::roles_test {
namespace {

using msg::SoccerRole;

std::vector<SoccerRole> roles_of(const std::vector<Player>& players, const RoleOptions& options = {}) {
  std::vector<SoccerRole> out;
  for (const Player& p : players) out.push_back(choose_role(players, p.number, options));
  return out;
}

TEST(Roles, OneKeepsTheGoalOneGoesToTheBallAndTheOthersSupport) {
  const std::vector<Player> team{{1, 1, SoccerRole::none, true},
                                 {2, 5, SoccerRole::none, true},
                                 {3, 2, SoccerRole::none, true},
                                 {4, 9, SoccerRole::none, true}};
  EXPECT_EQ(roles_of(team),
            (std::vector{SoccerRole::goalie, SoccerRole::supporter, SoccerRole::striker, SoccerRole::supporter}));
}

TEST(Roles, AStrikerIsReplacedOnlyByOneThatIsClearlySooner) {
  std::vector<Player> team{
      {1, 9, SoccerRole::goalie, true}, {2, 5, SoccerRole::striker, true}, {3, 4, SoccerRole::supporter, true}};
  EXPECT_EQ(roles_of(team)[1], SoccerRole::striker);
  team[2].to_ball_s = 3;
  EXPECT_EQ(roles_of(team)[2], SoccerRole::striker);
}

TEST(Roles, WhoLiesOrIsPenalisedOrSilentIsReplaced) {
  const std::vector<Player> team{
      {1, 9, SoccerRole::goalie, false}, {2, 5, SoccerRole::striker, true}, {3, 4, SoccerRole::supporter, true}};
  EXPECT_EQ(roles_of(team), (std::vector{SoccerRole::none, SoccerRole::goalie, SoccerRole::striker}));
}

TEST(Roles, TheLastOneGoesToTheBall) {
  EXPECT_EQ(choose_role(std::vector<Player>{{1, math::kInf, SoccerRole::goalie, true}}, 1, {}), SoccerRole::striker);
}

TEST(Roles, WhereNobodyKnowsOfABallTheLowestNumberSearchesIt) {
  const std::vector<Player> team{{4, math::kInf, SoccerRole::none, true},
                                 {2, math::kInf, SoccerRole::none, true},
                                 {7, math::kInf, SoccerRole::none, true}};
  EXPECT_EQ(roles_of(team), (std::vector{SoccerRole::striker, SoccerRole::goalie, SoccerRole::supporter}));
}

}  // namespace
}  // namespace sinew::soccer::roles_test
