#include "apps/deploy/unit_text.hpp"

#include <gmock/gmock.h>

namespace sinew::app::unit_text_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

RobotFile robot() {
  RobotFile r;
  r.graph.robot = "desk head";
  r.graph.guardian.arming = rt::GuardianSpec::Arming::manual;
  r.graph.threads.emplace_back().cpus = {2, 3};
  r.graph.actuators.emplace_back().name = "head";
  return r;
}
UnitOptions options() { return {"/opt/sinew", "desk.toml", "/data/sinew", "sinew", {0, 1, 2, 3}, {"video", "i2c"}}; }

TEST(UnitText, ARobotThatArmsByItselfIsNotStartedAgainByItself) {
  RobotFile r = robot();
  EXPECT_THAT(unit_text(r, options()), HasSubstr("\nRestart=on-failure\n")) << "it comes back disarmed";
  r.graph.guardian.arming = rt::GuardianSpec::Arming::automatic;
  EXPECT_THAT(unit_text(r, options()), HasSubstr("\nRestart=no\n"));
  r.graph.actuators.clear();
  EXPECT_THAT(unit_text(r, options()), HasSubstr("\nRestart=on-failure\n")) << "it moves nothing";
}

TEST(UnitText, ThreadsWithoutProcessorsOfTheirOwnGetTheOthers) {
  EXPECT_THAT(unit_text(robot(), options()), HasSubstr("\nCPUAffinity=0,1\n"));
  UnitOptions o = options();
  o.cpus = {};
  EXPECT_THAT(unit_text(robot(), o), Not(HasSubstr("CPUAffinity"))) << "nothing is known of the board";
  o.cpus = {2, 3};
  EXPECT_THAT(unit_text(robot(), o), Not(HasSubstr("CPUAffinity"))) << "no others";
  RobotFile r = robot();
  r.graph.threads[0].cpus = {};
  EXPECT_THAT(unit_text(r, options()), Not(HasSubstr("CPUAffinity")));
}

TEST(UnitText, OnlyGroupsThatTheBoardHasAreNamed) {
  EXPECT_THAT(unit_text(robot(), options()), HasSubstr("\nSupplementaryGroups=video i2c\n"));
  UnitOptions o = options();
  o.groups = {};
  EXPECT_THAT(unit_text(robot(), o), Not(HasSubstr("SupplementaryGroups")));
}

TEST(UnitText, NamesThatSystemdWouldReadOtherwiseAreRefused) {
  EXPECT_EQ(unit_name(robot()), "sinew-desk_head.service");
  EXPECT_EQ(refuse_unit(options()), "");
  for (const char* bad : {"/opt/a b", "/opt/%n", "opt/sinew", "/opt/\"x", "/opt/$x", ""}) {
    UnitOptions o = options();
    o.folder = bad;
    EXPECT_NE(refuse_unit(o), "") << bad;
  }
}

}  // namespace
}  // namespace sinew::app::unit_text_test
