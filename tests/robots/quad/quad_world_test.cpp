// The simulated world without rendering: is it physics, and is it repeatable?
#include "robots/quad/world/quad_world.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "sim_hil/worlds/sensors.hpp"
#include "sim_hil/worlds/wind.hpp"

namespace sinew::plant::quad_world_test {
namespace {

constexpr std::array<double, kRotors> kOff{};
constexpr std::array<double, kRotors> kHalf{0.5, 0.5, 0.5, 0.5};
constexpr msg::Quat kLevel{};

QuadOptions ideal() {
  QuadOptions o;
  o.gust_mps = 0;
  o.spread = 0;
  o.start_offset_m = 0;
  o.start_yaw_rad = 0;
  o.sensor_errors = false;
  o.drag = false;
  return o;
}

std::unique_ptr<QuadWorld> make(const QuadOptions& o) {
  auto world = QuadWorld::create(o);
  EXPECT_TRUE(world);
  return std::move(*world);
}

template <class EachStep>
void run(QuadWorld& world, double seconds, const std::array<double, kRotors>& command, EachStep&& each) {
  const auto steps = static_cast<int>(seconds * 1e9 / static_cast<double>(kStepNs));
  for (int i = 0; i < steps; ++i) each(world.step(command));
}
void run(QuadWorld& world, double seconds, const std::array<double, kRotors>& command) {
  run(world, seconds, command, [](const Due&) {});
}

double norm(const msg::Vec3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

TEST(PlantWorld, FreeFlightIsTheSameFlightButForRounding) {
  QuadOptions full;
  full.seed = 11;
  full.start_offset_m = 0.5;
  QuadOptions quick = full;
  quick.free_flight = true;
  auto one = make(full), other = make(quick);
  for (QuadWorld* world : {one.get(), other.get()}) {
    world->quad().place({0.2, -0.3, 0.7}, {0.9950041652780258, 0.0998334166468282, 0, 0}, {0.3, 0.1, 0.5});
    run(*world, 0.3, {0.6, 0.59, 0.58, 0.6});
    run(*world, 1.5, {0.3, 0.31, 0.3, 0.29});  // falls to the floor and turns over
  }
  const TruthState a = one->quad().truth(), b = other->quad().truth();
  EXPECT_TRUE(one->quad().summary().touched_down);
  EXPECT_EQ(one->quad().summary().touched_down, other->quad().summary().touched_down);
  EXPECT_EQ(one->quad().summary().touchdown_at, other->quad().summary().touchdown_at);
  EXPECT_NEAR(one->quad().summary().touchdown_speed_mps, other->quad().summary().touchdown_speed_mps, 1e-9);
  EXPECT_NEAR(a.p_world_m.x, b.p_world_m.x, 1e-6);
  EXPECT_NEAR(a.p_world_m.y, b.p_world_m.y, 1e-6);
}

TEST(PlantWorld, AccelerometerFeelsPlusGUpwardAtRest) {
  auto world = make(ideal());
  run(*world, 0.5, kOff);
  int samples = 0;
  run(*world, 0.1, kOff, [&](const Due& due) {
    if (!due.imu) return;
    ++samples;
    EXPECT_NEAR(due.imu_sample.accel_mps2.x, 0, 0.02);
    EXPECT_NEAR(due.imu_sample.accel_mps2.y, 0, 0.02);
    EXPECT_NEAR(due.imu_sample.accel_mps2.z, kGravity, 0.05);
    EXPECT_NEAR(norm(due.imu_sample.gyro_radps), 0, 1e-3);
  });
  EXPECT_EQ(samples, 100);
  EXPECT_TRUE(world->quad().truth().on_pad);
  EXPECT_FALSE(world->quad().summary().flew);
}

TEST(PlantWorld, FreeFallIsWeightless) {
  auto world = make(ideal());
  world->quad().place({0, 0, 3}, kLevel);
  run(*world, 0.5, kOff, [&](const Due& due) {
    if (due.imu) {
      EXPECT_NEAR(norm(due.imu_sample.accel_mps2), 0, 1e-9);
    }
  });
  EXPECT_NEAR(world->quad().truth().v_world_mps.z, -0.5 * kGravity, 1e-9);
}

TEST(PlantWorld, AcceleratedFlightShowsInTheBaseFrame) {
  // Thrust along base z only, whatever the attitude: tilted by 90 degrees about x, base z points to -y of the world.
  auto world = make(ideal());
  const double h = std::sqrt(0.5);
  world->quad().place({0, 0, 3}, {h, h, 0, 0});
  run(*world, 0.3, kHalf);
  const TruthState t = world->quad().truth();
  EXPECT_NEAR(t.accel_mps2.x, 0, 1e-9);
  EXPECT_NEAR(t.accel_mps2.y, 0, 1e-9);
  EXPECT_GT(t.accel_mps2.z, 9.0);
  EXPECT_LT(t.v_world_mps.y, -1.0);
  EXPECT_NEAR(t.v_world_mps.x, 0, 1e-6);
}

TEST(PlantWorld, HoverThrustBalancesWeightNearHalfCommand) {
  auto world = make(ideal());
  world->quad().place({0, 0, 2}, kLevel);
  run(*world, 0.3, kHalf);
  const double with_half = world->quad().truth().accel_mps2.z * world->quad().mass_kg();
  const double volts = world->quad().truth().voltage_v / BatteryParams{}.nominal_v;
  EXPECT_NEAR(with_half, 0.5 * 4 * RotorParams{}.thrust_max_n * volts * volts, 0.05);
  EXPECT_NEAR(with_half, world->quad().mass_kg() * kGravity, 0.15 * world->quad().mass_kg() * kGravity);
  EXPECT_NEAR(norm(world->quad().truth().gyro_radps), 0, 1e-9);
}

TEST(PlantWorld, ThrustFollowsTheCommandWithTheRotorsLag) {
  auto world = make(ideal());
  world->quad().place({0, 0, 2}, kLevel);
  run(*world, RotorParams{}.lag_s, kHalf);
  const double target =
      RotorParams{}.omega_max_radps * std::sqrt(0.5) * world->quad().truth().voltage_v / BatteryParams{}.nominal_v;
  EXPECT_NEAR(world->quad().truth().omega_radps[0] / target, 1 - std::exp(-1.0), 0.02);
}

struct TorqueCase {
  const char* name;
  std::array<double, kRotors> command;
  msg::Vec3 sign;
};

class PlantTorque : public testing::TestWithParam<TorqueCase> {};

void PrintTo(const TorqueCase& c, std::ostream* out) { *out << c.name; }

TEST_P(PlantTorque, MotorsTurnTheVehicleAsDocumented) {
  auto world = make(ideal());
  world->quad().place({0, 0, 2}, kLevel);
  run(*world, 0.15, GetParam().command);
  const msg::Vec3 w = world->quad().truth().gyro_radps;
  const auto check = [](double rate, double sign) {
    if (sign == 0)
      EXPECT_NEAR(rate, 0, 0.02);
    else
      EXPECT_GT(rate * sign, 0.1);
  };
  check(w.x, GetParam().sign.x);
  check(w.y, GetParam().sign.y);
  check(w.z, GetParam().sign.z);
}

// Motors: 0 front right, 1 rear left (counter-clockwise); 2 front left, 3 rear right (clockwise).
INSTANTIATE_TEST_SUITE_P(Axes, PlantTorque,
                         testing::Values(TorqueCase{"Roll", {0.45, 0.55, 0.55, 0.45}, {1, 0, 0}},
                                         TorqueCase{"Pitch", {0.45, 0.55, 0.45, 0.55}, {0, 1, 0}},
                                         TorqueCase{"Yaw", {0.3, 0.3, 0.7, 0.7}, {0, 0, 1}}),
                         [](const auto& one) { return std::string(one.param.name); });

TEST(PlantWorld, BatterySagLowersThrust) {
  auto world = make(ideal());
  world->quad().place({0, 0, 2}, kLevel);
  run(*world, 0.1, kOff);
  const double idle = world->quad().truth().voltage_v;
  world->quad().place({0, 0, 2}, kLevel);
  run(*world, 0.3, {1, 1, 1, 1});
  EXPECT_LT(world->quad().truth().voltage_v, idle - 0.5);
  EXPECT_GT(world->quad().truth().current_a, 20);
  EXPECT_LT(world->quad().truth().current_a, 60);
}

TEST(PlantWorld, DragPullsTowardsTheWind) {
  QuadOptions o = ideal();
  o.drag = true;
  o.gust_mps = 2.0;
  auto world = make(o);
  world->quad().place({0, 0, 3}, kLevel);
  run(*world, 0.1, kOff);
  const TruthState t = world->quad().truth();
  EXPECT_GT(norm(t.wind_world_mps), 0.0);
  EXPECT_GT(t.accel_mps2.x * t.wind_world_mps.x + t.accel_mps2.y * t.wind_world_mps.y, 0.0);
}

TEST(PlantWorld, WindNeverExceedsTheLimitAndReachesHalfOfIt) {
  double strongest = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Wind wind({.gust_mps = 2.0}, seed);
    for (int i = 0; i < 40'000; ++i) {
      const double speed = norm(wind.step(1e-9 * kStepNs));
      ASSERT_LE(speed, 2.0 + 1e-12);
      strongest = std::max(strongest, speed);
    }
  }
  EXPECT_GT(strongest, 1.0);
}

TEST(PlantWorld, SteadyWindBlowsAsFastAndWhereItIsToldTo) {
  Wind north({.gust_mps = 0, .steady_mps = 3, .toward_rad = 3.14159265358979 / 2}, 1);
  for (int i = 0; i < 4000; ++i) {
    const msg::Vec3 v = north.step(1e-9 * kStepNs);
    ASSERT_NEAR(v.x, 0, 1e-12);
    ASSERT_NEAR(v.y, 3, 1e-12);
    ASSERT_EQ(v.z, 0);
  }
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Wind gusty({.gust_mps = 4, .steady_mps = 2}, seed);
    msg::Vec3 mean;
    double fastest = 0;
    constexpr int kSteps = 400'000;  // 100 s
    for (int i = 0; i < kSteps; ++i) {
      const msg::Vec3 v = gusty.step(1e-9 * kStepNs);
      mean = {mean.x + v.x / kSteps, mean.y + v.y / kSteps, 0};
      fastest = std::max(fastest, norm(v));
    }
    EXPECT_NEAR(norm(mean), 2, 0.5) << "direction by the seed " << seed;
    EXPECT_LE(fastest, 4 + 1e-12);
    EXPECT_GT(fastest, 2.5) << "with gusts on top";
  }
}

TEST(PlantWorld, AStartThatIsToldChangesNothingElseThatTheSeedSays) {
  QuadOptions told;
  told.seed = 5;
  auto drawn = make(told);
  told.start_x_m = 0.5, told.start_y_m = -1, told.start_heading_rad = 1, told.battery_charge = 0.5, told.wind_mps = 3;
  auto placed = make(told);
  const TruthState a = drawn->quad().truth(), b = placed->quad().truth();
  EXPECT_EQ(b.p_world_m.x, 0.5);
  EXPECT_EQ(b.p_world_m.y, -1);
  EXPECT_EQ(b.p_world_m.z, a.p_world_m.z);
  EXPECT_NEAR(2 * std::atan2(b.q_world_base.z, b.q_world_base.w), 1, 1e-12);
  EXPECT_EQ(placed->quad().mass_kg(), drawn->quad().mass_kg());
  EXPECT_EQ(placed->quad().thrust_factor(), drawn->quad().thrust_factor());
  EXPECT_LT(b.charge, a.charge);
  EXPECT_NEAR(b.charge, 0.5, 1e-3);
}

TEST(PlantWorld, RangeFinderMeasuresAlongItsBeam) {
  auto world = make(ideal());
  double range = 0;
  const auto fly = [&](const msg::Quat& q) {
    world->quad().place({1, 1, 2}, q);
    run(*world, 0.01, kOff, [&](const Due& due) {
      if (due.range) range = due.range_sample.range_m;
    });
    return world->quad().truth().p_world_m.z;
  };
  double z = fly(kLevel);
  EXPECT_NEAR(range, z + kRangePBase.z, 1e-3);
  const double tilt = 0.4;
  z = fly({std::cos(tilt / 2), 0, std::sin(tilt / 2), 0});
  EXPECT_NEAR(range, z / std::cos(tilt) + kRangePBase.z, 2e-3);
  fly({0, 1, 0, 0});  // upside down it sees the ceiling
  EXPECT_NEAR(range, 4.0 - world->quad().truth().p_world_m.z + kRangePBase.z, 1e-3);
}

TEST(PlantWorld, RangeOutOfReachIsNotANumber) {
  RangeModel model(RangeErrors{}, 1);
  EXPECT_TRUE(std::isnan(model.measure(-1)));
  EXPECT_TRUE(std::isnan(model.measure(RangeErrors{}.max_m + 0.1)));
  EXPECT_TRUE(std::isnan(model.measure(0.5 * RangeErrors{}.min_m)));
  EXPECT_NEAR(model.measure(1.0), 1.0, 0.05);
}

TEST(PlantWorld, BarometerFallsByTwelvePascalPerMetre) {
  BaroErrors e;
  e.noise_pa = e.walk_pa = e.wash_pa = 0;
  BaroModel a(e, 3), b(e, 3);
  EXPECT_NEAR(a.measure(0, 0, 0.02).pressure_pa - b.measure(1, 0, 0.02).pressure_pa, 11.7, 0.3);
}

TEST(PlantWorld, BatterySaysWhatTheMotorsDraw) {
  auto world = make(ideal());
  msg::BatterySample idle, flying;
  run(*world, 0.5, kOff, [&](const Due& due) {
    if (due.battery) idle = due.battery_sample;
  });
  run(*world, 5.0, {0.5, 0.5, 0.5, 0.5}, [&](const Due& due) {
    if (due.battery) flying = due.battery_sample;
  });
  EXPECT_EQ(flying.stamp.ns, 5'500'000'000);
  EXPECT_GT(flying.current_a, 5 * idle.current_a);
  EXPECT_LT(flying.voltage_v, idle.voltage_v);
  EXPECT_LT(flying.charge, idle.charge);
  EXPECT_EQ(flying.voltage_v, world->quad().truth().voltage_v) << "an ideal one tells the truth";
}

TEST(PlantWorld, SensorsComeAtTheirRatesWithStampsInOrder) {
  auto world = make(ideal());
  int imu = 0, range = 0, baro = 0, battery = 0, camera = 0;
  run(*world, 2.0, kOff, [&](const Due& due) {
    imu += due.imu, range += due.range, baro += due.baro, battery += due.battery,
        camera += static_cast<int>(due.cameras);
    if (due.imu) {
      EXPECT_EQ(due.imu_sample.stamp.ns, world->now().ns - 500000);
    }
  });
  EXPECT_EQ(imu, 2000);
  EXPECT_EQ(range, 200);
  EXPECT_EQ(baro, 100);
  EXPECT_EQ(battery, 20);
  EXPECT_EQ(camera, 60);
}

TEST(PlantWorld, ImuErrorsAreWithinTheirSheet) {
  QuadOptions o = ideal();
  o.sensor_errors = true;
  auto world = make(o);
  run(*world, 0.5, kOff);
  double sum = 0, sum2 = 0;
  run(*world, 2.0, kOff, [&](const Due& due) {
    if (!due.imu) return;
    sum += due.imu_sample.gyro_radps.x;
    sum2 += due.imu_sample.gyro_radps.x * due.imu_sample.gyro_radps.x;
  });
  const double mean = sum / 2000, sigma = std::sqrt(sum2 / 2000 - mean * mean);
  EXPECT_LT(std::fabs(mean), 0.05);
  EXPECT_NE(mean, 0.0);
  EXPECT_NEAR(sigma, ImuErrors{}.gyro_noise_radps, 0.0005);
}

TEST(PlantWorld, SpreadStaysWithinFivePercentAndDiffersBySeed) {
  double lightest = 10, heaviest = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    QuadOptions o;
    o.seed = seed;
    auto world = make(o);
    lightest = std::min(lightest, world->quad().mass_kg());
    heaviest = std::max(heaviest, world->quad().mass_kg());
    for (const double f : world->quad().thrust_factor()) EXPECT_NEAR(f, 1.0, 0.05);
    const msg::Vec3 p = world->quad().truth().p_world_m;
    EXPECT_LE(std::sqrt(p.x * p.x + p.y * p.y), 1.0);
  }
  EXPECT_GE(lightest, 1.2 * 0.95);
  EXPECT_LE(heaviest, 1.2 * 1.05);
  EXPECT_GT(heaviest - lightest, 0.06);
}

TEST(PlantWorld, DroppedVehicleLandsAndTheTouchdownIsMeasured) {
  auto world = make(ideal());
  world->quad().place({0.1, 0, 1.0}, kLevel);
  run(*world, 0.6, {0.41, 0.41, 0.41, 0.41});  // sinks slowly
  const double speed_guess = world->quad().truth().v_world_mps.z;
  EXPECT_LT(speed_guess, 0);
  run(*world, 2.0, {0.41, 0.41, 0.41, 0.41});
  const FlightSummary& s = world->quad().summary();
  EXPECT_TRUE(s.flew);
  ASSERT_TRUE(s.touched_down);
  EXPECT_FALSE(s.crashed);
  EXPECT_NEAR(s.touchdown_error_m, 0.1, 1e-3);
  const double fall = 1.0 - kFeetBelowBase;
  EXPECT_GT(s.touchdown_speed_mps, 0.5);
  EXPECT_LT(s.touchdown_speed_mps, std::sqrt(2 * kGravity * fall));
  run(*world, 1.5, kOff);
  EXPECT_TRUE(world->quad().truth().on_pad);
  EXPECT_NEAR(world->quad().truth().p_world_m.z, kFeetBelowBase, 0.003);
  EXPECT_NEAR(norm(world->quad().truth().v_world_mps), 0, 1e-3);
}

// ---- several vehicles

std::unique_ptr<QuadWorld> make_two(double apart_m) {
  QuadOptions a = ideal(), b = ideal();
  a.start_x_m = -apart_m / 2, b.start_x_m = apart_m / 2;
  auto world = QuadWorld::create(std::array{a, b});
  EXPECT_TRUE(world);
  return std::move(*world);
}

void run_two(QuadWorld& world, double seconds, double first, double second) {
  const std::array<double, kRotors> a{first, first, first, first}, b{second, second, second, second};
  const RobotCommand both[] = {a, b};
  for (int i = 0; i < static_cast<int>(seconds * 4000); ++i) world.advance(both);
}

TEST(QuadsInARoom, EachFliesByItsOwnCommand) {
  auto world = make_two(1.5);
  run_two(*world, 1.0, 0.6, 0);
  EXPECT_GT(world->quad(0).truth().p_world_m.z, 0.3);
  EXPECT_NEAR(world->quad(1).truth().p_world_m.z, kFeetBelowBase, 0.003);
  EXPECT_TRUE(world->quad(0).summary().flew);
  EXPECT_FALSE(world->quad(1).summary().flew);
  EXPECT_FALSE(world->quad(0).truth().contact);
  EXPECT_TRUE(world->quad(1).truth().contact);
}

TEST(QuadsInARoom, TheFirstFliesAsIfItWereAlone) {
  QuadOptions options;
  options.seed = 9;
  options.start_x_m = -0.8;
  QuadOptions other;
  other.seed = 10;
  other.start_x_m = 0.8;
  auto alone = make(options);
  auto two = std::move(*QuadWorld::create(std::array{options, other}));
  const std::array<double, kRotors> climb{0.6, 0.6, 0.6, 0.6};
  const RobotCommand both[] = {climb, climb};
  for (int i = 0; i < 4000; ++i) {
    const Due& due = alone->step(climb);
    two->advance(both);
    if (!due.imu) continue;
    const msg::ImuSample& beside_another = two->robot(0).due().imu_sample;
    ASSERT_NEAR(due.imu_sample.gyro_radps.x, beside_another.gyro_radps.x, 1e-6);
    ASSERT_NEAR(due.imu_sample.accel_mps2.z, beside_another.accel_mps2.z, 1e-5);
  }
  EXPECT_NEAR(alone->quad().truth().p_world_m.z, two->quad(0).truth().p_world_m.z, 1e-6);
  EXPECT_NE(two->quad(0).mass_kg(), two->quad(1).mass_kg());
}

TEST(QuadsInARoom, OneThatDropsOnAnotherHasCrashedAndSoHasTheOther) {
  auto world = make_two(1.5);
  world->quad(0).place({0.75, 0, 1.0}, kLevel);
  run_two(*world, 0.3, 0, 0);
  EXPECT_FALSE(world->quad(0).summary().crashed);
  run_two(*world, 0.7, 0, 0);
  EXPECT_TRUE(world->quad(0).summary().crashed);
  EXPECT_TRUE(world->quad(1).summary().crashed);
  EXPECT_GT(world->quad(0).truth().p_world_m.z, 0.15) << "they do not pass through each other";
}

TEST(QuadsInARoom, TheRangeFinderMeasuresToAVehicleBelow) {
  auto world = make_two(1.5);
  world->quad(0).place({0.75, 0, 2.0}, kLevel);
  msg::RangeSample range;
  for (int i = 0; i < 41; ++i) {
    run_two(*world, 0.00025, 0, 0);
    if (world->robot(0).due().range) range = world->robot(0).due().range_sample;
  }
  EXPECT_NEAR(range.range_m, 2.0 - 0.04 - (kFeetBelowBase + 0.08), 0.03) << "the hull is 7 cm high";
}

TEST(QuadsInARoom, StartApartOrNotAtAll) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    QuadOptions a, b;
    a.seed = seed, b.seed = seed_of_robot(seed, 1);
    auto world = QuadWorld::create(std::array{a, b});
    ASSERT_TRUE(world);
    const msg::Vec3 p = (*world)->quad(0).truth().p_world_m, q = (*world)->quad(1).truth().p_world_m;
    EXPECT_GE(std::hypot(p.x - q.x, p.y - q.y), 0.7);
  }
  QuadOptions same;
  same.start_x_m = same.start_y_m = 0.5;
  EXPECT_EQ(QuadWorld::create(std::array{same, same}).error().code, hal::Errc::bad_argument);
}

