#include "soccer/world/team_map.hpp"

#include <gtest/gtest.h>

namespace sinew::soccer::team_map_test {
namespace {

constexpr msg::Time kNow{20'000'000'000};

msg::SoccerReport mate(double ball_x, double ball_y, double sigma_m, double age_s = 0.2) {
  msg::SoccerReport r;
  r.stamp = {kNow.ns - static_cast<std::int64_t>(1e9 * age_s)};
  r.ball_seen = r.stamp;
  r.mirrored = 0.01F;
  const auto v = static_cast<float>(sigma_m * sigma_m);
  r.ball = {static_cast<float>(ball_x), static_cast<float>(ball_y), v, 0, v};
  r.ball_confidence = 0.9F;
  r.plays = 1;
  return r;
}
BallReport mine(double x, double y, double sigma_m) {
  BallReport b;
  b.x_m = x, b.y_m = y;
  b.covariance = {sigma_m * sigma_m, 0, 0, sigma_m * sigma_m};
  b.confidence = 0.9, b.seen = kNow, b.bit = kOwnBallBit;
  return b;
}

TEST(TeamMap, ThoseThatAgreeMakeOneBallAndTheSurerCountsMore) {
  msg::TeamModel team;
  team.mate[0] = mate(1.2, 0, 0.1, 0);
  put_together(mine(1.0, 0, 0.1), kNow, {}, 0, team);
  EXPECT_NEAR(team.ball_x_m, 1.1, 1e-6);
  EXPECT_EQ(team.ball_from, (1U << kOwnBallBit) | 1U);
  EXPECT_NEAR(team.ball_covariance_m2[0], 0.005, 1e-6) << "two are surer than one";
  EXPECT_GT(team.ball_confidence, 0.95);
  team = {};
  team.mate[0] = mate(1.2, 0, 0.3, 0);
  put_together(mine(1.0, 0, 0.1), kNow, {}, 0, team);
  EXPECT_NEAR(team.ball_x_m, 1.02, 1e-3);
}

TEST(TeamMap, WhoContradictsTheOthersIsDistrusted) {
  msg::TeamModel team;
  team.mate[0] = mate(1.1, 0, 0.2);
  team.mate[2] = mate(-1.1, 0, 0.2);  // in the other half, by mistake
  put_together(mine(1.0, 0, 0.2), kNow, {}, 0, team);
  EXPECT_EQ(team.distrusted, 1U << 2);
  EXPECT_EQ(team.mates, 2U);
  EXPECT_NEAR(team.ball_x_m, 1.05, 0.05);
}

TEST(TeamMap, OneMateAloneDoesNotOverruleTheOwnEyesHoweverSureItIs) {
  BallReport own = mine(1, 0, 0.2);
  own.confidence = 0.4;
  msg::TeamModel team;
  team.mate[0] = mate(-2, 0, 0.02);
  put_together(own, kNow, {}, 0, team);
  EXPECT_NEAR(team.ball_x_m, 1, 1e-6);
  EXPECT_EQ(team.distrusted, 1U);
  // Two that agree do; and one does where the own ball was seen long ago.
  team = {};
  team.mate[0] = mate(-2, 0, 0.02), team.mate[1] = mate(-2, 0, 0.02);
  put_together(own, kNow, {}, 0, team);
  EXPECT_NEAR(team.ball_x_m, -2, 1e-6);
  team = {};
  team.mate[0] = mate(-2, 0, 0.02);
  own.confidence = 0.9, own.seen = {kNow.ns - 2'000'000'000};
  put_together(own, kNow, {}, 0, team);
  EXPECT_NEAR(team.ball_x_m, -2, 1e-6);
}

TEST(TeamMap, OfTwoMatesTheOneThatWasContradictedBeforeCountsLess) {
  msg::TeamModel team;
  team.mate[0] = mate(-2, 0, 0.02), team.mate[1] = mate(1, 0, 0.2);
  team.mate[1].ball_confidence = 0.6F;
  put_together(std::nullopt, kNow, {}, 1, team);
  EXPECT_NEAR(team.ball_x_m, 1, 1e-6);
  EXPECT_EQ(team.distrusted, 1U);
}

TEST(TeamMap, OldReportsCountLessAndTheOldestNothing) {
  msg::TeamModel team;
  team.mate[0] = mate(2, 1, 0.1, 2);
  put_together(std::nullopt, kNow, {}, 0, team);
  EXPECT_NEAR(team.ball_x_m, 2, 1e-6);
  EXPECT_GT(team.ball_covariance_m2[0], 0.05) << "it may have been moved since";
  EXPECT_LT(team.ball_confidence, 0.9);
  team = {};
  team.mate[0] = mate(2, 1, 0.1, 4);
  put_together(std::nullopt, kNow, {}, 0, team);
  EXPECT_EQ(team.mates, 0U);
  EXPECT_EQ(team.ball_seen, msg::Time{0});
  EXPECT_EQ(team.ball_confidence, 0);
}

TEST(TeamMap, ARollingBallIsWhereItMustHaveRolled) {
  msg::TeamModel team;
  team.mate[0] = mate(0, 0, 0.1, 1);
  team.mate[0].ball_vx_mps = 1;
  put_together(std::nullopt, kNow, {}, 0, team);
  EXPECT_NEAR(team.ball_x_m, 1 - 0.5 * 0.35, 1e-6);
  EXPECT_NEAR(team.ball_vx_mps, 0.65, 1e-6);
}

TEST(TeamMap, WhoDoesNotKnowItsHalfTellsNothingOfTheField) {
  msg::TeamModel team;
  team.mate[0] = mate(2, 1, 0.1);
  team.mate[0].mirrored = 0.5F;
  team.mate[1] = mate(2, 1, 0.1);
  team.mate[1].plays = 0;
  put_together(std::nullopt, kNow, {}, 0, team);
  EXPECT_EQ(team.mates, 1U);
  EXPECT_EQ(team.ball_from, 0U);
}

TEST(TeamMap, TheOwnBallIsNoSurerThanTheOwnPlace) {
  msg::FieldPose pose;
  pose.x_m = -1, pose.y_m = 0.5, pose.heading_rad = math::kPi / 2;
  pose.covariance = {0.04, 0, 0, 0, 0.01, 0, 0, 0, 0.01};
  pose.found = 1, pose.mirrored = 0.01;
  msg::BallModel ball;
  ball.seen = kNow, ball.confidence = 0.9;
  ball.x_m = 2, ball.vx_mps = 0.5;
  ball.covariance[0] = 0.0009, ball.covariance[5] = 0.0001;
  const auto b = own_ball(ball, pose, {});
  ASSERT_TRUE(b);
  EXPECT_NEAR(b->x_m, -1, 1e-9);
  EXPECT_NEAR(b->y_m, 2.5, 1e-9);
  EXPECT_NEAR(b->vy_mps, 0.5, 1e-9);
  EXPECT_NEAR(b->covariance(0, 0), 0.04 + 0.0001 + 4 * 0.01, 1e-9) << "2 m ahead its heading moves it aside";
  EXPECT_NEAR(b->covariance(1, 1), 0.01 + 0.0009, 1e-9);
  msg::SoccerReport report;
  fill_report(pose, &ball, {}, report);
  EXPECT_NEAR(double{report.ball.y_m}, 2.5, 1e-6);
  EXPECT_EQ(report.has_ball, 0U);
  pose.found = 0;
  EXPECT_FALSE(own_ball(ball, pose, {}));
}

}  // namespace
}  // namespace sinew::soccer::team_map_test
