#include "control/nav_estimator.hpp"

#include <gmock/gmock.h>

#include "math/random.hpp"

namespace sinew::control::nav_estimator_test {
namespace {

using math::Quat;
using math::Vec3;

constexpr std::int64_t kMs = 1'000'000;

/// A vehicle that stands or moves as the test says, and the messages that its sensors would send.
struct Vehicle {
  Quat q_world_base;
  Vec3 p_world_m, v_world_mps, a_world_mps2, gyro_radps;
  Vec3 gyro_bias_radps, accel_bias_mps2;
  double shake_mps2 = 0.05;
  math::Random noise{1}, pixel_noise{2};
  std::int64_t now_ns = 0;

  Vec3 random(double sigma) {
    const double x = noise.normal(), y = noise.normal(), z = noise.normal();
    return Vec3{x, y, z} * sigma;
  }
  msg::ImuSample imu_after(std::int64_t dt_ns) {
    const double dt_s = 1e-9 * static_cast<double>(dt_ns);
    now_ns += dt_ns;
    const Vec3 f = q_world_base.conjugate().rotate(a_world_mps2 + Vec3{0, 0, kGravity});
    p_world_m += v_world_mps * dt_s + a_world_mps2 * (0.5 * dt_s * dt_s);
    v_world_mps += a_world_mps2 * dt_s;
    q_world_base = (q_world_base * Quat::exp(gyro_radps * dt_s)).normalized();
    msg::ImuSample s;
    s.stamp = {now_ns};
    s.gyro_radps = (gyro_radps + gyro_bias_radps + random(0.004)).to<msg::Vec3>();
    s.accel_mps2 = (f + accel_bias_mps2 + random(shake_mps2)).to<msg::Vec3>();
    return s;
  }
  msg::RangeSample range() {
    msg::RangeSample s;
    s.stamp = {now_ns};
    s.range_m = p_world_m.z / q_world_base.rotate({0, 0, 1}).z - 0.04 + noise.normal(0, 0.005);
    return s;
  }
  msg::PadSighting pad(const Vec3& pad_world_m) {
    const Vec3 camera = p_world_m + q_world_base.rotate({0, 0, -0.04});
    const Vec3 seen = q_world_base.conjugate().rotate(pad_world_m - camera);
    msg::PadSighting s;
    s.stamp = {now_ns};
    const Vec3 optical = Vec3{-seen.y, -seen.x, -seen.z} / norm(seen);
    s.direction_optical = normalized(optical + Vec3{pixel_noise.normal(0, 2e-4), 0, 0}).to<msg::Vec3>();
    s.range_m = norm(seen);
    s.found = 1;
    s.confidence = 0.9;
    return s;
  }
};

void stand(NavEstimator& nav, Vehicle& v, double seconds) {
  for (int i = 0; i < static_cast<int>(seconds * 1000); ++i) {
    ASSERT_TRUE(nav.add_imu(v.imu_after(kMs)));
    if (i % 20 == 0) nav.add_range(v.range());
  }
}

double tilt_error(const NavEstimator& nav, const Vehicle& v) {
  const Vec3 up{0, 0, 1};
  const Vec3 a = nav.filter().state().q_world_base.conjugate().rotate(up), b = v.q_world_base.conjugate().rotate(up);
  return math::atan2(norm(cross(a, b)), dot(a, b));
}

TEST(NavEstimator, StandingStillFindsTiltAndGyroBias) {
  NavEstimator nav;
  Vehicle v;
  v.q_world_base = Quat::from_yaw_pitch_roll({0, 0.2, -0.3});
  v.gyro_bias_radps = {0.02, -0.05, 0.04};
  v.p_world_m = {0, 0, 0.12};
  stand(nav, v, 2);
  const msg::NavState n = nav.output();
  EXPECT_LT(tilt_error(nav, v), 0.005);
  EXPECT_LT(norm(Vec3(n.gyro_bias_radps) - v.gyro_bias_radps), 1e-3);
  EXPECT_LT(norm(Vec3(n.v_world_mps)), 0.01);
  EXPECT_NEAR(n.height_m, 0.12, 0.01);
  EXPECT_TRUE(n.attitude_valid);
  EXPECT_TRUE(n.height_valid);
  EXPECT_TRUE(n.position_valid);
  EXPECT_TRUE(n.at_rest);
}

TEST(NavEstimator, WithoutHeightThereIsAnAttitudeButNoPosition) {
  NavEstimator nav;
  Vehicle v;
  for (int i = 0; i < 5000; ++i) ASSERT_TRUE(nav.add_imu(v.imu_after(kMs)));
  const msg::NavState n = nav.output();
  EXPECT_TRUE(n.attitude_valid);
  EXPECT_FALSE(n.height_valid);
  EXPECT_FALSE(n.position_valid);
}

TEST(NavEstimator, InertialSamplesAloneKeepVelocityAndPositionBounded) {
  NavEstimator nav;
  Vehicle v;
  v.shake_mps2 = 1.0;
  v.gyro_bias_radps = {0.03, 0.05, -0.04};
  for (int i = 0; i < 120 * 200; ++i) {  // swings around for two minutes
    const double t = 0.005 * i;
    v.a_world_mps2 = {math::sin(t), 0.7 * math::cos(1.3 * t), 0};
    v.gyro_radps = {0.5 * math::sin(0.9 * t), 0.3 * math::cos(0.7 * t), 0.2};
    ASSERT_TRUE(nav.add_imu(v.imu_after(5 * kMs)));
    if (t > 10) {
      ASSERT_LT(tilt_error(nav, v), 0.09) << "at " << t;
    }
  }
  EXPECT_LT(norm(nav.filter().state().v_world_mps), 5);
  EXPECT_LT(norm(nav.filter().state().p_world_m), 200);
  EXPECT_LT(tilt_error(nav, v), 0.03);
}

TEST(NavEstimator, RefusesSamplesThatAreNotFiniteOrOlder) {
  NavEstimator nav;
  Vehicle v;
  stand(nav, v, 1);
  const msg::NavState before = nav.output();
  msg::ImuSample bad = v.imu_after(kMs);
  bad.gyro_radps.y = math::kNan;
  EXPECT_FALSE(nav.add_imu(bad));
  bad = v.imu_after(0);
  bad.stamp.ns -= 5 * kMs;
  EXPECT_FALSE(nav.add_imu(bad));
  msg::RangeSample range;
  range.range_m = math::kNan;
  nav.add_range(range);
  range.range_m = math::kInf;
  nav.add_range(range);
  msg::PadSighting pad = v.pad({});
  pad.direction_optical.x = math::kNan;
  nav.add_pad(pad);
  const msg::NavState after = nav.output();
  EXPECT_EQ(after.p_world_m, before.p_world_m);
  EXPECT_EQ(after.q_world_base, before.q_world_base);
  EXPECT_EQ(nav.counters().refused_imu, 2u);
}

TEST(NavEstimator, TheSameSampleTwiceIsNoNewsAndNoHarm) {
  NavEstimator once, twice;
  Vehicle v;
  for (int i = 0; i < 2000; ++i) {
    const msg::ImuSample s = v.imu_after(kMs);
    ASSERT_TRUE(once.add_imu(s));
    ASSERT_TRUE(twice.add_imu(s));
    ASSERT_TRUE(twice.add_imu(s));
  }
  EXPECT_EQ(once.output().q_world_base, twice.output().q_world_base);
  EXPECT_EQ(once.output().tilt_std_rad, twice.output().tilt_std_rad);
  EXPECT_EQ(twice.counters().same_imu, 2000u);
}

TEST(NavEstimator, GapInTheSamplesStartsAnewAndKeepsTheBias) {
  NavEstimator nav;
  Vehicle v;
  v.gyro_bias_radps = {0.03, 0, 0};
  stand(nav, v, 2);
  ASSERT_TRUE(nav.add_imu(v.imu_after(500 * kMs)));
  EXPECT_FALSE(nav.started());
  EXPECT_EQ(nav.counters().gaps, 1u);
  stand(nav, v, 0.3);
  ASSERT_TRUE(nav.started());
  EXPECT_NEAR(nav.filter().state().gyro_bias_radps.x, 0.03, 2e-3);
}

TEST(NavEstimator, FirstSightingsPlaceThePadAndLaterOnesHoldThePosition) {
  NavEstimator nav;
  Vehicle v;
  v.p_world_m = {0, 0, 1.5};
  stand(nav, v, 1);
  nav.set_motors_stopped(false);
  v.shake_mps2 = 0.4;
  v.accel_bias_mps2 = {0.05, -0.04, 0};  // a tenth of a metre in two seconds, were nothing seen
  const Vec3 pad{0.5, -0.4, 0};
  for (int i = 0; i < 10000; ++i) {
    ASSERT_TRUE(nav.add_imu(v.imu_after(kMs)));
    if (i % 20 == 0) nav.add_range(v.range());
    if (i % 33 == 0) nav.add_pad(v.pad(pad));
  }
  const msg::NavState n = nav.output();
  ASSERT_TRUE(n.pad_known);
  EXPECT_NEAR(n.pad_world_m.x, 0.5, 0.03);
  EXPECT_NEAR(n.pad_world_m.y, -0.4, 0.03);
  EXPECT_NEAR(n.p_world_m.x, 0, 0.03);
  EXPECT_NEAR(n.p_world_m.y, 0, 0.03);
  EXPECT_LT(norm(Vec3(n.v_world_mps)), 0.05);
}

TEST(NavEstimator, LateSightingIsComparedWithThePoseOfItsOwnInstant) {
  // At 1 m/s a delay of 80 ms taken as now would be an error of 8 cm.
  NavEstimator nav;
  Vehicle v;
  v.p_world_m = {0, 0, 1.5};
  stand(nav, v, 1);
  nav.set_motors_stopped(false);
  const Vec3 pad{1.0, 0, 0};
  std::vector<msg::PadSighting> waiting;
  double worst = 0;
  for (int i = 0; i < 3000; ++i) {
    v.a_world_mps2 = {i < 1000 ? 1.0 : i < 2000 ? -1.0 : 0.0, 0, 0};
    ASSERT_TRUE(nav.add_imu(v.imu_after(kMs)));
    if (i % 20 == 0) nav.add_range(v.range());
    if (i % 33 == 0) waiting.push_back(v.pad(pad));
    if (!waiting.empty() && v.now_ns - waiting.front().stamp.ns >= 80 * kMs) {
      nav.add_pad(waiting.front());
      waiting.erase(waiting.begin());
    }
    if (i > 400) {
      const Vec3 seen = Vec3(nav.output().pad_world_m) - nav.filter().state().p_world_m;
      worst = std::max(worst, math::fabs(seen.x - (pad.x - v.p_world_m.x)));
    }
  }
  EXPECT_LT(worst, 0.035);
}

TEST(NavEstimator, SightingOlderThanTheHistoryIsCountedAndNotUsed) {
  NavEstimator nav;
  Vehicle v;
  v.p_world_m = {0, 0, 1.5};
  stand(nav, v, 1);
  msg::PadSighting old = v.pad({});
  old.stamp.ns -= 700 * kMs;
  nav.add_pad(old);
  EXPECT_EQ(nav.counters().late_pad, 1u);
}

TEST(NavEstimator, FalseSightingIsRefusedAndALastingMoveIsFollowed) {
  NavEstimator nav;
  Vehicle v;
  v.p_world_m = {0, 0, 1.5};
  stand(nav, v, 1);
  const auto watch = [&](const Vec3& pad, int sightings) {
    for (int i = 0; i < sightings * 33; ++i) {
      ASSERT_TRUE(nav.add_imu(v.imu_after(kMs)));
      if (i % 33 == 0) nav.add_pad(v.pad(pad));
    }
  };
  watch({}, 40);
  const msg::NavState before = nav.output();
  watch({0.8, 0, 0}, 1);
  EXPECT_EQ(nav.counters().gated_pad, 1u);
  EXPECT_NEAR(nav.output().p_world_m.x, before.p_world_m.x, 0.01);
  watch({0.8, 0, 0}, 20);
  EXPECT_EQ(nav.counters().reopened_position, 1u);
  EXPECT_NEAR(nav.output().p_world_m.x, before.p_world_m.x - 0.8, 0.05);
}

TEST(NavEstimator, CrateUnderTheVehicleChangesTheGroundAndNotTheHeightOfTheVehicle) {
  NavEstimator nav;
  Vehicle v;
  v.p_world_m = {0, 0, 1.5};
  stand(nav, v, 1);
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(nav.add_imu(v.imu_after(kMs)));
    if (i % 20 != 0) continue;
    msg::RangeSample s = v.range();
    s.range_m -= 0.6;
    nav.add_range(s);
  }
  const msg::NavState n = nav.output();
  EXPECT_EQ(nav.counters().new_ground, 1u);
  EXPECT_NEAR(n.p_world_m.z, 1.5, 0.05);
  EXPECT_NEAR(n.height_m, 0.9, 0.05);
}

TEST(NavEstimator, SampleBeyondWhatAnImuMeasuresIsRefused) {
  NavEstimator nav;
  Vehicle v;
  stand(nav, v, 1);
  msg::ImuSample s = v.imu_after(kMs);
  s.gyro_radps.x = 1000;
  EXPECT_FALSE(nav.add_imu(s));
  s = v.imu_after(kMs);
  s.accel_mps2.z = -1e300;
  EXPECT_FALSE(nav.add_imu(s));
  EXPECT_EQ(nav.counters().refused_imu, 2u);
  EXPECT_TRUE(nav.add_imu(v.imu_after(kMs)));
}

/// A vehicle in the air with a barometer, and a range finder whose values the test sets; each 50 times a second.
struct Hover {
  NavEstimator nav;
  Vehicle v;
  Hover() {
    v.p_world_m = {0, 0, 1.5};
    nav.set_motors_stopped(false);
    run(5, [this](int) { return v.range().range_m; });
  }
  template <class Range>
  void run(double seconds, Range&& range_m) {
    for (int i = 0; i < static_cast<int>(seconds * 1000); ++i) {
      ASSERT_TRUE(nav.add_imu(v.imu_after(kMs)));
      if (i % 20 != 0) continue;
      msg::RangeSample s = v.range();
      s.range_m = range_m(i / 20);
      nav.add_range(s);
      msg::BaroSample b;
      b.stamp = {v.now_ns};
      b.temperature_c = 22;
      b.pressure_pa = 100900 - 11.7 * v.p_world_m.z + v.noise.normal(0, 2);
      nav.add_baro(b);
    }
  }
};

TEST(NavEstimator, RangesThatJumpAboutAreNoNewGround) {
  Hover h;
  const double nonsense[] = {1e300, 0.2, 5, 1e-300, 12, 2.9, math::kNan, 0.6};
  h.run(4, [&](int i) { return nonsense[i % 8]; });
  EXPECT_EQ(h.nav.counters().new_ground, 0u);
  EXPECT_NEAR(h.nav.output().height_m, 1.5, 0.4);
}

TEST(NavEstimator, RangeThatStaysAtOneValueInFlightIsNotFollowed) {
  Hover h;
  h.v.a_world_mps2.z = 0.5;  // it climbs; the range finder does not see it
  h.run(2, [](int) { return 1.46; });
  h.v.a_world_mps2.z = 0;
  EXPECT_GT(h.nav.counters().stuck_range, 50u);
  EXPECT_EQ(h.nav.counters().new_ground, 0u);
  EXPECT_NEAR(h.nav.output().height_m, h.v.p_world_m.z, 0.4) << "and not 1.5 m";
  h.run(1, [&](int) { return h.v.range().range_m; });
  EXPECT_NEAR(h.nav.output().height_m, h.v.p_world_m.z, 0.1) << "it speaks again";
}

TEST(NavEstimator, SaysWhenNoRangeFitsAnyMore) {
  Hover h;
  EXPECT_TRUE(h.nav.output().ground_seen);
  h.run(0.2, [](int) { return math::kNan; });
  EXPECT_TRUE(h.nav.output().ground_seen);
  h.run(0.2, [](int) { return math::kNan; });
  EXPECT_FALSE(h.nav.output().ground_seen);
  h.run(0.1, [&](int) { return h.v.range().range_m; });
  EXPECT_TRUE(h.nav.output().ground_seen);
}

TEST(NavEstimator, WithoutRangesTheSizeOfThePadIsTheHeight) {
  for (const bool sized : {true, false}) {
    Hover h;
    const double start_m = h.v.p_world_m.z;
    double weather_pa = 0;
    for (int i = 0; i < 20000; ++i) {
      ASSERT_TRUE(h.nav.add_imu(h.v.imu_after(kMs)));
      if (i % 20 == 0) {
        weather_pa += 0.01;  // 10 Pa in all: 0.85 m down, says the barometer
        msg::BaroSample b;
        b.stamp = {h.v.now_ns};
        b.temperature_c = 22;
        b.pressure_pa = 100900 - 11.7 * h.v.p_world_m.z + weather_pa + h.v.noise.normal(0, 2);
        h.nav.add_baro(b);
      }
      if (i % 33 == 0) {
        msg::PadSighting s = h.v.pad({0.3, 0.2, 0});
        s.range_m = sized ? 1.05 * s.range_m : math::kNan;
        h.nav.add_pad(s);
      }
    }
    const double error_m = math::fabs(h.nav.output().height_m - start_m);
    if (sized)
      EXPECT_LT(error_m, 0.25);
    else
      EXPECT_GT(error_m, 0.5) << "what the barometer alone makes of it";
  }
}

TEST(NavEstimator, GroundThatMovesAgainAndAgainIsAHeightThatRanAway) {
  Hover h;
  h.v.p_world_m.z += 0.5;
  h.v.v_world_mps = {};
  for (int i = 0; i < 100; ++i) {  // a shock of 3 m/s that the vehicle stops and the IMU does not show
    msg::ImuSample s = h.v.imu_after(kMs);
    s.accel_mps2.z += 30;
    ASSERT_TRUE(h.nav.add_imu(s));
  }
  h.run(3, [&](int) { return h.v.range().range_m; });
  const msg::NavState n = h.nav.output();
  EXPECT_GT(h.nav.counters().reopened_height, 0u);
  EXPECT_NEAR(n.v_world_mps.z, 0, 0.1);
  EXPECT_NEAR(n.height_m, h.v.p_world_m.z, 0.1);
}

TEST(NavEstimator, PictureThatIsFrozenInFlightMovesNothing) {
  Hover h;
  const auto watch = [&](int sightings, auto&& sighting) {
    for (int i = 0; i < sightings * 33; ++i) {
      ASSERT_TRUE(h.nav.add_imu(h.v.imu_after(kMs)));
      if (i % 20 == 0) h.nav.add_range(h.v.range());
      if (i % 33 == 0) h.nav.add_pad(sighting());
    }
  };
  watch(40, [&] { return h.v.pad({}); });
  const msg::PadSighting frozen = h.v.pad({});
  const msg::Time before = h.nav.output().pad_stamp;
  watch(30, [&] {
    msg::PadSighting s = frozen;
    s.stamp = {h.v.now_ns};
    return s;
  });
  EXPECT_GT(h.nav.counters().stuck_pad, 15u);
  EXPECT_LT(msg::seconds(h.nav.output().pad_stamp - before), 0.4) << "the pad counts as lost";
}

TEST(NavEstimator, RangeMayStandStillWithTheVehicle) {
  NavEstimator nav;
  Vehicle v;
  for (int i = 0; i < 2000; ++i) {
    ASSERT_TRUE(nav.add_imu(v.imu_after(kMs)));
    msg::RangeSample s;
    s.stamp = {v.now_ns};
    s.range_m = 0.08;
    if (i % 20 == 0) nav.add_range(s);
  }
  EXPECT_EQ(nav.counters().stuck_range, 0u);
  EXPECT_TRUE(nav.output().height_valid);
}

TEST(NavEstimator, BarometerHoldsTheHeightWhenTheRangeFinderIsSilent) {
  NavEstimator nav;
  Vehicle v;
  v.p_world_m = {0, 0, 1.5};
  nav.set_motors_stopped(false);
  for (int i = 0; i < 20000; ++i) {
    ASSERT_TRUE(nav.add_imu(v.imu_after(kMs)));
    if (i % 20 == 0 && i < 5000) nav.add_range(v.range());
    if (i % 20 == 0) {
      msg::BaroSample s;
      s.stamp = {v.now_ns};
      s.temperature_c = 22;
      s.pressure_pa = 100900 - 11.7 * v.p_world_m.z + v.noise.normal(0, 2);
      nav.add_baro(s);
    }
  }
  const msg::NavState n = nav.output();
  EXPECT_TRUE(n.height_valid);
  EXPECT_NEAR(n.p_world_m.z, 1.5, 0.4);
}

}  // namespace
}  // namespace sinew::control::nav_estimator_test
