// The modules that move a humanoid, each alone: what becomes of requests, and where the head looks.
#include <gtest/gtest.h>

#include <algorithm>

#include "apps/toml/body_reader.hpp"
#include "apps/toml/motion_reader.hpp"
#include "robots/kid/devices.hpp"
#include "robots/kid/gaze.hpp"
#include "robots/kid/kick_plan.hpp"
#include "robots/kid/mover.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::kid::motion_modules_test {
namespace {

using namespace std::chrono_literals;
using msg::GaitMode;
using msg::RequestProgress;
using msg::RequestRefusal;

constexpr auto kStep = 8ms;

robots::RobotBody op3() {
  const std::string path = test::source_dir() + "/robots/kid/op3";
  auto body = app::load_body(path + ".toml").body;
  auto book = app::load_motions(path + "_motion.toml", body).book;
  return {std::make_shared<const kinematics::Body>(std::move(body)),
          std::make_shared<const motion::MotionBook>(std::move(book))};
}

/// A mover of a body that does at once what it is told, with half of the weight on each sole.
struct MoverRig {
  robots::RobotBody robot = op3();
  kinematics::Limbs limbs = kinematics::Limbs::of(*robot.body);
  Mover mover{robot};
  rt::ModuleRig rig{mover};
  std::array<msg::JointState, kinematics::kLimbs> joints{};
  msg::SafetyState safety;
  math::Vec3 accel_mps2{0, 0, 9.81};
  msg::Time now{0};

