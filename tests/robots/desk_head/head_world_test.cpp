// The desk head's world without rendering: is it physics, and is it repeatable?
#include "robots/desk_head/world/head_world.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "math/hash.hpp"
#include "robots/desk_head/world/desk_motion.hpp"
#include "sim_hil/worlds/joint_servo.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant::head_world_test {
namespace {

using math::Quat;
using math::Vec3;
using Command = std::array<double, kHeadJoints>;

HeadOptions ideal() { return {.seed = 1, .rock_deg = 0, .ball_speed = 0, .sensor_errors = false, .pillar = false}; }

template <class EachStep>
void run(HeadWorld& world, double seconds, std::span<const double> command, EachStep&& each) {
  const auto steps = static_cast<int>(seconds * 1e9 / static_cast<double>(kStepNs));
  for (int i = 0; i < steps; ++i) each(world.step(command));
}
void run(HeadWorld& world, double seconds, std::span<const double> command) {
  run(world, seconds, command, [](const Due&) {});
}

// ---- the ground it stands on

TEST(Rocking, ItsRatesAndAccelerationsAreThoseOfItsAttitude) {
  const Rocking rocking(0.17, 0.1, 5);
  constexpr double h = 1e-4;
  for (double t = 0; t < 20; t += 0.37) {
    const Rocking::State before = rocking.at(t - h), now = rocking.at(t), after = rocking.at(t + h);
    const Vec3 rate = (before.q_world_base.conjugate() * after.q_world_base).log() / (2 * h);
    EXPECT_LT(norm(rate - now.motion.w_radps), 1e-5) << t;
    const Vec3 change = (after.motion.w_radps - before.motion.w_radps) / (2 * h);
    EXPECT_LT(norm(change - now.motion.dw_radps2), 1e-5) << t;
    const Vec3 up = now.q_world_base.rotate(now.motion.a_mps2);
    EXPECT_NEAR(up.z, kGravity, 1e-9);
  }
}

TEST(Rocking, TiltsByUpToWhatItWasToldAndUsesMostOfIt) {
  double most = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Rocking rocking(0.17, 0.1, seed);
    for (double t = 0; t < 60; t += 0.05) {
      const math::YawPitchRoll a = rocking.at(t).q_world_base.yaw_pitch_roll();
      EXPECT_LE(std::fabs(a.roll), 0.17);
      EXPECT_LE(std::fabs(a.pitch), 0.17);
      EXPECT_LE(std::fabs(a.yaw), 0.1);
      most = std::max({most, std::fabs(a.roll), std::fabs(a.pitch)});
    }
  }
  EXPECT_GT(most, 0.15);
}

TEST(BallPath, IsSmoothAndStaysWithinTheHeadsReach) {
  double fastest = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const BallPath path(1, seed);
    Vec3 before = path.at(0);
    for (int i = 1; i < 60'000; ++i) {
      const Vec3 p = path.at(1e-3 * i);
      fastest = std::max(fastest, norm(p - before) * 1000);
      before = p;
      EXPECT_GT(p.x, 1.25);
      EXPECT_LT(std::fabs(std::atan2(p.y, p.x)), 0.75);
      EXPECT_GT(p.z, 0.7);
    }
  }
  EXPECT_GT(fastest, 1.2);
  EXPECT_LT(fastest, 4.0);
}

// ---- joints

TEST(HeadWorld, ItsServosReachAPositionAndHoldItAgainstGravity) {
  HeadWorld world(ideal());
  const Command wanted{0.7, -0.4};
  run(world, 1.0, wanted);
  for (std::size_t i = 0; i < kHeadJoints; ++i) {
    EXPECT_NEAR(world.motion(i).position_rad, wanted[i], 0.01) << i;
    EXPECT_NEAR(world.motion(i).velocity_radps, 0, 0.01) << i;
  }
  const Vec3 ahead = world.q_world_head().rotate({1, 0, 0});
  EXPECT_NEAR(std::atan2(ahead.y, ahead.x), 0.7, 0.01) << "positive pan looks left";
  EXPECT_NEAR(ahead.z, std::sin(0.4), 0.01) << "negative tilt looks up";
}

