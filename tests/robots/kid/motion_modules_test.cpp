// The modules that move a humanoid, each alone: where the head looks.
#include <gtest/gtest.h>

#include <algorithm>

#include "apps/toml/body_reader.hpp"
#include "apps/toml/motion_reader.hpp"
#include "robots/kid/devices.hpp"
#include "robots/kid/gaze.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::kid::motion_modules_test {
namespace {

using namespace std::chrono_literals;
using msg::GaitMode;

constexpr auto kStep = 8ms;

robots::RobotBody op3() {
  const std::string path = test::source_dir() + "/robots/kid/op3";
  auto body = app::load_body(path + ".toml").body;
  auto book = app::load_motions(path + "_motion.toml", body).book;
  return {std::make_shared<const kinematics::Body>(std::move(body)),
          std::make_shared<const motion::MotionBook>(std::move(book))};
}

/// The head of a body that stands upright, 0.3 m over the ground, and does at once what it is told.
struct GazeRig {
  robots::RobotBody robot = op3();
  Gaze gaze{robot};
  rt::ModuleRig rig{gaze};
  msg::GaitState gait;
  msg::ActuatorCommand motions;
  msg::JointState joints;
  msg::Time now{0};

  GazeRig() {
    gait.mode = GaitMode::walk;
    gait.height_m = 0.3;
    motions.count = joints.count = plant::kKidHeadJoints;
    motions.armed = 1;
    motions.value[0] = 0.1, motions.value[1] = 0.2;
  }
  const msg::ActuatorCommand* run(int steps) {
    const msg::ActuatorCommand* out = nullptr;
    for (int i = 0; i < steps; ++i) {
      now = now + kStep;
      gait.stamp = motions.stamp = joints.stamp = now;
      rig.put("gait", gait);
      rig.put("motions", motions);
      rig.put("joints", joints);
      EXPECT_EQ(rig.step(now, kStep), rt::StepStatus::ok);
      out = rig.get<msg::ActuatorCommand>("head");
      for (std::size_t c = 0; c < plant::kKidHeadJoints; ++c) joints.position_rad[c] = out->value[c];
    }
    return out;
  }
  void look(msg::GazeAim aim, const msg::Vec3& to, msg::GazeFrame frame = msg::GazeFrame::odometry) {
    msg::GazeCommand c;
    c.stamp = now;
    c.aim = aim;
    c.to = to;
    c.frame = frame;
    rig.put("command", c);
  }
};

TEST(KidGaze, WithoutACommandTheMoversAnglesGoThrough) {
  GazeRig g;
  EXPECT_EQ(g.run(1)->value[0], 0.1);
  EXPECT_EQ(g.run(1)->value[1], 0.2);
  EXPECT_EQ(g.rig.get<msg::GazeState>("state")->aim, msg::GazeAim::rest);
}

TEST(KidGaze, LooksAtAPointOfTheOdometryOrOfTheRobot) {
  GazeRig g;
  g.gait.x_m = 1, g.gait.heading_rad = 0.5 * math::kPi;
  g.gait.q_world_torso = math::Quat::from_axis_angle({0, 0, 1}, g.gait.heading_rad).to<msg::Quat>();
  g.look(msg::GazeAim::point, {0, 1, 0.07});  // ahead of it and to its left
  EXPECT_NEAR(g.run(200)->value[0], 0.25 * math::kPi, 0.03);
  EXPECT_LT(g.rig.get<msg::GazeState>("state")->error_rad, 0.01);
  g.look(msg::GazeAim::point, {1, -1, 0.07}, msg::GazeFrame::robot);
  EXPECT_NEAR(g.run(200)->value[0], -0.25 * math::kPi, 0.03);
  EXPECT_GT(g.run(1)->value[1], 0.1) << "down";
  g.look(msg::GazeAim::point, {-1, 0.2, 0.07}, msg::GazeFrame::robot);
  g.run(200);
  EXPECT_EQ(g.rig.get<msg::GazeState>("state")->limited, 1u) << "behind it";
}

TEST(KidGaze, ACommandThatMakesNoSenseIsTakenForRest) {
  GazeRig g;
  g.look(msg::GazeAim::point, {1e9, 0, 0});
  EXPECT_EQ(g.run(1)->value[0], 0.1);
  g.look(msg::GazeAim{9}, {1, 0, 0});
  EXPECT_EQ(g.run(1)->value[0], 0.1);
  EXPECT_EQ(g.rig.get<msg::GazeState>("state")->aim, msg::GazeAim::rest);
}

TEST(KidGaze, AheadIsTheHorizonHoweverTheTorsoLeans) {
  GazeRig g;
  g.gait.q_world_torso = math::Quat::from_axis_angle({0, 1, 0}, 0.15).to<msg::Quat>();
  g.look(msg::GazeAim::ahead, {});
  EXPECT_NEAR(g.run(200)->value[1], -0.15, 1e-6);
  EXPECT_NEAR(g.run(1)->value[0], 0, 1e-6);
}

TEST(KidGaze, WhileItIsNotOnItsFeetTheMoverHasTheHead) {
  GazeRig g;
  g.look(msg::GazeAim::direction, {0, 1, 0});
  EXPECT_NEAR(g.run(200)->value[0], 0.5 * math::kPi, 1e-6);
  g.gait.mode = GaitMode::rise;
  EXPECT_EQ(g.run(1)->value[0], 0.1);
  g.gait.mode = GaitMode::fall;
  g.motions.armed = 0;
  EXPECT_EQ(g.run(1)->armed, 0u);
}

}  // namespace
}  // namespace sinew::kid::motion_modules_test