  MoverRig() {
    safety.permitted = 1;
    for (std::size_t i = 0; i < kinematics::kLimbs; ++i) joints[i].count = plant::kKidLimbJoints[i];
  }
  msg::GaitState step() {
    now = now + kStep;
    msg::ImuSample imu;
    imu.stamp = now;
    imu.accel_mps2 = accel_mps2.to<msg::Vec3>();
    rig.put("imu", imu);
    msg::SolePressure soles;
    soles.stamp = now;
    for (double& n : soles.force_n) n = robot.body->mass_kg() * 9.81 / msg::kSoleCells;
    rig.put("soles", soles);
    safety.stamp = now;
    rig.put("safety", safety);
    for (std::size_t i = 0; i < kinematics::kLimbs; ++i) {
      joints[i].stamp = now;
      rig.put(std::string(to_string(kinematics::Limb(i))) + "_joints", joints[i]);
    }
    EXPECT_EQ(rig.step(now, kStep), rt::StepStatus::ok);
    for (std::size_t i = 0; i < kinematics::kLimbs; ++i)
      if (const auto* out = rig.get<msg::ActuatorCommand>(to_string(kinematics::Limb(i))); out && out->armed)
        for (std::size_t c = 0; c < limbs.joints[i].size(); ++c) joints[i].position_rad[c] = out->value[c];
    return *rig.get<msg::GaitState>("gait");
  }
  msg::GaitState run(double seconds) {
    msg::GaitState gait;
    for (double t = 0; t < seconds; t += msg::seconds(kStep)) gait = step();
    return gait;
  }
  void ask(std::uint32_t id, msg::BallMotion motion, bool in_walk = false) {
    msg::KickRequest r;
    r.stamp = now;
    r.id = id;
    r.motion = motion;
    r.foot = msg::Foot::right;
    r.in_walk = in_walk ? 1 : 0;
    rig.put("kick", r);
  }
  /// Modes that it was in until the request ended, in their order.
  std::vector<GaitMode> until_it_ends(double most_s) {
    std::vector<GaitMode> modes;
    for (double t = 0; t < most_s; t += msg::seconds(kStep)) {
      const msg::GaitState gait = step();
      if (modes.empty() || modes.back() != gait.mode) modes.push_back(gait.mode);
      if (gait.progress != RequestProgress::waits && gait.progress != RequestProgress::moves) break;
    }
    return modes;
  }
};

TEST(KidMover, KicksFromAStandAndStandsAgain) {
  MoverRig m;
  m.run(1);
  m.ask(7, msg::BallMotion::kick_forward);
  msg::GaitState gait = m.step();
  EXPECT_EQ(gait.request, 7u);
  EXPECT_EQ(gait.progress, RequestProgress::moves);
  EXPECT_EQ(gait.mode, GaitMode::kick);
  EXPECT_EQ(m.until_it_ends(5), (std::vector{GaitMode::kick, GaitMode::stand}));
  gait = m.step();
  EXPECT_EQ(gait.progress, RequestProgress::done);
  EXPECT_EQ(gait.refusal, RequestRefusal::none);
}

TEST(KidMover, ARequestBesideAnotherOneOrWithoutAMeaningIsRefusedAndTheFirstGoesOn) {
  MoverRig m;
  m.run(1);
  m.ask(1, msg::BallMotion::stop);
  m.ask(2, msg::BallMotion::kick_forward);
  msg::GaitState gait = m.step();
  EXPECT_EQ(gait.request, 1u);
  EXPECT_EQ(gait.mode, GaitMode::stop);
  EXPECT_EQ(gait.refused, 2u);
  EXPECT_EQ(gait.refusal, RequestRefusal::busy);
  EXPECT_EQ(m.until_it_ends(10), (std::vector{GaitMode::stop, GaitMode::stand}));
  m.ask(3, msg::BallMotion{9});
  gait = m.step();
  EXPECT_EQ(gait.request, 1u);
  EXPECT_EQ(gait.progress, RequestProgress::done);
  EXPECT_EQ(gait.refused, 3u);
  EXPECT_EQ(gait.refusal, RequestRefusal::unknown);
}

TEST(KidMover, AKickWithinAStepMakesAStandingRobotMarchUntilItsFootKicks) {
  MoverRig m;
  m.run(1);
  m.ask(4, msg::BallMotion::kick_outward, true);
  const std::vector<GaitMode> modes = m.until_it_ends(5);
  ASSERT_GE(modes.size(), 3u);
  EXPECT_EQ(std::ranges::count(modes, GaitMode::kick), 1);
  EXPECT_EQ(modes.back(), GaitMode::walk);
  EXPECT_EQ(m.run(4).mode, GaitMode::stand);
  EXPECT_EQ(m.step().progress, RequestProgress::done);
}

TEST(KidMover, AKickFromAStandStopsTheWalkFirstAndItWalksOnAfterwards) {
  MoverRig m;
  m.run(1);
  const auto walk = [&] {
    msg::VelocityCommand v;
    v.stamp = m.now;
    v.linear_mps.x = 0.1;
    m.rig.put("velocity", v);
  };
  for (int i = 0; i < 200; ++i) walk(), m.step();
  ASSERT_EQ(m.step().mode, GaitMode::walk);
  m.ask(5, msg::BallMotion::kick_forward);
  std::vector<GaitMode> modes;
  for (int i = 0; i < 1000; ++i) {
    walk();
    const GaitMode mode = m.step().mode;
    if (modes.empty() || modes.back() != mode) modes.push_back(mode);
  }
  EXPECT_EQ(modes, (std::vector{GaitMode::walk, GaitMode::stand, GaitMode::kick, GaitMode::stand, GaitMode::walk}));
}

TEST(KidMover, WhoMayNotMoveRefusesAndAFailsafeBreaksOffWhatWaits) {
  MoverRig m;
  m.safety.permitted = 0;
  m.ask(1, msg::BallMotion::kick_forward);
  msg::GaitState gait = m.step();
  EXPECT_EQ(gait.refused, 1u);
  EXPECT_EQ(gait.refusal, RequestRefusal::not_on_feet);
  m.safety.permitted = 1;
  m.run(0.1);
  m.ask(2, msg::BallMotion::kick_forward);
  EXPECT_EQ(m.step().progress, RequestProgress::waits) << "it does not stand still yet";
  m.safety.action = msg::FailsafeAction::land;
  gait = m.step();
  EXPECT_EQ(gait.request, 2u);
  EXPECT_EQ(gait.progress, RequestProgress::broken_off);
  m.ask(3, msg::BallMotion::kick_forward);
  gait = m.step();
  EXPECT_EQ(gait.refused, 3u);
  EXPECT_EQ(gait.refusal, RequestRefusal::failsafe);
}

TEST(KidMover, AFallBreaksOffAKick) {
  MoverRig m;
  m.run(1);
  m.ask(6, msg::BallMotion::kick_forward);
  m.run(0.5);
  m.accel_mps2 = {-9.81, 0, 0};
  const msg::GaitState gait = m.run(3);
  EXPECT_NE(gait.mode, GaitMode::kick);
  EXPECT_EQ(gait.progress, RequestProgress::broken_off);
  EXPECT_EQ(gait.falls, 1u);
}

TEST(KidMover, ABodyThatRestsOnItsOwnLimbsStretchesThem) {
  MoverRig m;
  m.run(1);
  m.accel_mps2 = {-9.81, 0, 0};
  msg::GaitState gait;
  for (int i = 0; i < 500 && gait.mode != GaitMode::fall; ++i) gait = m.step();
  ASSERT_EQ(gait.mode, GaitMode::fall);
  m.accel_mps2 = {-6.5, 0, 7.3};  // 42 degrees: neither upright nor lying
  const msg::Time fell = m.now;
  for (int i = 0; i < 500 && gait.mode != GaitMode::rise; ++i) gait = m.step();
  EXPECT_EQ(gait.mode, GaitMode::rise);
  EXPECT_GT(m.now - fell, 1s) << "it may still be on its way down";
  EXPECT_EQ(gait.falls, 1u);
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

TEST(KidKickPlan, AsksOnceWhenItIsTimeAndEndsByWhatTheGaitSays) {
  KickPlan plan;
  rt::ModuleRig rig(plan);
  rig.set("at_s", 0.5);
  rig.set("after_s", 0.0);
  msg::GaitState gait;
  gait.mode = GaitMode::stand;
  msg::Time now{0};
  int asked = 0;
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      now = now + 50ms;
      gait.stamp = now;
      rig.put("gait", gait);
      EXPECT_EQ(rig.step(now, 50ms), rt::StepStatus::ok);
      asked += static_cast<int>(rig.all<msg::KickRequest>("kick").size());
    }
    return rig.get<msg::MissionState>("mission")->phase;
  };
  EXPECT_EQ(run(40), msg::MissionPhase::hold);
  EXPECT_EQ(asked, 1);
  gait.request = 1;
  gait.progress = RequestProgress::moves;
  EXPECT_EQ(run(4), msg::MissionPhase::hold);
  gait.progress = RequestProgress::done;
  EXPECT_EQ(run(4), msg::MissionPhase::done);
  rig.reset();
  gait = {};
  gait.mode = GaitMode::stand;
  run(40);
  gait.refused = 1;
  EXPECT_EQ(run(2), msg::MissionPhase::abort);
  EXPECT_EQ(run(200), msg::MissionPhase::done) << "after the time to rise";
}

}  // namespace
}  // namespace sinew::kid::motion_modules_test
