// The wheeled robot with its gripper.
#include "sim_hil/pitch/wheeled.hpp"

#include "rig.hpp"

namespace sinew::plant::wheeled_test {
namespace {

TEST(WheeledRobot, DrivesAsItIsToldAndItsEncodersCountTheWay) {
  const auto pitch = pitch_with({.has_ball = false}, {pioneer_body()});
  run(*pitch, 0.5);
  const auto wheels = [&] {
    const BodySensors& s = pitch->sensors(0);
    return std::pair(s.joint[kLeftWheel].position_rad, s.joint[kRightWheel].position_rad);
  };
  const auto [left0, right0] = wheels();
  const math::Vec3 from = pitch->truth(0).torso.p_m;
  drive_wheels(*pitch, 0, {.forward_mps = 0.5});
  run(*pitch, 2);
  const BodyTruth& t = pitch->truth(0);
  EXPECT_NEAR(t.torso.q.conjugate().rotate(t.v_world_mps).x, 0.5, 0.04);
  const double way = t.torso.p_m.x - from.x;
  const auto [left, right] = wheels();
  EXPECT_NEAR(way, 0.5 * 2, 0.1);
  EXPECT_NEAR((left - left0 + right - right0) / 2 * kPioneer.wheel_radius_m, way, 0.03);
  EXPECT_FALSE(t.fallen);

  drive_wheels(*pitch, 0, {.turn_radps = 1});
  run(*pitch, 1);
  const double yaw = t.torso.q.yaw();
  run(*pitch, 1);
  // Wide tyres and the caster scrub: it turns by some less than its track says, as the real one does.
  EXPECT_NEAR(math::wrap_pi(t.torso.q.yaw() - yaw), 0.9, 0.15);
  drive_wheels(*pitch, 0, {});
  run(*pitch, 1);
  EXPECT_LT(norm(t.v_world_mps), 0.02);
  EXPECT_EQ(pitch->trouble(), 0u);
}

TEST(WheeledRobot, TakesTheBallAndCarriesIt) {
  const auto pitch = pitch_with({}, {pioneer_body({.x_m = -1})});
  pitch->place_ball({-1 + 0.18 + kKidBall.radius_m + 0.015, 0, 0});
  grip(*pitch, 0, kPioneer.opening_m);
  run(*pitch, 0.3);
  EXPECT_NEAR(between_paddles_m(pitch->sensors(0)), kPioneer.opening_m, 0.005);
  grip(*pitch, 0, 0);
  run(*pitch, 1.5);
  EXPECT_NEAR(between_paddles_m(pitch->sensors(0)), 2 * kKidBall.radius_m, 0.02) << "the ball is between them";
  // Backwards and round: an unheld ball would stay.
  drive_wheels(*pitch, 0, {.forward_mps = -0.3});
  run(*pitch, 2);
  drive_wheels(*pitch, 0, {.turn_radps = 0.8});
  run(*pitch, 1.5);
  const BodyTruth& t = pitch->truth(0);
  const math::Vec3 ball = t.torso.inverse().of(pitch->ball().p_m);
  EXPECT_NEAR(ball.x, 0.265, 0.06);
  EXPECT_NEAR(ball.y, 0, 0.03);
  grip(*pitch, 0, kPioneer.opening_m);
  run(*pitch, 1.5);
  drive_wheels(*pitch, 0, {.forward_mps = -0.3});
  run(*pitch, 2);
  EXPECT_GT(norm(t.torso.inverse().of(pitch->ball().p_m)), 0.5) << "let go";
  EXPECT_EQ(pitch->ball().touched_by, 0);
}

TEST(WheeledRobot, IsNoFasterThanItsMotors) {
  const auto pitch = pitch_with({}, {pioneer_body({.x_m = -4})});
  drive_wheels(*pitch, 0, {.forward_mps = 5});
  run(*pitch, 3);
  EXPECT_GT(pitch->truth(0).v_world_mps.x, 1.4);
  EXPECT_LT(pitch->truth(0).v_world_mps.x, 1.7);
}

}  // namespace
}  // namespace sinew::plant::wheeled_test
