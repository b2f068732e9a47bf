// Legs solved for places of their foot.
#include "kinematics/leg.hpp"

#include <gtest/gtest.h>

#include "math/random.hpp"

namespace sinew::kinematics {
namespace {

using math::Vec3;

/// A leg with any lengths, bends, signs of axes, offsets that cancel, and a hip that may be tilted as NAO's.
Body any_leg(std::uint64_t seed) {
  math::Random random(seed);
  Body body;
  body.links.emplace_back().name = "torso";
  const auto add = [&](const char* name, const Vec3& at_m, const Vec3& axis, double least_rad, double most_rad) {
    Link link;
    link.name = name;
    link.parent = body.links.size() - 1;
    link.at_m = at_m;
    const bool turned = random.below(2) == 1;
    link.axis = turned ? -axis : axis;
    link.least_rad = turned ? -most_rad : least_rad;
    link.most_rad = turned ? -least_rad : most_rad;
    body.links.push_back(link);
  };
  const double tilt_rad = seed % 3 == 0 ? 0 : (seed % 3 == 1 ? math::kPi / 4 : -math::kPi / 4);
  const double down_m = random.uniform(0, 0.05), back_m = random.uniform(-0.03, 0.03),
               aside_m = random.uniform(-0.03, 0.03);
  const Vec3 first{0, -math::sin(tilt_rad), math::cos(tilt_rad)};
  add("yaw", Vec3{0.01, 0.05, -0.08} + first * random.uniform(-0.02, 0.02), first, -0.7, 0.7);
  // The second joint's origin may be anywhere on its axis, as the third's.
  const Vec3 hip = Vec3{0.01, 0.05, -0.08} + first * (tilt_rad == 0 ? -down_m : 0);
  add("roll", hip + Vec3{back_m, 0, 0} - BodyPose(body).link(1).p_m, {1, 0, 0}, -0.4, 0.4);
  add("pitch", {-back_m, aside_m, 0}, {0, 1, 0}, -1.4, 0.6);
  add("knee", {random.uniform(-0.01, 0.01), 0, -random.uniform(0.1, 0.3)}, {0, 1, 0}, 0.25, 2.2);
  add("ankle_pitch", {random.uniform(-0.01, 0.01), 0, -random.uniform(0.1, 0.3)}, {0, 1, 0}, -1.2, 1);
  add("ankle_roll", {back_m, -aside_m, 0}, {1, 0, 0}, -0.5, 0.5);
  return body;
}

Leg leg_of(const Body& body) {
  std::string why;
  const auto leg = Leg::make(body, 6, why);
  if (!leg) throw std::runtime_error(why);
  return *leg;
}

TEST(Leg, FindsTheAnglesThatBringItsFootSomewhere) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const Body body = any_leg(seed);
    const Leg leg = leg_of(body);
    BodyPose pose(body), again(body);
    math::Random random(seed, 1);
    for (int trial = 0; trial < 200; ++trial) {
      std::array<double, kLegJoints> rad{};
      for (std::size_t j = 0; j < kLegJoints; ++j)
        rad[j] = random.uniform(body.links[j + 1].least_rad, body.links[j + 1].most_rad);
      pose.set(rad);
      const LegAngles found = leg.solve(pose.link(6));
      ASSERT_TRUE(found.reached) << seed << ' ' << trial;
      again.set(found.rad);
      ASSERT_LT(norm(again.link(6).p_m - pose.link(6).p_m), 1e-9) << seed << ' ' << trial;
      ASSERT_LT(angle_between(again.link(6).q, pose.link(6).q), 1e-7) << seed << ' ' << trial;
      for (std::size_t j = 0; j < kLegJoints; ++j)
        ASSERT_NEAR(found.rad[j], rad[j], 1e-6) << seed << ' ' << trial << ' ' << j;
    }
  }
}

TEST(Leg, AFootThatIsTooFarIsReachedForWithAStraightKnee) {
  const Body body = any_leg(3);
  const Leg leg = leg_of(body);
  const LegAngles found = leg.solve({leg.hip_m() + Vec3{0, 0, -2 * leg.longest_m()}, {}});
  EXPECT_FALSE(found.reached);
  BodyPose pose(body);
  pose.set(found.rad);
  EXPECT_LT(norm(pose.link(6).p_m - leg.hip_m()), leg.longest_m() + 0.05);
  for (std::size_t j = 0; j < kLegJoints; ++j) {
    EXPECT_GE(found.rad[j], body.links[j + 1].least_rad);
    EXPECT_LE(found.rad[j], body.links[j + 1].most_rad);
  }
}

TEST(Leg, AnglesAreWithinTheirLimitsForAnyPlace) {
  const Body body = any_leg(4);
  const Leg leg = leg_of(body);
  math::Random random(4);
  int beyond = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const Pose foot{Vec3{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)},
                    math::Quat::exp({random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)})};
    const LegAngles found = leg.solve(foot);
    beyond += found.reached ? 0 : 1;
    for (std::size_t j = 0; j < kLegJoints; ++j) {
      EXPECT_GE(found.rad[j], body.links[j + 1].least_rad);
      EXPECT_LE(found.rad[j], body.links[j + 1].most_rad);
    }
  }
  EXPECT_GT(beyond, 900);
  EXPECT_FALSE(leg.solve({leg.hip_m(), {}}).reached) << "the foot in the hip";
}

TEST(Leg, SaysWhichJointIsNotWhereItHasToBe) {
  std::string why;
  Body body = any_leg(3);
  body.links[4].axis = {1, 0, 0};
  EXPECT_FALSE(Leg::make(body, 6, why));
  EXPECT_EQ(why, "knee: its axis has to be along y");
  body = any_leg(3);
  body.links[3].at_m.z += 0.01;
  EXPECT_FALSE(Leg::make(body, 6, why));
  EXPECT_EQ(why, "pitch: its axis has to meet that of the joint before it");
  body = any_leg(3);
  body.links[1].at_m.x += 0.01;
  body.links[2].at_m.x -= 0.01;
  EXPECT_FALSE(Leg::make(body, 6, why));
  EXPECT_EQ(why, "yaw: its axis has to go through the point where those of the next two joints meet");
  body = any_leg(3);
  body.links[6].at_m.y += 0.01;
  EXPECT_FALSE(Leg::make(body, 6, why));
  EXPECT_EQ(why, "ankle_roll: its axis has to be straight below the hip");
  EXPECT_FALSE(Leg::make(any_leg(3), 5, why));
  EXPECT_EQ(why, "a leg has six joints between link 0 and its foot");
}

}  // namespace
}  // namespace sinew::kinematics