TEST(HeadWorld, NeitherSpeedNorEffortNorStopsAreExceeded) {
  HeadWorld world(ideal());
  double fastest = 0, strongest = 0, farthest = 0;
  for (const Command& wanted : {Command{9, 9}, Command{-9, -9}, Command{9, -9}}) {
    run(world, 1.5, wanted, [&](const Due&) {
      for (std::size_t i = 0; i < kHeadJoints; ++i) {
        const JointMotion m = world.motion(i);
        fastest = std::max(fastest, std::fabs(m.velocity_radps));
        strongest = std::max(strongest, std::fabs(m.effort_nm));
        const JointLimits l = world.limits(i);
        farthest = std::max({farthest, m.position_rad - l.most_rad, l.least_rad - m.position_rad});
      }
    });
  }
  EXPECT_GT(fastest, 4.5);
  EXPECT_LT(fastest, 6.0);
  EXPECT_LE(strongest, 1.5);
  EXPECT_LT(farthest, 0.1) << "the stops give way a little, under the servo's full effort";
}

TEST(HeadWorld, WithoutACommandTheGearsHoldWhatGravityPulls) {
  HeadWorld world(ideal());
  const Command wanted{0.3, 0.2};
  run(world, 1.0, wanted);
  run(world, 2.0, {});
  EXPECT_NEAR(world.motion(1).position_rad, 0.2, 0.05);
  EXPECT_EQ(world.motion(1).effort_nm, 0);
  EXPECT_TRUE(world.still());
}

TEST(HeadWorld, AnEffortTurnsAJointAsItsInertiaSays) {
  HeadWorld world(ideal());
  run(world, 0.5, Command{0, 0});
  const double effort = 0.2;
  world.drive(0, {.mode = DriveMode::effort, .effort_nm = effort});
  run(world, 0.01, {});
  const ServoParams servo;
  // The head lies in the yoke as tilted by 0: both turn about z, the head's mass 8 mm off the axis.
  const double inertia = servo.armature_kgm2 + kYoke.inertia_kgm2.z + kHead.inertia_kgm2.z + 0.25 * 0.008 * 0.008;
  const double rubs = servo.coulomb_nm;  // the most; it builds up with the speed
  EXPECT_LT(world.motion(0).velocity_radps, 0.01 * effort / inertia);
  EXPECT_GT(world.motion(0).velocity_radps, 0.01 * (effort - 1.5 * rubs) / inertia);
}

TEST(HeadWorld, AJointThatIsTakenOverObeysNoCommandUntilItIsReleased) {
  HeadWorld world(ideal());
  run(world, 1.0, Command{0, 0});
  world.drive(0, {.mode = DriveMode::position, .position_rad = 0.5});
  run(world, 1.0, Command{-0.5, 0.25});
  EXPECT_NEAR(world.motion(0).position_rad, 0.5, 0.01);
  EXPECT_NEAR(world.motion(1).position_rad, 0.25, 0.01);
  world.drive(0, {.mode = DriveMode::velocity, .velocity_radps = -1});
  run(world, 0.2, {});
  EXPECT_NEAR(world.motion(0).velocity_radps, -1, 0.15);
  world.drive(0, {.mode = DriveMode::impedance, .position_rad = 0.1, .kp_nm_per_rad = 5, .kd_nms_per_rad = 0.1});
  run(world, 1.0, {});
  EXPECT_NEAR(world.motion(0).position_rad, 0.1, 0.01);
  world.release(0);
  run(world, 1.0, Command{-0.5, 0.25});
  EXPECT_NEAR(world.motion(0).position_rad, -0.5, 0.01);
}

TEST(HeadWorld, AMotorThatWorksGetsWarm) {
  HeadWorld world(ideal());
  world.drive(0, {.mode = DriveMode::position, .position_rad = 9});  // against its stop
  run(world, 10, {});
  EXPECT_GT(world.motion(0).temperature_c, 30);
  EXPECT_NEAR(world.motion(1).temperature_c, 25, 0.1);
}

// ---- sensors

