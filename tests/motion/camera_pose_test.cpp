// Where a camera was at an instant between two measurements.
#include "motion/camera_pose.hpp"

#include "motion/stance.hpp"
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

TEST(CameraPose, LooksWhereTheHeadIsTurned) {
  const Op3 op3;
  kinematics::BodyPose body(op3.body);
  std::vector<double> rad(op3.body.joints());
  rad[op3.figure->head_pan()] = 0.5;
  body.set(rad, {{1, 2, 0.3}, math::Quat::exp({0, 0, 0.25})});
  const Pose camera = camera_pose(body, *op3.body.find_place("camera"));
  const math::Vec3 ahead = camera.q.rotate({0, 0, 1}), right = camera.q.rotate({1, 0, 0});
  EXPECT_NEAR(math::atan2(ahead.y, ahead.x), 0.75, 1e-9);
  EXPECT_NEAR(math::atan2(right.y, right.x), 0.75 - math::kPi / 2, 1e-9);
  EXPECT_NEAR(right.z, 0, 1e-9);
  EXPECT_GT(camera.p_m.z, 0.45);
}

TEST(Stance, TheTorsosHeightIsOverTheLowestCornerOfASole) {
  const Op3 op3;
  const std::vector<double> zero(op3.body.joints());
  const Sensed sensed{zero, {}, {}, {}};
  StanceSense sense(*op3.figure);
  sense.step(sensed, {}, 0);
  const double upright_m = sense.stance().height_m[0];
  EXPECT_NEAR(sense.stance().raised_m[0], 0, 1e-12);
  sense.step(sensed, math::Quat::exp({0, 0.2, 0}), 0);
  // On the toes: turned about them.
  const LegOfFigure& leg = op3.figure->leg(Side::left);
  kinematics::BodyPose straight(op3.body);
  straight.set(zero);
  const double toe_x_m = op3.figure->sole(straight, Side::left).p_m.x + 0.5 * leg.sole_length_m;
  EXPECT_NEAR(sense.stance().height_m[0], upright_m * math::cos(0.2) + toe_x_m * math::sin(0.2), 1e-9);
  EXPECT_NEAR(sense.stance().raised_m[0], 0.5 * leg.sole_length_m * math::sin(0.2), 1e-9);
}

}  // namespace
}  // namespace sinew::motion