TEST(QuadsInARoom, EachSeesTheOthersAndNotItself) {
  auto world = make_two(1.5);
  const Scene scene = world->quad(1).scene(0);
  ASSERT_EQ(scene.vehicles, 2u);
  EXPECT_NEAR(scene.vehicle[0].p_world_m.x, -0.75, 1e-9);
  EXPECT_LT(scene.vehicle[1].p_world_m.z, -10);
  EXPECT_EQ(make(ideal())->quad().scene(0).vehicles, 0u);
}

TEST(QuadsInARoom, LandingErrorsCountFromWhereEachShallLand) {
  QuadOptions o = ideal();
  o.start_x_m = 0.3, o.land_x_m = 0.3, o.land_y_m = -0.4;
  EXPECT_NEAR(make(o)->quad().pad_distance_m(), 0.4, 1e-9);
}

std::uint64_t hash_run(std::uint64_t seed) {
  QuadOptions o;
  o.seed = seed;
  auto world = make(o);
  std::uint64_t h = 0xcbf29ce484222325u;
  const auto mix = [&h](const auto& value) {
    unsigned char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    for (const unsigned char b : bytes) h = (h ^ b) * 0x100000001b3u;
  };
  run(*world, 1.5, {0.55, 0.56, 0.54, 0.55}, [&](const Due& due) {
    if (due.imu) mix(due.imu_sample);
    if (due.range) mix(due.range_sample);
    if (due.baro) mix(due.baro_sample);
  });
  mix(world->quad().truth().p_world_m);
  return h;
}

TEST(PlantWorld, SameSeedAndCommandsGiveTheSameBytes) {
  EXPECT_EQ(hash_run(7), hash_run(7));
  EXPECT_NE(hash_run(7), hash_run(8));
}

TEST(PlantWorld, BytesAreTheOnesOfEveryOtherMachine) {
  // Seen with gcc and clang, with and without FMA and AVX; a change of the physics changes it on purpose.
  EXPECT_EQ(hash_run(7), 2289763086193298287u);
}

}  // namespace
}  // namespace sinew::plant::quad_world_test