TEST(HeadWorld, TheImuFeelsGravityAndTheTurningOfBaseAndJoints) {
  HeadOptions o = ideal();
  o.rock_deg = 10;
  HeadWorld world(o);
  Quat last = world.q_world_head();
  int samples = 0;
  run(world, 5, Command{0.4, 0.3}, [&](const Due& due) {
    if (!due.imu) return;
    const Quat now = world.q_world_head();
    const Vec3 rate = (last.conjugate() * now).log() * 1000;
    last = now;
    ++samples;
    if (samples < 5) return;
    EXPECT_LT(norm(rate - Vec3(due.imu_sample.gyro_radps)), 0.02);
    EXPECT_NEAR(norm(Vec3(due.imu_sample.accel_mps2)), kGravity, samples < 1000 ? 30 : 0.5);
    EXPECT_EQ(due.imu_sample.stamp.ns, world.now().ns - 500'000);
  });
  EXPECT_EQ(samples, 5000);
  const Vec3 up = world.q_world_head().rotate(world.imu_motion().a_mps2);
  EXPECT_NEAR(up.z, kGravity, 0.3);
}

TEST(HeadWorld, JointsReportWhatTheyDoTwiceAMillisecondsPairWithTheirModes) {
  HeadOptions o = ideal();
  o.sensor_errors = true;
  HeadWorld world(o);
  int samples = 0;
  run(world, 0.2, {}, [&](const Due& due) { samples += due.joints; });
  EXPECT_EQ(samples, 100);
  run(world, 1.0, Command{0.25, 0.1}, [&](const Due& due) {
    if (!due.joints) return;
    const msg::JointState& s = due.joints_samples[0];
    EXPECT_EQ(s.count, 2u);
    EXPECT_EQ(s.ready, 3u);
    EXPECT_EQ(s.mode[1], msg::JointMode::enabled);
    EXPECT_EQ(s.measured[1], world.now());
    EXPECT_NEAR(s.position_rad[0], world.motion(0).position_rad, 2e-4) << "half a step of the encoder";
    EXPECT_NEAR(s.velocity_radps[1], world.motion(1).velocity_radps, 0.06);
  });
  run(world, 0.002, {}, [&](const Due& due) {
    if (due.joints) {
      EXPECT_EQ(due.joints_samples[0].mode[0], msg::JointMode::disabled);
      EXPECT_EQ(due.joints_samples[0].ready, 0u);
    }
  });
}

TEST(HeadWorld, TheBallIsInTheMiddleOfThePictureWhereTheHeadLooks) {
  HeadWorld world(ideal());
  const Vec3 neck = kPivot + kPBaseYoke + kPYokeHead, d = world.ball_m() - neck;
  run(world, 1.0, Command{std::atan2(d.y, d.x), std::atan2(-d.z, std::hypot(d.x, d.y))});
  const CameraPose eye = world.camera_pose();
  const Vec3 seen = Quat(eye.q_world_optical).conjugate().rotate(world.ball_m() - Vec3(eye.p_world_m));
  EXPECT_GT(seen.z, 1.0);
  EXPECT_NEAR(seen.x / seen.z, 0, 0.02);
  EXPECT_NEAR(seen.y / seen.z, 0, 0.02);
}

TEST(HeadWorld, ThePillarHidesTheBallNowAndThen) {
  int hidden = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    HeadOptions o;
    o.seed = seed;
    HeadWorld world(o);
    run(world, 30, {}, [&](const Due& due) {
      if (due.imu) hidden += world.ball_hidden(), ++all;
    });
  }
  EXPECT_GT(hidden, all / 100);
  EXPECT_LT(hidden, all / 2);
}

// ---- repeatable

std::uint64_t hash_of(std::uint64_t seed) {
  HeadOptions o;
  o.seed = seed;
  HeadWorld world(o);
  math::Hash64 hash;
  int i = 0;
  run(world, 2, {}, [&](const Due&) {});
  for (; i < 8000; ++i) {
    const double a = 1e-4 * i;
    const Command command{0.5 - a, 0.3 * a};
    const Due& due = world.step(command);
    if (due.imu) hash.add(&due.imu_sample, sizeof due.imu_sample);
    if (due.joints) hash.add(&due.joints_samples[0], sizeof due.joints_samples[0]);
    if (due.cameras == 0) continue;
    const Scene scene = world.scene(0);
    hash.add(&scene.camera.p_world_m, sizeof scene.camera.p_world_m);
    hash.add(&scene.camera.q_world_optical, sizeof scene.camera.q_world_optical);
    constexpr std::size_t kBodies = 6;  // that the room has, and one more
    hash.add(scene.body.data(), kBodies * sizeof scene.body[0]);
  }
  return hash.value();
}

TEST(HeadWorld, SameSeedAndCommandsGiveTheSameBytes) {
  EXPECT_EQ(hash_of(7), hash_of(7));
  EXPECT_NE(hash_of(7), hash_of(8));
  // Of gcc 12 and clang 14, with and without sanitizers.
  EXPECT_EQ(hash_of(7), 14786457069346919113u);
}

}  // namespace
}  // namespace sinew::plant::head_world_test
