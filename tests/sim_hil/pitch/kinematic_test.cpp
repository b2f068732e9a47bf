// The pitch without dynamics: feet that stand do not move, the ball rolls, the same interface.
#include "rig.hpp"
#include "sim_hil/pitch/wheeled.hpp"

namespace sinew::plant::kinematic_pitch_test {
namespace {

using math::Vec3;

PitchOptions kinematic() {
  PitchOptions o;
  o.kinematic = true;
  return o;
}

PitchBody crouching() {
  PitchBody kid{.body = kid_body("op3")};
  kid.start.joints_rad = crouched(kid.body, 0.02);
  return kid;
}

/// A stepping pattern by the closed-form legs: the right foot stands and pushes back, the left one swings.
std::vector<double> step_pose(const kinematics::Body& body, double left_x, double left_up, double right_x,
                              double right_up) {
  std::vector<double> rad(body.joints());
  const kinematics::BodyPose zero(body);
  const auto place = [&](const char* foot, double x, double up) {
    std::string why;
    const std::size_t link = *body.find_link(foot);
    const auto leg = kinematics::Leg::make(body, link, why);
    kinematics::Pose to = zero.link(link);
    to.p_m += Vec3{x, 0, 0.025 + up};
    const auto angles = leg->solve(to);
    EXPECT_TRUE(angles.reached);
    for (std::size_t i = 0; i < kinematics::kLegJoints; ++i) rad[leg->links()[i] - 1] = angles.rad[i];
  };
  place("l_ankle_roll", left_x, left_up);
  place("r_ankle_roll", right_x, right_up);
  return rad;
}

TEST(KinematicPitch, AFootThatStandsStaysWhereItIsAndTheBodyMovesOverIt) {
  PitchBody kid = crouching();
  kid.errors = BodyErrors::none();
  kid.start.x_m = 1, kid.start.heading_rad = 0.5;
  const auto pitch = pitch_with(kinematic(), {kid});
  const std::size_t left = *kid.body.find_link("l_ankle_roll"), right = *kid.body.find_link("r_ankle_roll");
  const BodyTruth& t = pitch->truth(0);
  const Vec3 from = t.torso.p_m;
  double worst = 0;
  for (int k = 0; k < 8; ++k) {  // steps of 2 x 0.02 m
    const bool left_swings = k % 2 == 0;
    const std::size_t standing = left_swings ? right : left;
    Vec3 held;
    for (int i = 0; i <= 100; ++i) {
      const double s = i / 100.0, forward = 0.02 * (2 * s - 1), up = 0.02 * math::sin(math::kPi * s);
      pitch->command(0, left_swings ? step_pose(kid.body, forward, up, -forward, 0)
                                    : step_pose(kid.body, -forward, 0, forward, up));
      pitch->step();
      if (i == 30) held = t.link[standing].p_m;
      if (i > 30 && i < 90) worst = std::max(worst, norm(t.link[standing].p_m - held));
    }
  }
  EXPECT_LT(worst, 1e-9) << "no slip";
  const Vec3 way = t.torso.p_m - from;
  EXPECT_NEAR(way.x * math::cos(0.5) + way.y * math::sin(0.5), 8 * 0.04, 0.03);
  EXPECT_NEAR(-way.x * math::sin(0.5) + way.y * math::cos(0.5), 0, 0.01);
  EXPECT_FALSE(t.fallen);
  EXPECT_NEAR(t.foot_n[0] + t.foot_n[1], 9.81 * kid.body.mass_kg(), 1e-6);
}

TEST(KinematicPitch, TheImuOfARobotThatStandsFeelsNoBlowsWhenItsFeetComeDownAskew) {
  PitchBody kid = crouching();
  kid.errors = BodyErrors::none();
  const auto pitch = pitch_with(kinematic(), {kid});
  const std::size_t ankle = *kid.body.find_link("l_ankle_roll") - 1;
  double most_gyro = 0, most_tilt = 0, most_accel = 0;
  for (int k = 0; k < 6; ++k) {
    std::vector<double> pose = k % 2 == 0 ? step_pose(kid.body, 0, 0.02, 0, 0) : step_pose(kid.body, 0, 0, 0, 0.02);
    if (k % 2 == 0) pose[ankle] += 0.2;
    pitch->command(0, pose);
    for (int i = 0; i < 100; ++i) {
      pitch->step();
      const BodySensors& s = pitch->sensors(0);
      most_gyro = std::max(most_gyro, math::hypot(s.gyro_radps.x, s.gyro_radps.y));
      most_accel = std::max(most_accel, std::abs(norm(s.accel_mps2) - 9.81));
      most_tilt = std::max(most_tilt, pitch->truth(0).tilt_rad);
    }
  }
  EXPECT_GT(most_tilt, 0.05) << "the torso leans with the foot";
  EXPECT_LT(most_gyro, 0.01);
  EXPECT_LT(most_accel, 0.01);
}

TEST(KinematicPitch, JointsAreNoFasterThanTheirServosAndDelayedAsThem) {
  PitchBody kid = crouching();
  kid.errors = BodyErrors::none();
  kid.errors.command_delay_ms = 20;
  const auto pitch = pitch_with(kinematic(), {kid});
  const std::size_t head = *kid.body.find_link("head_pan") - 1;
  pitch->command(0, head, {DriveMode::position, 1});
  run(*pitch, 0.02);
  EXPECT_EQ(pitch->truth(0).joint_rad[head], 0);
  run(*pitch, 0.1);
  EXPECT_NEAR(pitch->truth(0).joint_rad[head], 0.48, 0.02);
  run(*pitch, 0.3);
  EXPECT_NEAR(pitch->truth(0).joint_rad[head], 1, 1e-9);
}

TEST(KinematicPitch, TheBallRollsIsKickedBouncesAndStaysInTheNet) {
  PitchBody kid = crouching();
  const auto pitch = pitch_with(kinematic(), {kid});
  pitch->command(0, kid.start.joints_rad);
  pitch->place_ball({-3, 1, 0}, {1.2, -0.5, 0});
  run(*pitch, 6);
  EXPECT_NEAR(math::hypot(pitch->ball().p_m.x + 3, pitch->ball().p_m.y - 1), 1.3 * 1.3 / (2 * 0.35), 0.01);
  pitch->place_ball({0.2, -0.05, 0});
  auto swung = kid.start.joints_rad;
  swung[*kid.body.find_link("r_hip_pitch") - 1] -= 0.8;
  pitch->command(0, swung);
  run(*pitch, 0.4);
  EXPECT_GT(pitch->ball().v_mps.x, 0.3);
  EXPECT_EQ(pitch->ball().touched_by, 0);
  pitch->place_ball({4, 0.3, 0}, {3, 0, 0});
  EXPECT_EQ(pitch->ball().touched_by, -1) << "nobody has touched it there";
  run(*pitch, 4);
  EXPECT_GT(pitch->ball().p_m.x, 4.5);
  EXPECT_LT(pitch->ball().p_m.x, 5.1);
  const double post = kKidField.goal_width_m / 2 + kKidField.post_radius_m;
  pitch->place_ball({3.9, post, 0}, {2, 0, 0});
  run(*pitch, 2);
  EXPECT_LT(pitch->ball().p_m.x, 4.45);
}

TEST(KinematicPitch, WheelsDriveAndPaddlesHold) {
  const auto pitch = pitch_with(kinematic(), {pioneer_body({.x_m = -1})});
  drive_wheels(*pitch, 0, {.forward_mps = 0.5, .turn_radps = 0.5});
  run(*pitch, 2.03);
  const BodyTruth& t = pitch->truth(0);
  EXPECT_NEAR(t.torso.q.yaw(), 1, 0.03);
  EXPECT_NEAR(t.torso.p_m.x, -1 + math::sin(1.0), 0.03);
  EXPECT_NEAR(t.torso.p_m.y, 1 - math::cos(1.0), 0.03);
  grip(*pitch, 0, 0.15);
  drive_wheels(*pitch, 0, {});
  run(*pitch, 2);
  EXPECT_NEAR(norm(t.link[1 + kLeftPaddle].p_m - t.link[1 + kRightPaddle].p_m), 0.15 + kPioneer.paddle_thick_m, 0.002);
}

TEST(KinematicPitch, ARobotThatLiesStaysThereUntilItIsPlaced) {
  PitchBody kid = crouching();
  kid.start.lie = PitchPlace::Lie::on_back;
  const auto pitch = pitch_with(kinematic(), {kid});
  run(*pitch, 1);
  EXPECT_TRUE(pitch->truth(0).fallen);
  EXPECT_TRUE(pitch->truth(0).body_down);
  kid.start.lie = PitchPlace::Lie::upright;
  pitch->place(0, kid.start);
  run(*pitch, 0.1);
  EXPECT_FALSE(pitch->truth(0).fallen);
}

}  // namespace
}  // namespace sinew::plant::kinematic_pitch_test
