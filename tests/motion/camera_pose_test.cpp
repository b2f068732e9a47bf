// Where a camera was at an instant between two measurements.
#include "motion/camera_pose.hpp"

#include "op3.hpp"

namespace sinew::motion {
namespace {

using kinematics::Pose;
using Found = CameraHistory::Found;

Pose at(double x_m, double yaw_rad) { return {{x_m, 0, 0}, math::Quat::exp({0, 0, yaw_rad})}; }

TEST(CameraHistory, APoseLiesOnTheLineBetweenTheMeasurementsAroundTheInstant) {
  CameraHistory history;
  history.add(1000, at(1, 0));
  history.add(2000, at(2, 0.4));
  history.add(3000, at(4, -0.2));
  Pose pose;
  ASSERT_EQ(history.at(1250, pose), Found::yes);
  EXPECT_DOUBLE_EQ(pose.p_m.x, 1.25);
  EXPECT_NEAR(pose.q.yaw(), 0.1, 1e-12);
  ASSERT_EQ(history.at(2000, pose), Found::yes);
  EXPECT_EQ(pose.p_m.x, 2);
  ASSERT_EQ(history.at(3000, pose), Found::yes);
  EXPECT_EQ(pose.p_m.x, 4);
}

TEST(CameraHistory, NothingIsSaidOutsideOfTheMeasurements) {
  CameraHistory history;
  Pose pose = at(7, 0);
  EXPECT_EQ(history.at(5, pose), Found::not_yet);
  for (std::int64_t i = 1; i <= 40; ++i) history.add(10 * i, at(static_cast<double>(i), 0));
  EXPECT_EQ(history.at(401, pose), Found::not_yet);
  EXPECT_EQ(history.at(89, pose), Found::too_old) << "32 are kept: 90 to 400";
  EXPECT_EQ(pose.p_m.x, 7);
  EXPECT_EQ(history.at(95, pose), Found::yes);
  EXPECT_DOUBLE_EQ(pose.p_m.x, 9.5);
}

TEST(CameraHistory, AMeasurementThatIsNotLaterIsLeftOut) {
  CameraHistory history;
  history.add(100, at(1, 0));
  history.add(100, at(2, 0));
  history.add(50, at(3, 0));
  Pose pose;
  ASSERT_EQ(history.at(100, pose), Found::yes);
  EXPECT_EQ(pose.p_m.x, 1);
  EXPECT_EQ(history.at(99, pose), Found::too_old);
}

TEST(CameraChain, TheLowestCornerOfTheSolesIsOnTheGround) {
  const Op3 op3;
  CameraChain chain(*op3.figure, *op3.body.find_place("camera"));
  std::vector<double> zero(op3.body.joints());
  const Pose upright = chain.camera({}, {0.5, -0.25}, zero);
  const Pose leant = chain.camera(math::Quat::exp({0, 0.2, 0}), {0.5, -0.25}, zero);
  const math::Vec3 ahead = upright.q.rotate({0, 0, 1}), right = upright.q.rotate({1, 0, 0});
  EXPECT_GT(ahead.x, 0.9);
  EXPECT_NEAR(right.y, -1, 1e-12);
  EXPECT_NEAR(upright.p_m.y, -0.25, 1e-12);
  EXPECT_GT(upright.p_m.z, 0.4);
  EXPECT_LT(upright.p_m.z, 0.55);
  // On the toes: the camera is turned with the torso about them, and higher than by a turn about the ankles.
  EXPECT_NEAR(math::angle_between(upright.q, leant.q), 0.2, 1e-9);
  const LegOfFigure& leg = op3.figure->leg(Side::left);
  kinematics::BodyPose straight(op3.body);
  straight.set(zero);
  const Pose sole = op3.figure->sole(straight, Side::left);
  const double toe_x = sole.p_m.x + 0.5 * leg.sole_length_m;
  const math::Vec3 camera = straight.place(*op3.body.find_place("camera")).p_m;
  const double expected_z = (camera.z - sole.p_m.z) * math::cos(0.2) + (toe_x - camera.x) * math::sin(0.2);
  EXPECT_NEAR(leant.p_m.z, expected_z, 1e-9);
}

}  // namespace
}  // namespace sinew::motion
