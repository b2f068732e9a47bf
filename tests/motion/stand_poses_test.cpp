// Poses for calibration, and soles that are laid flat.
#include "motion/stand_poses.hpp"

#include <gtest/gtest.h>

#include "motion/sole_level.hpp"
#include "op3.hpp"

namespace sinew::motion::stand_poses_test {
namespace {

TEST(StandPoses, KeepBothSolesOnTheGroundAndTheWeightBetweenThem) {
  const Op3 op3;
  const kinematics::Body& body = op3.body;
  const auto& figure = op3.figure;
  const StandPosesOptions options;
  const auto poses = stand_poses(*figure, options);
  ASSERT_EQ(poses.size(), options.poses);
  kinematics::BodyPose pose(body);
  for (const JointAngles& rad : poses) {
    pose.set({rad.data(), figure->joints()});
    const kinematics::Pose left = figure->sole(pose, Side::left),
                           right = left.inverse() * figure->sole(pose, Side::right);
    EXPECT_NEAR(right.p_m.z, 0, 1e-6);
    EXPECT_NEAR(right.p_m.y, -options.stance_m, 1e-6);
    EXPECT_LT(angle_between(right.q, {}), 1e-6);
    const math::Vec3 weight = left.inverse().of(pose.centre_of_mass()) + math::Vec3{0, options.stance_m / 2, 0};
    EXPECT_LT(math::fabs(weight.x), options.shift_m + 0.003);
    EXPECT_LT(math::fabs(weight.y), options.shift_m + 0.003);
  }
  EXPECT_NE(poses[0], poses[1]);
  EXPECT_EQ(stand_poses(*figure, options)[7], poses[7]) << "the same for the same seed";
}

TEST(SoleLevel, TurnsASoleAwayFromTheEdgeThatIsPressed) {
  const Op3 op3;
  const kinematics::Body& body = op3.body;
  const auto& figure = op3.figure;
  SoleLevel level(*figure);
  const std::size_t roll = *body.find_link("l_ankle_roll"), sign_roll = body.links[roll].axis.x > 0 ? 1 : 0;
  ASSERT_EQ(sign_roll, 1u);
  level.step({SoleForces{6, 2, 6, 2}, SoleForces{4, 4, 4, 4}}, 0.1);  // the left sole's left edge
  std::vector<double> rad(body.joints());
  level.add_to(rad);
  EXPECT_NEAR(rad[roll - 1], SoleLevel::kGain_radps * 0.1 * 0.5, 1e-12) << "its left side goes up";
  EXPECT_EQ(level.turn_rad[3], 0) << "the other sole is pressed evenly";
  SoleLevel strained(*figure);
  strained.step({SoleForces{6, 6, 2, 2}, SoleForces{2, 2, 6, 6}}, 0.1);  // toes of one, heel of the other
  EXPECT_LT(strained.turn_rad[0], 0) << "its toes go up";
  SoleLevel leaning(*figure);
  leaning.step({SoleForces{6, 6, 2, 2}, SoleForces{6, 6, 2, 2}}, 0.1);
  EXPECT_GT(leaning.turn_rad[0], 0) << "the weight is in front: it leans back, against its toes";
  SoleLevel lifted(*figure);
  lifted.step({SoleForces{6, 2, 6, 2}, SoleForces{}}, 0.1);
  EXPECT_EQ(lifted.turn_rad[1], 0) << "a foot is in the air";
  EXPECT_TRUE(lie_flat({SoleForces{4, 4, 4, 4}, SoleForces{1, 2, 3, 4}}));
  EXPECT_FALSE(lie_flat({SoleForces{4, 4, 4, 4}, SoleForces{0, 2, 3, 4}}));
  EXPECT_FALSE(lie_flat({SoleForces{}, SoleForces{1, 2, 3, 4}}));
}

}  // namespace
}  // namespace sinew::motion::stand_poses_test
