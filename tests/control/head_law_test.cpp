// The head's law in a closed loop with a model: joints that lag behind their setpoints, on a base that rocks.
#include "control/head_law.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>

#include "control/head_follower.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::control::head_law_test {
namespace {

using math::Quat;
using math::Vec3;
using msg::HeadMode;
using msg::Time;
using namespace std::chrono_literals;

constexpr double kDt = 1e-3, kLag = 0.04;

/// The motion around the head, as functions of time.
struct Model {
  double rock_rad = 0.17;
  Vec3 ball_m{1.7, 0.2, 0.1};  // from where the joints meet
  Vec3 ball_mps{0, 0, 0};
  bool sees = true, pictures = true;
  msg::SafetyState safety;
  HeadLaw law;
  std::array<double, 2> q{0.4, -0.3}, v{};
  double t = 1;
  std::deque<msg::BallSighting> on_the_way;  // 27 ms
  double angle2 = 0, elevation2 = 0;
  int counted = 0;

  Model() { safety.permitted = 1; }
  Quat base(double s) const {
    return Quat::from_yaw_pitch_roll(
        {0.1 * std::sin(0.9 * s), rock_rad * std::sin(1.7 * s + 1), rock_rad * std::sin(1.3 * s)});
  }
  Quat head() const {
    return base(t) * Quat::from_axis_angle({0, 0, 1}, q[0]) * Quat::from_axis_angle({0, 1, 0}, q[1]);
  }
  Time now() const { return {static_cast<std::int64_t>(t * 1e9)}; }
  Vec3 ball() const { return ball_m + (t - 1) * ball_mps; }

