// NavEstimator outdoors: GNSS, magnetometer, heading without one, jumps and their size.
#include <gmock/gmock.h>

#include <functional>

#include "control/nav_estimator.hpp"
#include "math/random.hpp"

namespace sinew::control::nav_outdoors_test {
namespace {

using math::Quat;
using math::Vec3;
using msg::NavResetCause;
using msg::NavSource;

constexpr std::int64_t kStepNs = 4'000'000;  // 250 Hz
constexpr double kStep_s = 0.004, kDegree = math::kPi / 180;
constexpr GeodeticPoint kPlace{47.398, 8.546, 488};

/// A multicopter as its sensors see it: world east, north, up. It leans as its acceleration and drag ask.
struct Vehicle {
  NavEstimator nav;
  math::Random noise{3};
  std::int64_t now_ns = 0;
  Vec3 p, v, a;
  double yaw = 1.1, yaw_rate = 0;
  Vec3 gyro_bias{0.01, -0.008, 0.012}, accel_bias{0.06, -0.05, 0.08};
  Vec3 antenna, wind;
  double drag = 0;
  double delay_s = 0.12, shake = 0.25;
  Quat q;
  // What is wrong.
  bool gnss_on = true, mag_on = true, baro_on = true;
  Vec3 gnss_offset, gnss_v_offset;
  double mag_turn_rad = 0;
  Vec3 mag_body_t{1.0e-6, -1.5e-6, 0.8e-6};
  double accuracy_m = 0.5, baro_error_m = 0;
  std::vector<msg::NavReport> jumps;
  std::vector<std::pair<std::int64_t, msg::GnssSample>> coming;
  msg::NavReport last;
  double worst_heading_rad = 0, worst_step_m = 0;
  LocalFrame frame;
  Vec3 field = earth_field_t(kPlace, 2026.0).value();

  Vehicle() {
    frame.set(kPlace, {});
    nav.params.outdoors.gnss_delay_s = 0;
  }
  Vec3 random(double sigma) {
    const double x = noise.normal(), y = noise.normal(), z = noise.normal();
    return Vec3{x, y, z} * sigma;
  }
  double heading_error() const { return math::fabs(math::wrap_pi(nav.filter().state().q_world_base.yaw() - q.yaw())); }
  Vec3 position_error() const { return Vec3(nav.output().p_world_m) - p; }

