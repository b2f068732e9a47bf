// Robots that shall share a world: what has to fit among their files.
#include "apps/team/team_setup.hpp"

#include <gtest/gtest.h>

namespace sinew::app::team_setup_test {
namespace {

TeamMember member(const char* name, std::uint16_t number) {
  TeamMember m;
  m.name = name;
  m.robot.team.emplace();
  m.robot.team->link.robot = number;
  m.robot.team->link.mates = {{"ant", 1}, {"bee", 2}};
  return m;
}

struct Two {
  std::vector<TeamMember> members{member("ant", 1), member("bee", 2)};
  TeamMember& bee() { return members[1]; }
  std::string why() const { return misfit(members); }
};

TEST(TeamSetup, TwoThatFitFit) { EXPECT_EQ(Two().why(), ""); }

TEST(TeamSetup, NamesWhatDoesNotFit) {
  Two t;
  t.bee().name = "ant";
  EXPECT_EQ(t.why(), "two robots are named ant: each has its own name (robot.name)");
  t = {};
  t.bee().robot.team->link.robot = 1;
  EXPECT_EQ(t.why(), "ant and bee both have the number 1 in the team (team.robot)");
  t = {};
  t.bee().robot.team->link.robot = 3;
  EXPECT_EQ(t.why(), "ant takes bee for number 2, and its own file says 3 (team.members, team.robot)");
  t = {};
  t.bee().robot.team->link.team = 9;
  EXPECT_EQ(t.why(), "ant is of the team 0 and bee of the team 9: they do not hear each other (team.team)");
}

TEST(TeamSetup, AWorldIsTheSameForAllOfThem) {
  Two t;
  t.bee().robot.sim.world = "seesaw";
  EXPECT_EQ(t.why(), "ant and bee share a world: sim.world is quad in one and seesaw in the other");
  t = {};
  t.bee().robot.sim.options["gust_mps"] = 3;
  EXPECT_EQ(t.why(), "ant and bee share a world: sim.gust_mps is left out in one and 3 in the other");
  t = {};
  t.bee().robot.sim.options["start_x_m"] = 1;
  EXPECT_EQ(t.why(), "") << "each starts where it wants";
  t.bee().robot.sim.camera_width = 64;
  EXPECT_EQ(t.why(), "ant and bee share a world: sim.camera_width is 320 in one and 64 in the other");
}

TEST(TeamSetup, AWorldHasRoomForAFew) {
  std::vector<TeamMember> five;
  for (int i = 0; i < 5; ++i) five.push_back(member("ant", 1));
  EXPECT_EQ(misfit(five), "the world quad has room for 4 robots, not 5");
  Two t;
  for (TeamMember& m : t.members) m.robot.sim.world = "seesaw";
  EXPECT_EQ(t.why(), "the world seesaw has room for 1 robot, not 2");
}

}  // namespace
}  // namespace sinew::app::team_setup_test