  void look() {
    msg::BallSighting s;
    s.stamp = now();
    const Vec3 d = math::normalized((head() * law.params.q_head_optical).conjugate().rotate(ball()));
    s.found = sees && d.z > 0.75;
    s.confidence = 0.9, s.angular_radius_rad = 0.04;
    s.direction_optical = d.to<msg::Vec3>();
    on_the_way.push_back(s);
  }
  void step() {
    const Quat before = head();
    t += kDt;
    for (int i = 0; i < 2; ++i) {
      v[i] = law.armed() ? std::clamp((law.setpoint_rad()[i] - q[i]) / kLag, -6.0, 6.0) : 0;
      q[i] += kDt * v[i];
    }
    msg::NavState nav;
    nav.stamp = now();
    nav.q_world_base = head().to<msg::Quat>();
    nav.gyro_radps = ((before.conjugate() * head()).log() / kDt).to<msg::Vec3>();
    nav.attitude_valid = 1;
    msg::JointState joints;
    joints.stamp = now();
    joints.count = 2;
    joints.position_rad = {q[0], q[1]}, joints.velocity_radps = {v[0], v[1]};
    if (pictures && static_cast<int>(t * 1000) % 33 == 0) look();
    for (; !on_the_way.empty() && now() - on_the_way.front().stamp > 27ms; on_the_way.pop_front())
      law.add(on_the_way.front());
    law.set_safety(safety);
    law.step(now(), nav, joints, kDt);
  }
  void run(double seconds, bool count = false) {
    for (const double end = t + seconds; t < end;) {
      step();
      if (!count) continue;
      const Vec3 axis = head().rotate({1, 0, 0}), to = math::normalized(ball());
      const double angle = std::acos(std::clamp(dot(axis, to), -1.0, 1.0));
      angle2 += angle * angle;
      elevation2 += std::pow(std::asin(axis.z), 2);
      ++counted;
    }
  }
  double angle_rms_deg() const { return std::sqrt(angle2 / counted) * 57.3; }
  double elevation_rms_deg() const { return std::sqrt(elevation2 / counted) * 57.3; }
};

TEST(HeadLaw, HoldsTheBallInTheMiddleWhileTheBaseRocks) {
  Model m;
  m.run(2);
  EXPECT_EQ(m.law.state().mode, HeadMode::follow);
  m.run(20, true);
  EXPECT_LT(m.angle_rms_deg(), 0.3);
}

TEST(HeadLaw, WithoutLookingAheadByTheServosLagItIsWorse) {
  Model ahead, late;
  late.law.params.lag_s = 0;
  for (Model* m : {&ahead, &late}) m->run(2), m->run(20, true);
  EXPECT_GT(late.angle_rms_deg(), 2 * ahead.angle_rms_deg());
}

TEST(HeadLaw, FollowsABallThatMoves) {
  Model m;
  m.ball_m = {1.7, -1.2, -0.3}, m.ball_mps = {0, 0.6, 0.15};
  m.run(1);
  m.run(3, true);
  EXPECT_EQ(m.law.state().mode, HeadMode::follow);
  EXPECT_LT(m.angle_rms_deg(), 0.8);
}

TEST(HeadLaw, SearchesLevelWhateverTheBaseDoes) {
  Model m;
  m.sees = false;
  m.run(2);
  EXPECT_EQ(m.law.state().mode, HeadMode::search);
  m.run(20, true);
  EXPECT_LT(m.elevation_rms_deg(), 0.5);
  double least = 9, most = -9;
  for (int i = 0; i < 8000; ++i) {
    m.step();
    least = std::min(least, m.q[0]), most = std::max(most, m.q[0]);
  }
  EXPECT_LT(least, -0.5);
  EXPECT_GT(most, 0.5);
}

TEST(HeadLaw, AHiddenBallIsWaitedForThenSearchedAndFoundAgain) {
  Model m;
  m.run(3);
  m.sees = false;
  m.run(0.5);
  EXPECT_EQ(m.law.state().mode, HeadMode::coast);
  m.run(4);
  EXPECT_EQ(m.law.state().mode, HeadMode::search);
  m.sees = true;
  m.run(6);
  EXPECT_EQ(m.law.state().mode, HeadMode::follow);
}

TEST(HeadLaw, SearchKeepsThePlaceOfTheLastSightingInThePictureForSecondsThenGoesWider) {
  Model m;
  m.ball_m = {1.7, 0.6, 0.2};
  m.run(3);
  m.sees = false;
  const Vec3 place = math::normalized(m.ball());
  const auto farthest = [&](double seconds) {
    double most = 0;
    for (const double end = m.t + seconds; m.t < end;) {
      m.step();
      const Vec3 axis = m.head().rotate({1, 0, 0});
      most = std::max(most, std::fabs(std::atan2(axis.y, axis.x) - std::atan2(place.y, place.x)));
    }
    return most;
  };
  const HeadParams& p = m.law.params;
  m.run(p.coast_s + 0.1);
  ASSERT_EQ(m.law.state().mode, HeadMode::search);
  EXPECT_LT(farthest(5), 0.5 * p.view_rad + 0.05) << "what hides a ball may do so for seconds";
  EXPECT_LT(std::fabs(m.law.state().elevation_rad - std::asin(place.z)), 0.02) << "at its height";
  EXPECT_GT(farthest(15), p.view_rad + 0.3);
}

TEST(HeadLaw, SearchBeginsToTheSideWhereTheBallWasGoing) {
  for (const double side : {-1.0, 1.0}) {
    Model m;
    m.ball_m = {1.7, -side, 0}, m.ball_mps = {0, 0.6 * side, 0};
    m.run(2);
    m.sees = false;
    m.ball_mps = {};
    m.run(m.law.params.coast_s);
    const double before = m.law.state().azimuth_rad;
    m.run(0.4);
    ASSERT_EQ(m.law.state().mode, HeadMode::search);
    EXPECT_GT(side * (m.law.state().azimuth_rad - before), 0.1);
  }
}

TEST(HeadLaw, WithoutPicturesItLooksStraightAheadAndLevel) {
  Model m;
  m.run(3);
  m.pictures = false;
  m.run(3);
  EXPECT_EQ(m.law.state().mode, HeadMode::hold);
  m.run(10, true);
  EXPECT_LT(m.elevation_rms_deg(), 0.5);
  EXPECT_LT(std::fabs(m.q[0]), 0.1);
  m.pictures = true;
  m.run(5);
  EXPECT_EQ(m.law.state().mode, HeadMode::follow);
}

TEST(HeadLaw, AFailsafesLandHoldsAndItsStopGivesUpTheJoints) {
  Model m;
  m.run(3);
  m.safety.action = msg::FailsafeAction::land;
  m.run(1);
  EXPECT_EQ(m.law.state().mode, HeadMode::hold);
  EXPECT_TRUE(m.law.armed());
  m.safety.action = msg::FailsafeAction::stop;
  m.run(0.1);
  EXPECT_EQ(m.law.state().mode, HeadMode::idle);
  EXPECT_FALSE(m.law.armed());
}

TEST(HeadLaw, ArmsWithPermissionOnlyAndBeginsWhereTheJointsStand) {
  Model m;
  m.safety.permitted = 0;
  m.run(2);
  EXPECT_FALSE(m.law.armed());
  EXPECT_NEAR(m.law.setpoint_rad()[0], 0.4, 1e-6);
  m.safety.permitted = 1;
  auto before = m.law.setpoint_rad();
  for (int i = 0; i < 1000; ++i) {
    m.step();
    for (int j = 0; j < 2; ++j)
      EXPECT_LE(std::fabs(m.law.setpoint_rad()[j] - before[j]), m.law.params.speed_radps * kDt + 1e-12);
    before = m.law.setpoint_rad();
  }
  EXPECT_TRUE(m.law.armed());
}

TEST(HeadLaw, StaysWithinItsJointsLimits) {
  Model m;
  m.ball_m = {0.3, 1.7, 1.5};
  m.law.track.add(m.now(), m.ball_m);
  for (int i = 0; i < 3000; ++i) {
    m.step();
    EXPECT_LE(m.law.setpoint_rad()[0], m.law.params.pan_most_rad);
    EXPECT_GE(m.law.setpoint_rad()[1], m.law.params.tilt_least_rad);
  }
}

// ---- below a vehicle

/// A head below a vehicle that flies past over a ball at 0.5 m/s: the estimate is the base's.
struct Overflight {
  HeadLaw law;
  std::array<double, 2> q{0, 0.3}, v{};
  double t = 1, beside_m, joints_every_s = 0.01;
  bool speeds = true;
  std::deque<msg::BallSighting> on_the_way;
  msg::JointState joints;
  double worst_rad = 0;