  void step() {
    const Quat before = q;
    p += v * kStep_s + a * (0.5 * kStep_s * kStep_s);
    v += a * kStep_s;
    yaw += yaw_rate * kStep_s;
    const Vec3 push = (v - wind) * drag;  // the rotors' thrust has to stand against it
    q = Quat::between({0, 0, 1}, a + Vec3{push.x, push.y, kGravity}) * Quat::from_axis_angle({0, 0, 1}, yaw);
    const Vec3 rate = now_ns == 0 ? Vec3{} : (before.conjugate() * q).log() / kStep_s;
    now_ns += kStepNs;
    const std::int64_t n = now_ns / kStepNs;
    msg::ImuSample imu;
    imu.stamp = {now_ns};
    imu.gyro_radps = (rate + gyro_bias + random(0.004)).to<msg::Vec3>();
    imu.accel_mps2 = (q.conjugate().rotate(a + Vec3{0, 0, kGravity}) + accel_bias + random(shake)).to<msg::Vec3>();
    const Vec3 p_before = nav.started() ? nav.filter().state().p_world_m : Vec3{};
    ASSERT_TRUE(nav.add_imu(imu));
    if (n % 5 == 0 && mag_on) {
      msg::MagSample m;
      m.stamp = imu.stamp;
      const Vec3 seen = Quat::from_axis_angle({0, 0, 1}, mag_turn_rad).rotate(field);
      m.field_t = (q.conjugate().rotate(seen) + mag_body_t + random(5e-7)).to<msg::Vec3>();
      nav.add_mag(m);
    }
    if (n % 10 == 0 && baro_on) {
      msg::BaroSample b;
      b.stamp = imu.stamp;
      b.temperature_c = 15;
      b.pressure_pa = 101325 * math::exp(-(488 + p.z + baro_error_m + noise.normal(0, 0.15)) / (29.2718 * 288.15));
      nav.add_baro(b);
    }
    if (n % 50 == 0 && gnss_on) send_fix(rate);
    if (!coming.empty() && now_ns - coming.front().first >= static_cast<std::int64_t>(delay_s * 1e9)) {
      nav.add_gnss(coming.front().second);
      coming.erase(coming.begin());
    }
    const std::uint32_t jumps_before = last.resets;
    if (msg::NavReport r; nav.take_report(r)) {
      if (r.resets != jumps_before) jumps.push_back(r);
      last = r;
    }
    if (nav.started() && last.heading_valid != 0 && last.resets == jumps_before)
      worst_step_m = std::max(worst_step_m, norm(nav.filter().state().p_world_m - p_before - v * kStep_s));
    if (last.heading_valid != 0) worst_heading_rad = std::max(worst_heading_rad, heading_error());
  }
  void send_fix(const Vec3& rate) {
    msg::GnssSample g;
    g.stamp = {now_ns};
    const Vec3 at = p + q.rotate(antenna) + gnss_offset + Vec3{noise.normal(0, 0.15), noise.normal(0, 0.15), 0};
    // The inverse of the local frame, to first order around the place: good to a millimetre at this distance.
    const double across = 6378137 / math::sqrt(1 - 0.00669438 * 0.5418),
                 along = across * 0.99330562 / (1 - 0.00669438 * 0.5418);
    g.latitude_deg = kPlace.latitude_deg + at.y / (along + 488) / kDegree;
    g.longitude_deg =
        kPlace.longitude_deg + at.x / ((across + 488) * math::cos(kPlace.latitude_deg * kDegree)) / kDegree;
    g.altitude_m = 488 + at.z + noise.normal(0, 0.3);
    g.velocity_mps = (v + q.rotate(cross(rate, antenna)) + gnss_v_offset + random(0.05)).to<msg::Vec3>();
    g.horizontal_accuracy_m = g.vertical_accuracy_m = accuracy_m;
    g.speed_accuracy_mps = 0.2;
    g.fix = msg::GnssFix::full;
    g.satellites = 14;
    coming.push_back({now_ns, g});
  }
  void stand(double seconds) {
    nav.set_motors_stopped(true);
    const double shaking = shake;
    shake = 0.02;
    run(seconds, [](double) { return Vec3{}; });
    shake = shaking;
    nav.set_motors_stopped(false);
  }
  void run(double seconds, const std::function<Vec3(double)>& acceleration) {
    for (int i = 0; i < static_cast<int>(seconds / kStep_s); ++i) {
      a += (acceleration(kStep_s * i) - a) * (kStep_s / 0.15);  // it has to lean first
      ASSERT_NO_FATAL_FAILURE(step());
    }
  }
  void hover(double seconds) {
    run(seconds, [this](double) { return v * -0.8; });
  }
  /// Round and round: 2 m/s^2 and up to 3 m/s.
  void circle(double seconds) {
    run(seconds, [this](double) {
      const double turn = 0.7e-9 * static_cast<double>(now_ns);
      return Vec3{2 * math::cos(turn), 2 * math::sin(turn), 0} - v * 0.15;
    });
  }
};

TEST(NavOutdoors, StandingItFindsTrueNorthByTheMagnetometerAndTheModelOfTheEarthsField) {
  Vehicle v;
  v.mag_body_t = {};
  v.stand(3);
  EXPECT_TRUE(v.last.heading_valid);
  EXPECT_LT(v.heading_error(), 2 * kDegree);
  EXPECT_FALSE(v.last.field_model_expired);
  ASSERT_GE(v.jumps.size(), 1U);
  EXPECT_EQ(v.jumps[0].reset_cause, NavResetCause::first_heading);
  EXPECT_NEAR(v.jumps[0].reset_yaw_rad, 1.1, 3 * kDegree) << "the size of the turn is announced";
  EXPECT_NEAR(v.last.origin_latitude_deg, kPlace.latitude_deg, 1e-5);
}

TEST(NavOutdoors, FliesWithinItsStatedUncertaintyAndLearnsTheBodysField) {
  Vehicle v;
  v.mag_body_t = {3e-6, -2e-6, 1e-6};
  v.stand(3);
  v.yaw_rate = 0.5;
  v.circle(40);
  EXPECT_LT(v.heading_error(), 3 * kDegree);
  EXPECT_LT(v.heading_error(), 3 * v.last.heading_std_rad + 0.5 * kDegree);
  EXPECT_LT(norm(Vec3(v.last.body_field_t) - v.mag_body_t), 1.2e-6);
  const Vec3 e = v.position_error();
  EXPECT_LT(math::hypot(e.x, e.y), 0.5);
  EXPECT_LT(norm(Vec3(v.nav.output().v_world_mps) - v.v), 0.25);
  EXPECT_TRUE(v.nav.output().position_valid);
}

TEST(NavOutdoors, LateFixesAreUsedAtTheirOwnTime) {
  // 0.25 s late at 6 m/s: 1.5 m, were it taken as now.
  Vehicle v;
  v.delay_s = 0.25;
  v.stand(3);
  v.run(3, [](double) { return Vec3{2, 0, 0}; });
  v.run(10, [](double) { return Vec3{}; });
  const Vec3 e = v.position_error();
  EXPECT_LT(math::hypot(e.x, e.y), 0.4);
}

TEST(NavOutdoors, AntennaFarFromTheImuIsNoError) {
  Vehicle v;
  v.antenna = {0.8, 0, 0.3};
  v.nav.params.outdoors.p_base_antenna = v.antenna;
  v.stand(3);
  v.yaw_rate = 1.5;
  v.hover(20);
  const Vec3 e = v.position_error();
  EXPECT_LT(norm(Vec3(v.nav.output().v_world_mps) - v.v), 0.2);
  EXPECT_LT(math::hypot(e.x, e.y), 0.5);
}

TEST(NavOutdoors, WithoutMagnetometerTheHeadingIsFoundByMoving) {
  Vehicle v;
  v.mag_on = false;
  v.stand(5);
  v.hover(10);
  EXPECT_FALSE(v.last.heading_valid) << "hovering says nothing about the heading";
  EXPECT_GT(v.last.bank_heading_std_rad, 0.26);
  EXPECT_FALSE(v.nav.output().position_valid);
  v.circle(15);
  EXPECT_TRUE(v.last.heading_valid);
  v.circle(20);
  EXPECT_LT(v.heading_error(), 6 * kDegree);
  EXPECT_EQ(v.jumps[0].reset_cause, NavResetCause::first_heading);
}

TEST(NavOutdoors, MagnetometerTurnedBy90DegreesInFlightMovesTheHeadingByLessThan20Degrees) {
  Vehicle v;
  v.stand(3);
  v.circle(10);
  v.worst_heading_rad = 0;
  v.mag_turn_rad = 90 * kDegree;
  v.circle(30);
  v.hover(30);
  EXPECT_LT(v.worst_heading_rad, 20 * kDegree);
  EXPECT_GT(v.last.source[std::size_t(NavSource::mag)].rejected, 1000U);
  const Vec3 e = v.position_error();
  EXPECT_LT(math::hypot(e.x, e.y), 1.0);
  v.mag_turn_rad = 0;
  const std::uint32_t fused = v.last.source[std::size_t(NavSource::mag)].fused;
  v.circle(10);
  EXPECT_GT(v.last.source[std::size_t(NavSource::mag)].fused, fused) << "it is used again once it is right again";
}

TEST(NavOutdoors, MagnetometerTurnedFromTheStartIsFoundOutByMoving) {
  Vehicle v;
  v.mag_turn_rad = 90 * kDegree;
  v.stand(3);
  ASSERT_TRUE(v.last.heading_valid);
  EXPECT_NEAR(v.heading_error(), 90 * kDegree, 5 * kDegree) << "nothing can contradict it yet";
  v.circle(25);
  EXPECT_LT(v.heading_error(), 20 * kDegree);
  EXPECT_TRUE(v.last.mag_refused);
  const auto turned = std::find_if(v.jumps.begin(), v.jumps.end(),
                                   [](const msg::NavReport& r) { return r.reset_cause == NavResetCause::heading; });
  ASSERT_NE(turned, v.jumps.end());
  EXPECT_NEAR(math::fabs(turned->reset_yaw_rad), 90 * kDegree, 35 * kDegree) << "announced with its size";
}

TEST(NavOutdoors, HoverWithATurnedMagnetometerDoesNotTakeAHeadingFromABankThatIsNotSure) {
  Vehicle v;
  v.stand(3);
  v.mag_turn_rad = 90 * kDegree;
  v.worst_heading_rad = 0;
  v.hover(40);
  EXPECT_EQ(v.last.source[std::size_t(NavSource::heading_bank)].fused, 0U);
  EXPECT_LT(v.worst_heading_rad, 20 * kDegree);
}

TEST(NavOutdoors, GnssLostForAHalfMinuteAndBackIsAnnouncedWithTheSizeOfTheJump) {
  Vehicle v;
  v.stand(3);
  v.circle(15);
  const std::size_t before = v.jumps.size();
  v.gnss_on = false;
  v.circle(30);
  EXPECT_FALSE(v.nav.output().position_valid);
  const Vec3 off = v.position_error();
  v.gnss_on = true;
  v.circle(10);
  const Vec3 e = v.position_error();
  EXPECT_LT(math::hypot(e.x, e.y), 0.8);
  EXPECT_TRUE(v.nav.output().position_valid);
  if (math::hypot(off.x, off.y) > 1) {
    ASSERT_GT(v.jumps.size(), before);
    double announced = 0;
    for (std::size_t i = before; i < v.jumps.size(); ++i)
      announced += math::hypot(v.jumps[i].reset_p_world_m.x, v.jumps[i].reset_p_world_m.y);
    EXPECT_GT(announced, 0.5 * math::hypot(off.x, off.y));
  }
}

TEST(NavOutdoors, FixThatJumpsBy50MetresForTwoSecondsIsRefused) {
  Vehicle v;
  v.stand(3);
  v.circle(15);
  v.gnss_offset = {50, -20, 0};
  const std::size_t before = v.jumps.size();
  v.circle(2);
  EXPECT_EQ(v.jumps.size(), before);
  const Vec3 e = v.position_error();
  EXPECT_LT(math::hypot(e.x, e.y), 0.8);
  v.gnss_offset = {};
  v.circle(5);
  EXPECT_EQ(v.jumps.size(), before);
}

TEST(NavOutdoors, PositionPulledSlowlyAwayFromItsOwnVelocityIsFoundOut) {
  Vehicle v;
  v.stand(3);
  v.circle(40);
  for (int i = 0; i < 40; ++i) {
    v.gnss_offset.x += 0.5;  // half a metre each second; the velocities stay true
    v.circle(1);
  }
  EXPECT_TRUE(v.last.gnss_pulled);
  EXPECT_LT(math::fabs(v.position_error().x), 0.5 * v.gnss_offset.x) << "of 20 m";
}

TEST(NavOutdoors, CarriedAtAConstantSpeedItIsNotAtRest) {
  // On a boat or a car, motors off: the inertial samples are as quiet as on the ground.
  Vehicle v;
  v.stand(3);
  v.nav.set_motors_stopped(true);
  v.shake = 0.02;
  v.run(5, [](double) { return Vec3{1, 0, 0}; });
  v.worst_heading_rad = 0;
  v.run(30, [](double) { return Vec3{}; });
  EXPECT_FALSE(v.nav.output().at_rest);
  EXPECT_LT(norm(Vec3(v.nav.output().v_world_mps) - v.v), 0.25);
  EXPECT_LT(v.worst_heading_rad, 4 * kDegree);
  EXPECT_LT(v.worst_step_m, 0.5);
  v.run(3, [](double t) { return Vec3{t < 2.5 ? -2.0 : 0, 0, 0}; });
  v.run(5, [&](double) { return v.v * -4.0; });
  EXPECT_TRUE(v.nav.output().at_rest) << "and when it stands, it is";
}

TEST(NavOutdoors, PushedSteadilyBeforeItsHeadingIsKnownItIsNotAtRest) {
  Vehicle v;
  v.mag_on = false;
  v.stand(5);
  v.nav.set_motors_stopped(true);
  v.shake = 0.02;
  v.run(5, [](double) { return Vec3{1, 0, 0}; });
  EXPECT_TRUE(v.last.heading_valid);
  EXPECT_LT(v.heading_error(), 2 * v.last.heading_std_rad);
  v.run(20, [](double t) { return Vec3{0, math::sin(0.5 * t), 0}; });
  EXPECT_LT(v.heading_error(), 2.5 * v.last.heading_std_rad);
  EXPECT_LT(v.last.heading_std_rad, 2 * kDegree);
  const Vec3 up = v.q.conjugate().rotate({0, 0, 1});
  EXPECT_GT(dot(v.nav.filter().state().q_world_base.conjugate().rotate({0, 0, 1}), up), math::cos(1.5 * kDegree));
}

TEST(NavOutdoors, PoorFixesAreNotUsed) {
  Vehicle v;
  v.stand(3);
  const std::uint32_t fused = v.last.source[std::size_t(NavSource::gnss_position)].fused;
  v.accuracy_m = 40;
  v.hover(3);
  EXPECT_LE(v.last.source[std::size_t(NavSource::gnss_position)].fused, fused + 1) << "one was on its way";
}

TEST(NavOutdoors, EveryJumpIsAnnounced) {
  Vehicle v;
  v.stand(3);
  v.circle(10);
  v.gnss_on = false;
  v.circle(20);
  v.gnss_on = true;
  v.mag_turn_rad = 1.5;
  v.circle(20);
  EXPECT_LT(v.worst_step_m, 0.55) << "no larger step without a report in the same step";
}

TEST(NavOutdoors, WindIsLearnedFromTheDragOfTheRotors) {
  Vehicle v;
  v.nav.params.outdoors.drag_per_s = 0.3;
  v.accel_bias = {};
  v.stand(3);
  v.drag = 0.3;
  v.wind = {4, -2, 0};
  v.yaw_rate = 0.6;
  v.circle(40);
  EXPECT_GT(v.last.source[std::size_t(NavSource::drag)].fused, 300U);
  EXPECT_NEAR(v.last.wind_world_mps.x, 4, 0.6);
  EXPECT_NEAR(v.last.wind_world_mps.y, -2, 0.6);
  EXPECT_LT(v.last.wind_std_mps, 1.0);
}

TEST(NavOutdoors, OpticalMotionHoldsTheVelocityWhenGnssIsGone) {
  for (const bool seen : {true, false}) {
    Vehicle v;
    v.stand(3);
    v.run(4, [](double t) { return Vec3{0, 0, t < 2 ? 1.5 : -1.5}; });  // 6 m up
    v.circle(10);
    v.gnss_on = false;
    for (int i = 0; i < 60 * 20; ++i) {
      v.circle(0.05);
      msg::GroundMotion m;
      m.stamp = {v.now_ns};
      const Vec3 base = v.q.conjugate().rotate(v.v) / v.p.z;
      m.forward_radps = base.x + v.noise.normal(0, 0.03);
      m.left_radps = base.y + v.noise.normal(0, 0.03);
      m.seen = seen;
      v.nav.add_motion(m);
    }
    const double off = norm(Vec3(v.nav.output().v_world_mps) - v.v);
    if (seen)
      EXPECT_LT(off, 0.4);
    else
      EXPECT_GT(off, 0.8) << "what a minute without anything makes of it";
  }
}

TEST(NavOutdoors, NoFirstHeadingFromAFieldThatIsNotTheEarths) {
  Vehicle v;
  v.mag_body_t = {6e-5, 2e-5, 0};
  v.stand(10);
  EXPECT_FALSE(v.last.heading_valid);
  EXPECT_EQ(v.last.source[std::size_t(NavSource::mag)].fused, 0U);
  EXPECT_GT(v.last.source[std::size_t(NavSource::mag)].rejected, 0U);
}

TEST(NavOutdoors, HardIronOfTheParametersIsSubtracted) {
  Vehicle v;
  v.mag_body_t = {6e-5, 2e-5, -1e-5};
  v.nav.params.outdoors.mag_hard_t = v.mag_body_t;
  v.stand(3);
  EXPECT_TRUE(v.last.heading_valid);
  EXPECT_LT(v.heading_error(), 2 * kDegree);
}

TEST(NavOutdoors, HeadingFoundBeforeThePlaceTurnsByTheDeclinationWhenAFixComes) {
  Vehicle v;
  v.mag_body_t = {};
  v.nav.params.outdoors.mag_wait_s = 1;
  v.gnss_on = false;
  v.stand(4);
  ASSERT_TRUE(v.last.heading_valid);
  const double declination = declination_rad(v.field);
  EXPECT_NEAR(v.heading_error(), math::fabs(declination), 1 * kDegree);
  v.gnss_on = true;
  v.stand(3);
  EXPECT_LT(v.heading_error(), 1 * kDegree);
  EXPECT_EQ(v.jumps.back().reset_cause, NavResetCause::declination);
  EXPECT_NEAR(math::fabs(v.jumps.back().reset_yaw_rad), math::fabs(declination), 1e-3);
}

TEST(NavOutdoors, BarometerThatReadsTooLowOverTheGroundDoesNotPullTheHeightDown) {
  for (const bool known : {true, false}) {
    Vehicle v;
    if (known) v.nav.params.outdoors.ground_effect_height_m = 1.5;
    v.stand(5);
    v.gnss_on = false;
    v.baro_error_m = -1.2;
    v.hover(3);
    if (known)
      EXPECT_LT(math::fabs(v.nav.output().p_world_m.z), 0.25);
    else
      EXPECT_LT(v.nav.output().p_world_m.z, -0.45) << "what it does without";
  }
}

TEST(NavOutdoors, WithoutOutdoorSamplesNothingOfItIsThere) {
  Vehicle v;
  v.gnss_on = v.mag_on = v.baro_on = false;
  v.hover(5);
  EXPECT_FALSE(v.nav.filter().covariance().has_surroundings());
  EXPECT_EQ(v.last.stamp.ns, 0) << "no report";
}

}  // namespace
}  // namespace sinew::control::nav_outdoors_test
