// The walk on a puppet: what it tells the joints, without a plant.
#include "motion/walk.hpp"

#include "math/random.hpp"
#include "op3.hpp"

namespace sinew::motion {
namespace {

Walk standing(const Op3& op3, const Puppet& puppet) {
  Walk walk(*op3.figure, op3.book.rest_rad);
  walk.params = op3.book.walk;
  // What servos need is tested beside it.
  walk.params.lead_s = walk.params.weight_ahead = walk.params.play_rad = 0;
  walk.params.gyro_pitch_s = walk.params.gyro_roll_s = walk.params.tilt_pitch = walk.params.tilt_roll = 0;
  walk.reset(puppet.sensed());
  return walk;
}

TEST(Walk, StandsOnFlatSolesAtItsHeightWithTheCentreOfMassBetweenThem) {
  const Op3 op3;
  Puppet puppet(op3);
  Walk walk = standing(op3, puppet);
  for (int i = 0; i < 100; ++i) puppet.step(walk, {});
  EXPECT_EQ(walk.phase(), WalkPhase::stand);
  kinematics::BodyPose pose(op3.body);
  const math::Quat lean = math::Quat::from_axis_angle({0, 1, 0}, walk.params.lean_rad);
  pose.set(puppet.targets_rad, {{}, lean});
  const kinematics::Pose left = op3.figure->sole(pose, Side::left), right = op3.figure->sole(pose, Side::right);
  EXPECT_NEAR(left.p_m.z, right.p_m.z, 1e-9);
  EXPECT_NEAR(left.p_m.y - right.p_m.y, walk.params.stance_m, 1e-9);
  EXPECT_LT(math::angle_between(left.q, {}), 1e-9);
  EXPECT_LT(math::angle_between(right.q, {}), 1e-9);
  const math::Vec3 com = pose.centre_of_mass();
  EXPECT_NEAR(com.x, left.p_m.x + walk.params.com_forward_m, 2e-3);
  EXPECT_NEAR(com.y, 0.5 * (left.p_m.y + right.p_m.y), 2e-3);
}

TEST(Walk, LandsItsFeetAsFarApartAsTheSpeedWants) {
  const Op3 op3;
  Puppet puppet(op3);
  Walk walk = standing(op3, puppet);
  walk.params.dcm_per_s = walk.params.com_per_s = walk.params.heading_per_s = 0;  // the plan alone
  walk.params.time_gain = 0;
  const double forward = 0.1;
  for (int i = 0; i < 600; ++i) puppet.step(walk, {.forward_mps = forward, .walk = true});
  ASSERT_GT(walk.steps(), 10u);
  EXPECT_NEAR(walk.landing().at_m.x, forward * walk.params.scale_forward * walk.params.period_s, 1e-3);
  EXPECT_NEAR(math::fabs(walk.landing().at_m.y), walk.params.stance_m, 1e-3);
  // Odometry follows the puppet's soles.
  EXPECT_NEAR(walk.odometry().at_m.x / (0.01 * 600 * forward * walk.params.scale_forward), 1, 0.3);
}

TEST(Walk, TurnsItsFeetAndItsOdometryByTheWantedRate) {
  const Op3 op3;
  Puppet puppet(op3);
  Walk walk = standing(op3, puppet);
  walk.params.heading_per_s = 0;
  double least = 0, most = 0;
  for (int i = 0; i < 600; ++i) {
    puppet.step(walk, {.turn_radps = 0.8, .walk = true});
    const double left_to_right = walk.landing().yaw_rad * (walk.support() == Side::right ? 1 : -1);
    if (i > 300) least = std::min(least, left_to_right), most = std::max(most, left_to_right);
  }
  EXPECT_NEAR(most - least, 2 * 0.8 * walk.params.scale_turn * walk.params.period_s, 0.02);
  EXPECT_GE(least, -walk.params.toe_in_rad - 1e-9);
}

TEST(Walk, TakesNoSpeedBeyondItsLimitsAndLessOfEachWhenAllAreWanted) {
  const Op3 op3;
  Puppet puppet(op3);
  Walk walk = standing(op3, puppet);
  for (int i = 0; i < 600; ++i) puppet.step(walk, {.forward_mps = 9, .walk = true});
  EXPECT_NEAR(walk.speed().forward_mps, walk.params.most_forward_mps * walk.params.scale_forward, 1e-9);
  for (int i = 0; i < 600; ++i) puppet.step(walk, {.forward_mps = 9, .left_mps = 9, .turn_radps = 9, .walk = true});
  EXPECT_NEAR(walk.speed().forward_mps, walk.params.most_forward_mps * walk.params.scale_forward / 3, 1e-9);
  EXPECT_NEAR(walk.speed().left_mps, walk.params.most_side_mps * walk.params.scale_side / 3, 1e-9);
}

TEST(Walk, ChangesItsSpeedNoFasterThanItsAcceleration) {
  const Op3 op3;
  Puppet puppet(op3);
  Walk walk = standing(op3, puppet);
  double before = 0;
  for (int i = 0; i < 400; ++i) {
    puppet.step(walk, {.forward_mps = 0.3, .walk = true});
    EXPECT_LE(walk.speed().forward_mps - before, walk.params.accel_mps2 * walk.params.period_s + 1e-12);
    before = walk.speed().forward_mps;
  }
}

TEST(Walk, ATouchEndsTheStepBeforeItsTimeAndAMissingOneNotForEver) {
  const Op3 op3;
  double lasts[2] = {};
  for (const int late : {0, 1}) {
    Puppet puppet(op3);
    puppet.lands_at = late ? 9 : 0.8;
    Walk walk = standing(op3, puppet);
    walk.params.time_gain = 0;
    walk.params.switch_grace_s = 0.06;
    for (int i = 0; i < 800; ++i) puppet.step(walk, {.walk = true});
    ASSERT_GT(walk.steps(), 10u);
    lasts[late] = (8 - walk.params.settle_s) / static_cast<double>(walk.steps());
  }
  EXPECT_LT(lasts[0], 0.95 * op3.book.walk.period_s);
  EXPECT_GT(lasts[1], op3.book.walk.period_s);
  EXPECT_LT(lasts[1], op3.book.walk.period_s + 0.06 + 0.03);
}

TEST(Walk, TargetsStayWithinTheJointsLimitsAndMoveWithoutJumpsWhateverIsCommanded) {
  const Op3 op3;
  Puppet puppet(op3);
  Walk walk = standing(op3, puppet);
  math::Random random(3);
  WalkCommand command{.walk = true};
  std::vector<double> before;
  double fastest = 0;
  for (int i = 0; i < 3000; ++i) {
    if (i % 150 == 0)
      command = {random.uniform(-0.5, 0.5), random.uniform(-0.3, 0.3), random.uniform(-2, 2), random.below(5) != 0};
    puppet.step(walk, command);
    for (std::size_t j = 0; j < op3.body.joints(); ++j) {
      ASSERT_GE(puppet.targets_rad[j], op3.body.links[j + 1].least_rad);
      ASSERT_LE(puppet.targets_rad[j], op3.body.links[j + 1].most_rad);
      if (i > 1) fastest = std::max(fastest, math::fabs(puppet.targets_rad[j] - before[j]));
    }
    before = puppet.targets_rad;
  }
  EXPECT_LT(fastest, 0.16);  // 16 rad/s: an ankle that lands early
}

TEST(Walk, StandsWithItsFeetBesideEachOtherAfterAStop) {
  const Op3 op3;
  Puppet puppet(op3);
  Walk walk = standing(op3, puppet);
  walk.params.heading_per_s = 0;  // the puppet's gyro says nothing of its turns
  for (int i = 0; i < 500; ++i) puppet.step(walk, {.forward_mps = 0.2, .turn_radps = 0.4, .walk = true});
  EXPECT_EQ(walk.phase(), WalkPhase::step);
  for (int i = 0; i < 400; ++i) puppet.step(walk, {});
  EXPECT_EQ(walk.phase(), WalkPhase::stand);
  EXPECT_NEAR(walk.stance().right_to_left.at_m.x, 0, 0.01);
  EXPECT_NEAR(walk.stance().right_to_left.at_m.y, walk.params.stance_m, 0.01);
  EXPECT_NEAR(walk.stance().right_to_left.yaw_rad, 0, 0.02);
}

/// How far ahead the foot will land, half a step after the torso was turned forward at this rate for 50 ms.
double landing_after(double rate_radps) {
  const Op3 op3;
  Puppet puppet(op3);
  Walk walk = standing(op3, puppet);
  for (int i = 0; i < 300; ++i) puppet.step(walk, {.walk = true});
  const std::uint64_t steps = walk.steps();
  while (walk.steps() == steps) puppet.step(walk, {.walk = true});
  double furthest = 0;
  for (int i = 0; i < 14; ++i) {
    puppet.gyro_radps.y = i < 5 ? rate_radps : 0;
    puppet.step(walk, {.walk = true});
    furthest = math::fabs(walk.landing().at_m.x) > math::fabs(furthest) ? walk.landing().at_m.x : furthest;
  }
  return furthest;
}

TEST(Walk, ABodyThatTipsPutsItsFootThere) {
  const double still = landing_after(0);
  EXPECT_GT(landing_after(4), still + 0.02);
  EXPECT_LT(landing_after(-4), still - 0.02);
}

TEST(Walk, AKickIsOneStepOfItsFootAndReachesBeyondTheOthers) {
  const Op3 op3;
  Puppet puppet(op3);
  Walk walk = standing(op3, puppet);
  kinematics::BodyPose pose(op3.body);
  const auto reach = [&](int steps) {
    double furthest = 0;
    for (int i = 0; i < steps; ++i) {
      puppet.step(walk, {.walk = true});
      pose.set(puppet.targets_rad);
      const kinematics::Pose left = op3.figure->sole(pose, Side::left), right = op3.figure->sole(pose, Side::right);
      furthest = std::max(furthest, right.q.conjugate().rotate(left.p_m - right.p_m).x);
    }
    return furthest;
  };
  reach(300);
  const double before = reach(100);
  walk.kick_forward = op3.book.step_kick_forward;
  walk.kick(Side::left, KickWay::forward);
  const double kicked = reach(150);
  EXPECT_GT(kicked, before + 0.7 * walk.kick_forward.strike_m);
  EXPECT_FALSE(walk.kicks());
  EXPECT_LT(reach(100), before + 0.01);
}

}  // namespace
}  // namespace sinew::motion