  explicit Overflight(double beside) : beside_m(beside) {
    law.params.imu_on_base = 1;
    law.track.params.below = 1;
    law.params.pan_least_rad = -2.7, law.params.pan_most_rad = 2.7;
    law.params.tilt_least_rad = -0.5, law.params.tilt_most_rad = 1.9;
    law.params.speed_radps = 2.5;
    joints.count = 2;
  }
  Time now() const { return {static_cast<std::int64_t>(t * 1e9)}; }
  Vec3 ball() const { return {2 - 0.5 * (t - 1), beside_m, -1.3}; }
  Quat head() const { return Quat::from_axis_angle({0, 0, 1}, q[0]) * Quat::from_axis_angle({0, 1, 0}, q[1]); }
  void step() {
    constexpr double kStep = 0.004;
    t += kStep;
    for (int i = 0; i < 2; ++i) {
      v[i] = std::clamp((law.setpoint_rad()[i] - q[i]) / 0.05, -2.5, 2.5);
      q[i] += kStep * v[i];
    }
    msg::NavState nav;
    nav.stamp = now();
    nav.q_world_base = msg::Quat{1, 0, 0, 0};
    nav.attitude_valid = 1;
    if (msg::seconds(now() - joints.stamp) >= joints_every_s) {
      joints.stamp = now();
      joints.position_rad = {q[0], q[1]};
      joints.velocity_radps = {speeds ? v[0] : math::kNan, speeds ? v[1] : math::kNan};
    }
    const Vec3 d = math::normalized((head() * law.params.q_head_optical).conjugate().rotate(ball()));
    const bool seen = d.z > 0.8;
    if (static_cast<int>(t * 250) % 8 == 0) {
      msg::BallSighting s;
      s.stamp = now();
      s.found = seen, s.confidence = 0.9, s.angular_radius_rad = 0.1;
      s.direction_optical = d.to<msg::Vec3>();
      on_the_way.push_back(s);
    }
    for (; !on_the_way.empty() && now() - on_the_way.front().stamp > 30ms; on_the_way.pop_front())
      law.add(on_the_way.front());
    law.step(now(), nav, joints, kStep);
    if (t > 2) worst_rad = std::max(worst_rad, std::acos(std::clamp(d.z, -1.0, 1.0)));
  }
  void run(double seconds) {
    for (const double end = t + seconds; t < end;) step();
  }
};

TEST(HeadLaw, ABallThatPassesStraightBelowStaysInThePicture) {
  for (const double beside : {0.0, 0.01, -0.05, 0.2, -0.5}) {
    Overflight flight(beside);
    flight.run(4.8);
    EXPECT_EQ(flight.law.state().mode, HeadMode::follow) << beside;
    EXPECT_LT(flight.worst_rad, 0.3) << beside << ": half of the picture's height is 0.56";
  }
}

TEST(HeadLaw, WithoutThePassageBelowItTurnsRoundAndLosesTheBall) {
  Overflight flight(0.01);
  flight.law.params.tilt_most_rad = 1.5;
  flight.law.track.params.below = 0;
  flight.run(4.8);
  EXPECT_GT(flight.worst_rad, 0.3);
}

TEST(HeadLaw, JointsThatTellPositionsAloneAndSeldomAreEnough) {
  Overflight flight(0.2);
  flight.speeds = false;
  flight.joints_every_s = 0.05;
  flight.run(4.8);
  EXPECT_EQ(flight.law.state().mode, HeadMode::follow);
  EXPECT_LT(flight.worst_rad, 0.3);
}

TEST(HeadLaw, JointsThatTellFiveTimesASecondAreModelledBetween) {
  double worst_rad[2];
  for (const bool modelled : {false, true}) {
    Overflight flight(0.2);
    flight.speeds = false;
    flight.joints_every_s = 0.2;
    if (modelled) flight.law.params.joints_lag_s = 0.05;
    flight.run(4.8);
    worst_rad[modelled] = flight.worst_rad;
  }
  EXPECT_LT(worst_rad[true], 0.3);
  EXPECT_LT(worst_rad[true], 0.8 * worst_rad[false]);
}

// ---- the module

struct Rig {
  HeadFollower follower;
  rt::ModuleRig rig{follower};
  msg::NavState nav;
  msg::JointState joints;
  Rig() {
    nav.stamp = joints.stamp = Time{1'000'000};
    nav.attitude_valid = 1;
    joints.count = 2;
    joints.position_rad = {0.2, 0.1};
  }
  rt::StepStatus step() {
    rig.put("state", nav);
    rig.put("joints", joints);
    return rig.step(Time{2'000'000}, 1ms);
  }
};

TEST(HeadFollower, CommandsTwoPositionsWithTheStampOfTheEstimate) {
  Rig r;
  ASSERT_EQ(r.step(), rt::StepStatus::ok);
  const auto* c = r.rig.get<msg::ActuatorCommand>("command");
  ASSERT_NE(c, nullptr);
  EXPECT_EQ(c->count, 2u);
  EXPECT_EQ(c->stamp, r.nav.stamp);
  EXPECT_EQ(c->armed, 1u) << "nobody's permission is asked for";
}

TEST(HeadFollower, OldOrUnusableInputsGiveNoCommand) {
  const auto status = [](auto change) {
    Rig r;
    change(r);
    return r.step();
  };
  EXPECT_EQ(status([](Rig& r) { r.nav.attitude_valid = 0; }), rt::StepStatus::stale);
  EXPECT_EQ(status([](Rig& r) { r.joints.stamp = Time{-30'000'000}; }), rt::StepStatus::stale);
  EXPECT_EQ(status([](Rig& r) { r.joints.position_rad[0] = math::kInf; }), rt::StepStatus::fault);
  EXPECT_EQ(status([](Rig& r) { r.joints.velocity_radps[0] = 1e9; }), rt::StepStatus::fault);
  EXPECT_EQ(status([](Rig& r) { r.joints.count = 3; }), rt::StepStatus::fault);
  EXPECT_EQ(status([](Rig& r) { r.nav.q_world_base.w = 5; }), rt::StepStatus::fault);
  EXPECT_EQ(status([](Rig& r) { r.nav.gyro_radps.x = math::kInf; }), rt::StepStatus::fault);
}

TEST(HeadFollower, AJointThatIsPoweredUpLaterIsWaitedFor) {
  Rig r;
  r.joints.position_rad[1] = math::kNan;
  for (int i = 0; i < 100; ++i) ASSERT_EQ(r.step(), rt::StepStatus::stale) << "faults in a row would stop the module";
  EXPECT_EQ(r.rig.get<msg::ActuatorCommand>("command"), nullptr);
  r.joints.position_rad[1] = 0.1;
  EXPECT_EQ(r.step(), rt::StepStatus::ok);
}

}  // namespace
}  // namespace sinew::control::head_law_test
