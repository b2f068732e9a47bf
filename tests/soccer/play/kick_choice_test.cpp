#include "soccer/play/kick_choice.hpp"

#include <gtest/gtest.h>

namespace sinew::soccer::kick_choice_test {
namespace {

constexpr double kQuarter = 0.5 * math::kPi;

KickOptions four_kicks() {
  KickOptions o;
  o.kinds = {{{msg::BallMotion::kick_forward, false, {0.15, 0.05}, 0, 1.3, 3},
              {msg::BallMotion::kick_outward, false, {0, 0.2}, kQuarter, 1.2, 3},
              {msg::BallMotion::kick_forward, true, {0.2, 0.05}, 0, 0.9, 0.5},
              {msg::BallMotion::kick_outward, true, {0, 0.2}, kQuarter, 0.4, 0.5}}};
  return o;
}

TEST(KickChoice, WhereItStandsTheBallLiesBeforeTheFootAndGoesWhereItIsAimed) {
  const KickOptions o = four_kicks();
  const FieldPoint ball{1.2, -0.7};
  for (const KickKind& kind : o.kinds)
    for (const msg::Foot foot : {msg::Foot::left, msg::Foot::right})
      for (const double aim : {0.0, 1.0, -2.5}) {
        const FieldAt from = stand_for(kind, foot, ball, aim);
        const FieldPoint seen = from.in(ball.x_m, ball.y_m);
        const double side = foot == msg::Foot::left ? 1 : -1;
        EXPECT_NEAR(seen.x_m, kind.ball.x_m, 1e-12);
        EXPECT_NEAR(seen.y_m, side * kind.ball.y_m, 1e-12);
        EXPECT_NEAR(math::wrap_pi(from.heading_rad + side * kind.direction_rad - aim), 0, 1e-12);
      }
}

TEST(KickChoice, TheFootThatIsNearerKicks) {
  const KickOptions o = four_kicks();
  EXPECT_EQ(choose_kick({0, -0.1, 0}, {0.5, 0}, 0, {}, nullptr, o).foot, msg::Foot::left);
  EXPECT_EQ(choose_kick({0, 0.1, 0}, {0.5, 0}, 0, {}, nullptr, o).foot, msg::Foot::right);
}

TEST(KickChoice, WhoStandsBesideTheBallKicksItOutwardInsteadOfWalkingRoundIt) {
  const ChosenKick c = choose_kick({0, -0.3, kQuarter}, {0.2, -0.3}, 0, {}, nullptr, four_kicks());
  EXPECT_EQ(four_kicks().kinds[c.kind].motion, msg::BallMotion::kick_outward);
  EXPECT_EQ(c.foot, msg::Foot::right) << "turned to the left, the goal is on its right";
}

TEST(KickChoice, AnOpponentAtTheBallMakesAKickWithinAStepTheBetterOne) {
  const FieldAt robot{0, 0, 0};
  const FieldPoint ball{0.5, 0};
  KickOptions o = four_kicks();
  o.kinds[0].rolls_m = 1.5;  // far enough to be worth its time
  const std::array<Round, 1> near{{{{0.3, 0.6}, 0.15}}};
  EXPECT_FALSE(o.kinds[choose_kick(robot, ball, 0, {}, nullptr, o).kind].in_walk);
  EXPECT_TRUE(o.kinds[choose_kick(robot, ball, 0, near, nullptr, o).kind].in_walk);
}

TEST(KickChoice, ABallThatSomebodyStandsBeforeIsKickedPastHim) {
  const KickOptions o = four_kicks();
  const std::array<Round, 1> before{{{{0.9, 0.12}, 0.15}}};
  const ChosenKick c = choose_kick({0, 0, 0}, {0.5, 0}, 0, before, nullptr, o);
  const KickKind& kind = o.kinds[c.kind];
  const double way = c.from.heading_rad + (c.foot == msg::Foot::left ? 1 : -1) * kind.direction_rad;
  EXPECT_LT(way, -0.4) << "to the side on which he is not";
  EXPECT_GT(way, -1.2);
}

TEST(KickChoice, AChosenKickIsKeptUnlessAnotherIsClearlyBetter) {
  KickOptions o = four_kicks();
  ChosenKick kick = choose_kick({0, -0.05, 0}, {0.5, 0}, 0, {}, nullptr, o);
  for (const double y_m : {0.03, -0.03, 0.05, -0.05}) {
    const ChosenKick next = choose_kick({0, y_m, 0}, {0.5, 0}, 0, {}, &kick, o);
    EXPECT_EQ(next.foot, kick.foot);
    kick = next;
  }
  o.keeps_s = 0.2;
  EXPECT_NE(choose_kick({0, 1.5, 0}, {0.5, 0}, 0, {}, &kick, o).foot, kick.foot);
}

TEST(KickChoice, AimIsTheGoalAndBesideWhoStandsBeforeIt) {
  const Field field;
  const double goal_m = 0.5 * field.size().length_m;
  EXPECT_NEAR(aim_rad({0, 0}, field, {}), 0, 1e-9);
  EXPECT_NEAR(aim_rad({0, 1}, field, {}), math::atan2(-1, goal_m), 1e-9);
  const std::array<Round, 1> keeper{{{{goal_m - 0.3, 0.3}, 0.2}}};
  const double aim = aim_rad({goal_m - 1.5, 0}, field, keeper);
  EXPECT_LT(aim, -0.1) << "to the side that is free";
  EXPECT_LT(1.5 * math::tan(-aim), 0.5 * field.size().goal_width_m) << "between the posts";
}

}  // namespace
}  // namespace sinew::soccer::kick_choice_test
