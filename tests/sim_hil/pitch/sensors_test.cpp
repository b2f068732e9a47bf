// What a robot on the pitch gets of its devices: late, in steps, with noise; and the table of these errors.
#include <algorithm>
#include <string>

#include "rig.hpp"
#include "sim_hil/pitch/robot_io.hpp"

namespace sinew::plant::pitch_sensors_test {
namespace {

using math::Vec3;

PitchBody kid_with(const BodyErrors& errors) {
  PitchBody kid{.body = kid_body("op3"), .start = {}, .errors = errors};
  kid.start.joints_rad = crouched(kid.body, 0.02);
  return kid;
}

TEST(PitchSensors, ComeWithTheirDelaysAndTheStampsOfWhenTheyWereMeasured) {
  BodyErrors errors = BodyErrors::none();
  errors.joint_delay_ms = 6, errors.imu_delay_ms = 10;
  const PitchBody kid = kid_with(errors);
  const std::size_t knee = *kid.body.find_link("l_knee") - 1;
  const auto pitch = pitch_with({}, {kid});
  pitch->command(0, kid.start.joints_rad);
  std::vector<double> knees;
  std::vector<Vec3> gyros;
  for (int i = 0; i < 200; ++i) {
    knees.push_back(pitch->truth(0).joint_rad[knee]);
    gyros.push_back(pitch->truth(0).gyro_radps);
    const BodySensors& s = pitch->sensors(0);
    const auto then = [&](std::int64_t stamp_ns) { return static_cast<std::size_t>(stamp_ns / kPitchStepNs); };
    if (i >= 5) {
      EXPECT_EQ(pitch->now_ns() - s.joints_stamp_ns, 6'000'000);
      EXPECT_EQ(pitch->now_ns() - s.imu_stamp_ns, 10'000'000);
    }
    EXPECT_EQ(s.joint[knee].position_rad, knees[then(s.joints_stamp_ns)]);
    EXPECT_LT(norm(s.gyro_radps - gyros[then(s.imu_stamp_ns)]), 1e-12);
    pitch->step();
  }
}

TEST(PitchSensors, CommandsReachTheServosAfterTheRobotsDelay) {
  const auto moved_after_ms = [](double delay_ms) {
    BodyErrors errors = BodyErrors::none();
    errors.command_delay_ms = delay_ms;
    const PitchBody kid = kid_with(errors);
    const std::size_t head = *kid.body.find_link("head_pan") - 1;
    const auto pitch = pitch_with({}, {kid});
    pitch->command(0, kid.start.joints_rad);
    run(*pitch, 1);
    EXPECT_EQ(pitch->command_delay_ns(0), static_cast<std::int64_t>(delay_ms * 1e6));
    const double before = pitch->truth(0).joint_rad[head];
    pitch->command(0, head, {DriveMode::position, 0.5});
    int steps = 0;
    for (; steps < 50 && math::fabs(pitch->truth(0).joint_rad[head] - before) < 1e-3; ++steps) pitch->step();
    return steps * kPitchStepNs / 1'000'000;
  };
  EXPECT_EQ(moved_after_ms(0), 2);
  EXPECT_EQ(moved_after_ms(20), 22);
  EXPECT_EQ(moved_after_ms(36), 38);
}

TEST(PitchSensors, TheSeedDrawsDelayFrictionAndMassesInTheirRanges) {
  double least_ms = 1e9, most_ms = 0, least = 9, most = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const RobotDraw draw({}, seed, 0);
    const double ms = static_cast<double>(draw.command_delay_ns) * 1e-6;
    least_ms = std::min(least_ms, ms), most_ms = std::max(most_ms, ms);
    least = std::min(least, draw.sole_friction), most = std::max(most, draw.sole_friction);
  }
  EXPECT_EQ(least_ms, 20);
  EXPECT_EQ(most_ms, 36);
  EXPECT_GE(least, 0.6);
  EXPECT_LT(least, 0.62);
  EXPECT_LE(most, 1);
  EXPECT_GT(most, 0.98);
  EXPECT_NE(RobotDraw({}, 1, 0).sole_friction, RobotDraw({}, 1, 1).sole_friction) << "each robot its own";
  EXPECT_EQ(RobotDraw({.sole_friction = 0.7}, 1, 0).gain, RobotDraw({}, 1, 0).gain) << "and each number its own";
  const PitchBody kid = kid_with({});
  const auto pitch = pitch_with({}, {kid});
  double off = 0;
  for (std::size_t i = 0; i < kid.body.links.size(); ++i)
    off = std::max(off, math::fabs(pitch->body(0).links[i].mass_kg / kid.body.links[i].mass_kg - 1));
  EXPECT_LE(off, 0.05 + 1e-12);
  EXPECT_GT(off, 0.03);
}

TEST(PitchSensors, HaveTheirNoiseAndOffsets) {
  const PitchBody kid = kid_with({});
  // Lying still: what the IMU says beyond gravity is its own.
  PitchBody lying = kid;
  lying.start.lie = PitchPlace::Lie::on_back;
  Vec3 bias2;
  constexpr int kSeeds = 8;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const auto pitch = pitch_with({.has_ball = false}, {lying}, seed);
    pitch->command(0, kid.start.joints_rad);
    run(*pitch, 1);
    Vec3 sum, sum2, accel;
    constexpr int kSamples = 250;
    for (int i = 0; i < kSamples; ++i) {
      pitch->step();
      const Vec3 g = pitch->sensors(0).gyro_radps;
      sum += g, accel += pitch->sensors(0).accel_mps2;
      for (int k = 0; k < 3; ++k) sum2[k] += g[k] * g[k];
    }
    const Vec3 mean = sum / kSamples;
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(math::sqrt(sum2[k] / kSamples - mean[k] * mean[k]), 0.004, 0.0012) << "noise";
      bias2[k] += mean[k] * mean[k] / kSeeds;
    }
    EXPECT_NEAR(norm(accel / kSamples), 9.81, 0.3);
  }
  const double bias = math::sqrt((bias2.x + bias2.y + bias2.z) / 3);
  EXPECT_NEAR(bias, 0.01, 0.005) << "offsets";
}

