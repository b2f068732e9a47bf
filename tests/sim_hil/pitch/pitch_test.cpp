// The pitch: bodies stand, fall and are pushed; a ball rolls and bounces off posts; the same bytes everywhere.
#include "sim_hil/pitch/pitch.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "math/hash.hpp"
#include "rig.hpp"

namespace sinew::plant {
namespace {

using math::Vec3;

class KidOnThePitch : public ::testing::TestWithParam<const char*> {};

PitchBody standing(const std::string& name) {
  PitchBody kid{.body = kid_body(name)};
  kid.start.joints_rad = crouched(kid.body, 0.02);
  // XM430's factory gain does not hold NAO's longer legs.
  if (name == "nao") kid.gain_per_rad = 20;
  return kid;
}

TEST_P(KidOnThePitch, StandsOnItsServosWithAllErrors) {
  const PitchBody kid = standing(GetParam());
  const auto pitch = pitch_with({}, {kid});
  pitch->command(0, kid.start.joints_rad);
  run(*pitch, 5);
  const BodyTruth& t = pitch->truth(0);
  EXPECT_FALSE(t.fallen);
  EXPECT_FALSE(t.body_down);
  EXPECT_LT(t.tilt_rad, 0.15);
  double feet_n = 0, cells_n = 0;
  for (int i = 0; i < 250; ++i) {
    pitch->step();
    feet_n += (t.foot_n[0] + t.foot_n[1]) / 250;
    for (const auto& foot : pitch->sensors(0).cell_n)
      for (const double cell : foot) cells_n += cell / 250;
  }
  const double weight_n = 9.81 * pitch->body(0).mass_kg();
  EXPECT_NEAR(feet_n, weight_n, 0.02 * weight_n);
  EXPECT_NEAR(cells_n, weight_n, 0.1 * weight_n) << "cells are up to 10 % off";
  EXPECT_LT(math::hypot(t.torso.p_m.x, t.torso.p_m.y), 0.1);
  EXPECT_EQ(pitch->trouble(), 0u);
}

TEST_P(KidOnThePitch, WithoutTorqueGoesDown) {
  const auto pitch = pitch_with({}, {standing(GetParam())});
  const double stood_m = pitch->truth(0).torso.p_m.z;
  run(*pitch, 3);
  EXPECT_LT(pitch->truth(0).torso.p_m.z, 0.65 * stood_m);
  EXPECT_GT(pitch->truth(0).torso.p_m.z, 0);
  EXPECT_EQ(pitch->trouble(), 0u);
}

TEST_P(KidOnThePitch, LiesAsItWasPut) {
  using Lie = PitchPlace::Lie;
  for (const Lie lie : {Lie::on_front, Lie::on_back, Lie::on_left, Lie::on_right}) {
    PitchBody kid = standing(GetParam());
    kid.start.lie = lie;
    kid.start.x_m = 2, kid.start.heading_rad = 1;
    const auto pitch = pitch_with({}, {kid});
    const BodyTruth& t = pitch->truth(0);
    const Vec3 along = t.torso.q.rotate({1, 0, 0}), left = t.torso.q.rotate({0, 1, 0});
    EXPECT_EQ(along.z < -0.99, lie == Lie::on_front);
    EXPECT_EQ(along.z > 0.99, lie == Lie::on_back);
    EXPECT_EQ(left.z < -0.99, lie == Lie::on_left);
    EXPECT_EQ(left.z > 0.99, lie == Lie::on_right);
    EXPECT_TRUE(t.fallen);
    pitch->command(0, kid.start.joints_rad);
    run(*pitch, 1);
    EXPECT_TRUE(t.body_down);
    EXPECT_LT(t.torso.p_m.z, 0.25);
    EXPECT_LT(math::hypot(t.torso.p_m.x - 2, t.torso.p_m.y), 0.3);
  }
}

INSTANTIATE_TEST_SUITE_P(Bodies, KidOnThePitch, ::testing::Values("op3", "nao"));

TEST(PitchPushes, GiveTheBodyTheirImpulse) {
  PitchBody kid = standing("op3");
  kid.errors = BodyErrors::none();
  PitchOptions options;
  options.ground = GroundErrors::none();
  const auto pitch = pitch_with(options, {kid});
  pitch->command(0, kid.start.joints_rad);
  run(*pitch, 1);
  // In the air nothing holds it: the whole body gets the impulse.
  kid.start.joints_rad.assign(kid.body.joints(), 0);
  pitch->place(0, kid.start);
  double before_n = 0;
  pitch->push(0, {0, 0, 8}, 100'000'000);  // upwards: it leaves the ground
  for (int i = 0; i < 60; ++i) {
    pitch->step();
    before_n = pitch->truth(0).foot_n[0] + pitch->truth(0).foot_n[1];
  }
  EXPECT_EQ(before_n, 0) << "it flies";
  EXPECT_GT(pitch->truth(0).v_world_mps.z, 0.5);
  const double pushed = pitch->truth(0).v_world_mps.z;
  pitch->push(0, {1.5, -0.9, 0}, 50'000'000);
  run(*pitch, 0.05);
  // The torso moves more than the centre of mass, but all of the momentum is in the links.
  EXPECT_NEAR(pitch->truth(0).v_world_mps.z, pushed - 0.5, 0.35);
  EXPECT_GT(pitch->truth(0).v_world_mps.x, 1.5 / pitch->body(0).mass_kg() * 0.7);
  EXPECT_LT(pitch->truth(0).v_world_mps.y, -0.9 / pitch->body(0).mass_kg() * 0.7);
}

TEST(BallOnThePitch, RollsWithItsStatedDeceleration) {
  for (const double deceleration : {0.35, 0.8}) {
    PitchOptions options;
    options.ground.ball_deceleration_mps2 = deceleration;
    const auto pitch = pitch_with(options, {});
    pitch->place_ball({-3, 1, 0}, {1.2, -0.5, 0});
    run(*pitch, 1);
    const double speed = norm(pitch->ball().v_mps);
    EXPECT_NEAR(speed, 1.3 - deceleration, 0.01);
    EXPECT_NEAR(norm(pitch->ball().spin_radps) * options.ball.radius_m, speed, 0.01) << "it rolls";
    EXPECT_NEAR(pitch->ball().v_mps.x / pitch->ball().v_mps.y, 1.2 / -0.5, 0.01) << "straight on";
    run(*pitch, 4);
    const double way = 1.3 * 1.3 / (2 * deceleration);
    EXPECT_NEAR(math::hypot(pitch->ball().p_m.x + 3, pitch->ball().p_m.y - 1), way, 0.01);
    EXPECT_LT(norm(pitch->ball().v_mps), 1e-4) << "and then it lies still";
  }
}

TEST(BallOnThePitch, BouncesOffAPostAndStaysInTheNet) {
  const auto pitch = pitch_with({}, {});
  const double post = kKidField.goal_width_m / 2 + kKidField.post_radius_m;
  pitch->place_ball({3.9, post, 0}, {2, 0, 0});
  run(*pitch, 2);
  EXPECT_LT(pitch->ball().p_m.x, 4.4) << "the post is solid";
  pitch->place_ball({4, 0.3, 0}, {3, 0, 0});
  run(*pitch, 3);
  EXPECT_GT(pitch->ball().p_m.x, 4.5);
  EXPECT_LT(pitch->ball().p_m.x, 4.5 + kKidField.goal_depth_m) << "the net holds it";
}

TEST(BallOnThePitch, IsKickedByAFootAndSaysByWhom) {
  PitchBody kid = standing("op3"), other = kid;
  other.start.x_m = -2;
  const auto pitch = pitch_with({}, {other, kid});
  EXPECT_EQ(pitch->ball().touched_by, -1);
  pitch->command(1, kid.start.joints_rad);
  run(*pitch, 0.5);
  pitch->place_ball({0.16, -0.05, 0});
  auto swung = kid.start.joints_rad;
  swung[*kid.body.find_link("r_hip_pitch") - 1] -= 0.8;
  pitch->command(1, swung);
  run(*pitch, 0.5);
  EXPECT_GT(pitch->ball().v_mps.x, 0.05);
  EXPECT_EQ(pitch->ball().touched_by, 1);
}

TEST(PitchCreation, RefusesWhatCannotBeAndSaysWhy) {
  std::string why;
  PitchBody empty;
  EXPECT_FALSE(Pitch::create({}, {&empty, 1}, 1, &why));
  EXPECT_EQ(why, "robot 0: a body has 1 to 48 links");
  std::vector<PitchBody> two{standing("op3"), standing("op3")};
  EXPECT_FALSE(Pitch::create({}, two, 1, &why));
  EXPECT_EQ(why, "robot 1 starts where robot 0 does");
  two[1].start.x_m = 1;
  two[1].body.links[3].mass_kg = 0;
  EXPECT_FALSE(Pitch::create({}, two, 1, &why));
  EXPECT_EQ(why, "robot 1: link l_hip_yaw: needs a mass");
}

/// Three bodies and a ball: one falls onto another, one is pushed, the ball runs into them; a hash of it all.
std::uint64_t hash_of_a_scrum() {
  std::vector<PitchBody> bodies{standing("op3"), standing("nao"), standing("op3")};
  bodies[1].start.x_m = 0.25, bodies[1].start.y_m = 0.1, bodies[1].start.heading_rad = 3;
  bodies[2].start.x_m = -0.3, bodies[2].start.y_m = 0.2, bodies[2].start.lie = PitchPlace::Lie::on_front;
  const auto pitch = pitch_with({}, bodies, 7);
  pitch->place_ball({-1.2, 0.1, 0}, {1.5, 0, 0});
  std::uint64_t hash = math::fnv1a64("");
  const auto add = [&](const void* bytes, std::size_t n) {
    hash = math::fnv1a64({static_cast<const char*>(bytes), n}, hash);
  };
  bool touched = false, down = false;
  for (int step = 0; step < 2000; ++step) {
    if (step % 5 == 0)
      for (std::size_t i = 0; i < bodies.size(); ++i)
        if (i != 1 || step < 500) pitch->command(i, bodies[i].start.joints_rad);
    if (step == 500) pitch->command(1, std::vector<double>(bodies[1].body.joints(), math::kNan));
    if (step == 700) pitch->push(0, {2, -1, 0}, 100'000'000);
    pitch->step();
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const BodyTruth& t = pitch->truth(i);
      for (std::size_t l = 0; l < bodies[i].body.links.size(); ++l) add(&t.link[l], sizeof t.link[l]);
      const BodySensors& s = pitch->sensors(i);
      add(s.joint.data(), sizeof(JointReading) * s.joints);
      add(&s.gyro_radps, sizeof s.gyro_radps);
      add(&s.accel_mps2, sizeof s.accel_mps2);
      add(&s.cell_n, sizeof s.cell_n);
      down = down || t.body_down;
    }
    add(&pitch->ball().p_m, sizeof(Vec3));
    touched = touched || pitch->ball().touched_by >= 0;
  }
  EXPECT_TRUE(touched);
  EXPECT_TRUE(down);
  EXPECT_EQ(pitch->trouble(), 0u);
  return hash;
}

TEST(PitchSteps, HaveTheSameBytesWhereTheCLibraryUsesNoFma) {
  const std::uint64_t here = hash_of_a_scrum();
  if (std::getenv("SINEW_HASH_OF_A_SCRUM")) {
    std::printf("hash %016llx\n", static_cast<unsigned long long>(here));
    return;
  }
  char self[4096] = "";
  ASSERT_GT(readlink("/proc/self/exe", self, sizeof self - 1), 0);
  const std::string command =
      "SINEW_HASH_OF_A_SCRUM=1 GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512DQ,-AVX512BW,-AVX512CD,-AVX2,"
      "-AVX,-FMA,-FMA4 '" +
      std::string(self) + "' --gtest_filter=PitchSteps.HaveTheSame*";
  FILE* const other = popen(command.c_str(), "r");
  ASSERT_TRUE(other);
  char line[256];
  unsigned long long there = 0;
  bool told = false;
  while (std::fgets(line, sizeof line, other)) told = told || std::sscanf(line, "hash %llx", &there) == 1;
  EXPECT_EQ(pclose(other), 0);
  ASSERT_TRUE(told);
  EXPECT_EQ(here, there);
}

TEST(PitchSteps, AreTheSameForTheSameSeedAndOthersForAnother) {
  const PitchBody kid = standing("op3");
  const auto after = [&](std::uint64_t seed) {
    const auto pitch = pitch_with({}, {kid}, seed);
    pitch->command(0, kid.start.joints_rad);
    run(*pitch, 0.5);
    return std::pair(pitch->truth(0).torso.p_m, pitch->sensors(0).gyro_radps);
  };
  EXPECT_EQ(after(3), after(3));
  EXPECT_NE(after(3).first, after(4).first);
  EXPECT_NE(after(3).second, after(4).second);
}

}  // namespace
}  // namespace sinew::plant
