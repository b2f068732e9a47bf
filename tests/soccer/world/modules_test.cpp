// The modules: what they publish, and what referee and mates tell them.
#include <gtest/gtest.h>

#include "apps/locate/field_walk.hpp"
#include "rt/exec/module_rig.hpp"
#include "soccer/world/locate.hpp"
#include "soccer/world/team.hpp"
#include "soccer/world/track_ball.hpp"
#include "soccer/world/track_obstacles.hpp"

namespace sinew::soccer::modules_test {
namespace {

using namespace std::chrono_literals;

struct LocateRig {
  const Field field;
  locate::FieldWalk walk{field, 12};
  Locate locate;
  rt::ModuleRig rig{locate};
  msg::GaitMode mode = msg::GaitMode::walk;

  LocateRig() {
    const FieldAt at = walk.truth();
    if (at.x_m > 0) walk.put(at.mirrored());
  }
  const msg::FieldPose* step(int pictures = 1) {
    rt::StepStatus status = rt::StepStatus::stale;
    for (int i = 0; i < pictures; ++i) {
      const msg::SoccerSight& seen = walk.step();
      rig.put("sight", seen);
      msg::GaitState gait;
      gait.stamp = seen.stamp;
      gait.mode = mode;
      rig.put("gait", gait);
      status = rig.step(seen.stamp + 30ms, 50ms);
    }
    return status == rt::StepStatus::ok ? rig.get<msg::FieldPose>("pose") : nullptr;
  }
  void say(msg::GamePenalty penalty, std::uint32_t attacks_right = 1, std::uint32_t half = 1) {
    msg::RefereeState said;
    said.stamp = rig_now();
    said.phase = msg::GamePhase::playing;
    said.half = half;
    said.penalty = penalty;
    said.attacks_right = attacks_right;
    rig.put("referee", said);
  }
  /// It sees a ball there, and a mate reports one; frame "field" of the first half.
  void put_ball(const FieldPoint& ball, const FieldPoint& of_mate) {
    const FieldPoint own = walk.truth().in(ball.x_m, ball.y_m);
    msg::BallModel seen;
    seen.stamp = seen.seen = rig_now();
    seen.x_m = own.x_m, seen.y_m = own.y_m, seen.confidence = 0.9;
    seen.covariance[0] = seen.covariance[5] = 0.02;
    rig.put("ball", seen);
    msg::FromMate<msg::SoccerReport> mate;
    mate.stamp = mate.received = mate.message.stamp = mate.message.ball_seen = rig_now();
    mate.robot = 2;
    mate.message.mirrored = 0.01F, mate.message.plays = 1, mate.message.ball_confidence = 0.9F;
    mate.message.ball = {static_cast<float>(of_mate.x_m), static_cast<float>(of_mate.y_m), 0.02F, 0, 0.02F};
    rig.put("mates", mate);
  }
  msg::Time rig_now() const { return {static_cast<std::int64_t>(1e9 * walk.now_s())}; }
  double off_m(const msg::FieldPose& p) const { return distance_m({p.x_m, p.y_m, 0}, walk.truth()); }
};

TEST(Locate, PublishesThePlaceForEachPicture) {
  LocateRig r;
  const msg::FieldPose* pose = r.step(200);
  ASSERT_NE(pose, nullptr);
  EXPECT_EQ(pose->found, 1U);
  EXPECT_LT(r.off_m(*pose), 0.2);
  EXPECT_LT(pose->mirrored, 0.1);
  const msg::NavState* nav = r.rig.get<msg::NavState>("nav");
  ASSERT_NE(nav, nullptr);
  EXPECT_EQ(nav->p_world_m.x, pose->x_m);
}

TEST(Locate, TheWorldsAxesAreTurnedForTheTeamThatAttacksLeft) {
  LocateRig r;
  r.say(msg::GamePenalty::none, 0);
  const msg::FieldPose* pose = r.step(200);
  ASSERT_NE(pose, nullptr);
  const msg::NavState* nav = r.rig.get<msg::NavState>("nav");
  ASSERT_NE(nav, nullptr);
  EXPECT_EQ(nav->p_world_m.x, -pose->x_m);
  EXPECT_EQ(nav->p_world_m.y, -pose->y_m);
}

TEST(Locate, AfterAPenaltyItComesBackOverTheTouchLineOfItsOwnHalf) {
  LocateRig r;
  r.step(200);
  r.say(msg::GamePenalty::incapable);
  r.step(10);
  r.say(msg::GamePenalty::none);
  r.walk.put({-2, -2.975, math::kPi / 2});
  const msg::FieldPose* pose = r.step(80);  // 4 s
  ASSERT_NE(pose, nullptr);
  EXPECT_EQ(pose->found, 1U);
  EXPECT_LT(r.off_m(*pose), 0.3);
  EXPECT_LT(pose->mirrored, 0.05);
}

TEST(Locate, AtHalfTimeItStaysWhereItIsAndTheFieldTurns) {
  LocateRig r;
  r.say(msg::GamePenalty::none);
  const msg::FieldPose* pose = r.step(200);
  ASSERT_NE(pose, nullptr);
  ASSERT_LT(r.off_m(*pose), 0.2);
  r.say(msg::GamePenalty::none, 0, 2);
  for (int i = 0; i < 100; ++i) {
    pose = r.step();
    ASSERT_NE(pose, nullptr);
    EXPECT_EQ(pose->found, 1U) << i;
    EXPECT_LT(distance_m({pose->x_m, pose->y_m, 0}, r.walk.truth().mirrored()), 0.2) << i;
    EXPECT_LT(pose->mirrored, 0.1) << i;
  }
}

TEST(Locate, AMateThatHearsOfTheChangeOfEndsLaterTurnsNobodyBack) {
  LocateRig r;
  r.say(msg::GamePenalty::none);
  ASSERT_NE(r.step(200), nullptr);
  r.say(msg::GamePenalty::none, 0, 2);
  for (int i = 0; i < 12; ++i) {
    const bool knows = i >= 3;  // a second and a half later
    r.put_ball({2, 1}, knows ? FieldPoint{-2, -1} : FieldPoint{2, 1});
    const msg::FieldPose* pose = r.step(10);
    ASSERT_NE(pose, nullptr);
    EXPECT_LT(pose->mirrored, 0.1) << i;
    EXPECT_LT(distance_m({pose->x_m, pose->y_m, 0}, r.walk.truth().mirrored()), 0.3) << i;
  }
}

TEST(Locate, SaysNothingWithoutPicturesOrGait) {
  Locate locate;
  rt::ModuleRig rig{locate};
  EXPECT_EQ(rig.step(msg::Time{1'000'000'000}, 50ms), rt::StepStatus::stale);
  rig.put("sight", msg::SoccerSight{});
  EXPECT_EQ(rig.step(msg::Time{1'050'000'000}, 50ms), rt::StepStatus::stale);
}

TEST(Locate, ARobotThatLiesBecomesLessSure) {
  LocateRig r;
  const double before = r.step(200)->covariance[0];
  r.mode = msg::GaitMode::lie;
  EXPECT_GT(r.step(60)->covariance[0], 4 * before);
}

TEST(Locate, AMatesBallTellsWhichHalfItIsIn) {
  LocateRig r;
  r.rig.set("own_half", false);
  r.rig.reset();
  r.step(200);
  ASSERT_EQ(r.rig.get<msg::FieldPose>("pose")->mirrored, 0.5);
  for (int i = 0; i < 8; ++i) {
    r.put_ball({2, 1}, {2, 1});
    r.step(10);
  }
  const msg::FieldPose* pose = r.rig.get<msg::FieldPose>("pose");
  EXPECT_LT(pose->mirrored, 0.02);
  EXPECT_LT(r.off_m(*pose), 0.3);
}

TEST(TrackBall, SaysWhereTheBallIsOnTheField) {
  TrackBall track;
  rt::ModuleRig rig{track};
  msg::Time now{1'000'000'000};
  for (int i = 0; i < 5; ++i) {
    msg::SoccerSight sight;
    sight.stamp = now;
    sight.balls = 1;
    sight.ball[0].at = {1, 0.5F, 0.01F, 0, 0.01F};
    sight.ball[0].confidence = 0.9F;
    rig.put("sight", sight);
    msg::FieldPose pose;
    pose.stamp = now;
    pose.x_m = 2, pose.heading_rad = math::kPi;
    rig.put("field", pose);
    ASSERT_EQ(rig.step(now + 20ms, 50ms), rt::StepStatus::ok);
    now = now + 50ms;
  }
  const msg::BallModel* ball = rig.get<msg::BallModel>("ball");
  ASSERT_NE(ball, nullptr);
  EXPECT_NEAR(ball->x_m, 1, 1e-6);
  EXPECT_NEAR(ball->field_x_m, 1, 1e-6);
  EXPECT_NEAR(ball->field_y_m, -0.5, 1e-6);
  EXPECT_EQ(ball->sightings, 4U) << "the first makes the filter";
}

TEST(TrackObstacles, SaysWhichRobotsAreInTheWay) {
  TrackObstacles track;
  rt::ModuleRig rig{track};
  for (int i = 0; i < 8; ++i) {
    msg::SoccerSight sight;
    sight.stamp = {1'000'000'000 + i * 50'000'000};
    sight.robots = 1;
    sight.robot[0] = {{1.5F, 0, 0.01F, 0, 0.01F}, 0.8F, msg::JerseyColour::blue};
    rig.put("sight", sight);
    ASSERT_EQ(rig.step(sight.stamp + 20ms, 50ms), rt::StepStatus::ok);
  }
  const msg::ObstacleModel* m = rig.get<msg::ObstacleModel>("obstacles");
  ASSERT_NE(m, nullptr);
  ASSERT_EQ(m->obstacles, 1U);
  EXPECT_EQ(m->obstacle[0].colour, msg::JerseyColour::blue);
}

TEST(Team, ReportsTheOwnBallAndPutsTogetherWhatTheMatesSay) {
  Team team;
  rt::ModuleRig rig{team};
  const msg::Time now{5'000'000'000};
  msg::FieldPose pose;
  pose.stamp = now;
  pose.found = 1, pose.mirrored = 0.01;
  pose.covariance = {0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.0001};
  rig.put("field", pose);
  msg::GaitState gait;
  gait.stamp = now, gait.mode = msg::GaitMode::walk;
  rig.put("gait", gait);
  msg::BallModel ball;
  ball.stamp = ball.seen = now;
  ball.x_m = 2, ball.confidence = 0.9;
  ball.covariance[0] = ball.covariance[5] = 0.01;
  rig.put("ball", ball);
  msg::TeamState state;
  state.stamp = now;
  state.mates = 2;
  state.mate[0].robot = 3, state.mate[1].robot = 5;
  rig.put("state", state);
  msg::FromMate<msg::SoccerReport> mate;
  mate.stamp = mate.message.stamp = mate.message.ball_seen = now;
  mate.robot = 5;
  mate.message.mirrored = 0.01F, mate.message.plays = 1, mate.message.ball_confidence = 0.9F;
  mate.message.ball = {2.2F, 0, 0.02F, 0, 0.02F};
  rig.put("mates", mate);
  ASSERT_EQ(rig.step(now + 20ms, 100ms), rt::StepStatus::ok);
  const msg::SoccerReport* report = rig.get<msg::SoccerReport>("report");
  const msg::TeamModel* model = rig.get<msg::TeamModel>("team");
  ASSERT_TRUE(report && model);
  EXPECT_EQ(report->plays, 1U);
  EXPECT_NEAR(double{report->ball.x_m}, 2, 1e-6);
  EXPECT_NEAR(double{report->to_ball_s}, 2 / 0.2, 1e-3);
  EXPECT_EQ(model->mates, 1U);
  EXPECT_EQ(model->ball_from, (1U << kOwnBallBit) | 2U) << "the second mate of the robot file";
  EXPECT_NEAR(model->ball_x_m, 2.1, 0.03);
}

/// Robot 3 of a team in virtual time: mates 2 and 5 report twice a second. The ball lies at (2, 0) before it.
class TeamFor : public testing::Test {
 protected:
  /// What a mate says of a ball at `x`; nothing while it is dead.
  void says(std::uint32_t robot, double x, float variance, msg::SoccerRole role, float to_ball_s) {
    msg::FromMate<msg::SoccerReport> mate;
    mate.stamp = mate.message.stamp = mate.message.ball_seen = now_;
    mate.robot = robot;
    mate.message.mirrored = 0.01F, mate.message.plays = 1, mate.message.ball_confidence = 0.98F;
    mate.message.ball = {static_cast<float>(x), 0, variance, 0, variance};
    mate.message.role = role, mate.message.to_ball_s = to_ball_s;
    rig_.put("mates", mate);
  }
  const msg::TeamModel& step(bool sees) {
    msg::FieldPose pose;
    pose.stamp = now_;
    pose.found = 1, pose.mirrored = 0.01;
    pose.covariance = {0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.0001};
    rig_.put("field", pose);
    msg::GaitState gait;
    gait.stamp = now_, gait.mode = msg::GaitMode::walk;
    rig_.put("gait", gait);
    if (sees) {
      msg::BallModel ball;
      ball.stamp = ball.seen = now_;
      ball.x_m = 2, ball.confidence = 0.7;
      ball.covariance[0] = ball.covariance[5] = 0.04;
      rig_.put("ball", ball);
    }
    msg::TeamState state;
    state.stamp = now_;
    state.robot = 3, state.mates = 2;
    state.mate[0].robot = 2, state.mate[1].robot = 5;
    rig_.put("state", state);
    EXPECT_EQ(rig_.step(now_ + 20ms, 500ms), rt::StepStatus::ok);
    now_ = now_ + 500ms;
    return *rig_.get<msg::TeamModel>("team");
  }
  Team team_;
  rt::ModuleRig rig_{team_};
  msg::Time now_{5'000'000'000};
};

TEST_F(TeamFor, TenSecondsAMateThatLiesMovesTheBallOfNobodyAndTakesNoRole) {
  for (int i = 0; i < 4; ++i) {
    says(2, 2, 0.04F, msg::SoccerRole::goalie, 12);
    says(5, 2, 0.04F, msg::SoccerRole::supporter, 15);
    EXPECT_EQ(step(true).role, msg::SoccerRole::striker);
  }
  // Robot 5 says for 10 s, very sure, that the ball lies 3 m beside where it is, at its feet. The goalie does not see
  // it all of the time, and half of all that is said is lost.
  for (int i = 0; i < 20; ++i) {
    if (i % 4 == 1) says(2, 2, 0.04F, msg::SoccerRole::goalie, 12);
    if (i % 2 == 0) says(5, -1, 0.0001F, msg::SoccerRole::supporter, 0.1F);
    const msg::TeamModel& model = step(i % 5 != 3);  // it looks away for half a second, now and then
    EXPECT_NEAR(model.ball_x_m, 2, 0.3) << i;
    EXPECT_EQ(model.distrusted, 2U) << i;
    EXPECT_EQ(model.role, msg::SoccerRole::striker) << i;
  }
  // It tells the truth again, and is believed at once.
  says(2, 2, 0.04F, msg::SoccerRole::goalie, 12);
  says(5, 2, 0.04F, msg::SoccerRole::supporter, 0.1F);
  const msg::TeamModel& after = step(true);
  EXPECT_EQ(after.distrusted, 0U);
  EXPECT_EQ(after.role, msg::SoccerRole::supporter) << "the other one is at the ball";
}

/// Its clock begins anywhere: 5 s here.
TEST_F(TeamFor, ALiarReportsAWrongBallVerySureInItsTimeAndBelievesTheTruth) {
  rig_.set("lie_m", 3.0);
  rig_.set("lie_from_s", 2.0);
  rig_.set("lie_for_s", 10.0);
  int lies = 0;
  for (; now_ < msg::Time{20'000'000'000};) {
    const double t_s = msg::seconds(now_) - 5;  // since the first step
    const bool lying = t_s >= 2 && t_s < 12;
    const msg::TeamModel& model = step(true);
    const msg::SoccerReport& said = *rig_.get<msg::SoccerReport>("report");
    EXPECT_NEAR(double{said.ball.x_m}, lying ? -1 : 2, 1e-6) << t_s;
    EXPECT_EQ(said.ball.xx_m2 < 1e-3F, lying) << t_s;
    EXPECT_NEAR(model.ball_x_m, 2, 1e-6) << "its own ball is the true one";
    lies += lying;
  }
  EXPECT_EQ(lies, 20);
}

TEST_F(TeamFor, TheRoleOfAMateThatDiesIsTakenOverWithinThreeSeconds) {
  for (int i = 0; i < 6; ++i) {
    says(2, 2, 0.04F, msg::SoccerRole::goalie, 12);
    says(5, 2, 0.04F, msg::SoccerRole::striker, 1);
    EXPECT_EQ(step(true).role, msg::SoccerRole::supporter);
  }
  // The striker dies.
  const msg::Time died = now_;
  msg::SoccerRole role = msg::SoccerRole::supporter;
  while (role == msg::SoccerRole::supporter && now_ - died < 10s) {
    says(2, 2, 0.04F, msg::SoccerRole::goalie, 12);
    role = step(true).role;
  }
  EXPECT_EQ(role, msg::SoccerRole::striker);
  EXPECT_LE(msg::seconds(now_ - died), 3.0);
  // Then the goalie, too: the last one goes to the ball.
  for (int i = 0; i < 8; ++i) role = step(true).role;
  EXPECT_EQ(role, msg::SoccerRole::striker);
}

}  // namespace
}  // namespace sinew::soccer::modules_test