TEST(PitchSensors, EncodersReadInSteps) {
  const PitchBody kid = kid_with({});
  const auto pitch = pitch_with({}, {kid});
  pitch->command(0, kid.start.joints_rad);
  run(*pitch, 0.3);
  const double step = 2 * math::kPi / 4096;
  for (std::size_t j = 0; j < kid.body.joints(); ++j) {
    const double in_steps = pitch->sensors(0).joint[j].position_rad / step;
    EXPECT_NEAR(in_steps, math::round(in_steps), 1e-6);
  }
}

TEST(PitchSensors, CellsSayWhereTheWeightIs) {
  PitchBody kid = kid_with(BodyErrors::none());
  kid.gain_per_rad = 12;
  PitchOptions options;
  options.ground = GroundErrors::none();
  const auto pitch = pitch_with(options, {kid});
  const auto forward_share = [&](double lean) {
    auto rad = kid.start.joints_rad;
    for (const char* ankle : {"l_ankle_pitch", "r_ankle_pitch"}) rad[*kid.body.find_link(ankle) - 1] += lean;
    pitch->place(0, kid.start);
    pitch->command(0, rad);
    run(*pitch, 1.5);
    double front = 0, all = 0;
    for (const auto& foot : pitch->sensors(0).cell_n)
      for (std::size_t c = 0; c < 4; ++c) all += foot[c], front += c < 2 ? foot[c] : 0;
    EXPECT_NEAR(all, 9.81 * kid.body.mass_kg(), 1);
    return front / all;
  };
  const double upright = forward_share(0), leaning = forward_share(0.06), back = forward_share(-0.06);
  EXPECT_GT(math::fabs(leaning - back), 0.1);
  EXPECT_GT((leaning - upright) * (upright - back), 0) << "in between";
}

TEST(PitchErrors, AreAFlatTableOfOptionsWithTheirDefaults) {
  WorldValues values;
  for (const WorldOption& o : pitch_options()) {
    EXPECT_TRUE(o.value || *o.otherwise) << o.key;
    EXPECT_TRUE(!o.value || o.allows(*o.value)) << o.key;
    EXPECT_EQ(std::count_if(pitch_options().begin(), pitch_options().end(),
                            [&](const WorldOption& other) { return std::string(other.key) == o.key; }),
              1)
        << o.key;
    values[o.key] = o.most;
  }
  const BodyErrors most = BodyErrors::from(values);
  EXPECT_EQ(most.command_delay_ms, 60);
  EXPECT_EQ(most.backlash_deg, 2);
  EXPECT_EQ(most.encoder_at_motor, 1);
  EXPECT_EQ(GroundErrors::from(values).roughness_mm, 10);
  const BodyErrors usual = BodyErrors::from({});
  EXPECT_TRUE(math::is_nan(usual.command_delay_ms));
  EXPECT_EQ(usual.backlash_deg, 0.25);
  EXPECT_EQ(usual.imu_delay_ms, 10);
}

}  // namespace
}  // namespace sinew::plant::pitch_sensors_test
