// The law in a closed loop with a vehicle whose velocity lags, in wind, and a head that looks at the target.
#include "robots/air_robot/steer_to_law.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "math/random.hpp"
#include "robots/air_robot/steer_to.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::air_robot::steer_to_law_test {
namespace {

using math::Quat;
using math::Vec3;
using msg::HeadMode;
using msg::MissionPhase;
using msg::Time;
using namespace std::chrono_literals;

constexpr double kDt = 0.004;

struct Model {
  SteerToLaw law;
  Vec3 p{0, 0, 0.12}, v, target{4, 2, 0.25}, target_mps, wind_mps;
  double yaw = 0.5, turn = 0, t = 1, noise_rad = 0;
  HeadMode mode = HeadMode::follow;
  msg::SafetyState safety;
  math::Random random{7};

  Model() {
    safety.permitted = 1;
    law.params.camera_x_m = 0.14, law.params.camera_z_m = -0.05;
  }
  Time now() const { return {static_cast<std::int64_t>(t * 1e9)}; }
  Quat base() const { return Quat::from_axis_angle({0, 0, 1}, yaw); }
  double over_m() const { return std::hypot(target.x - p.x, target.y - p.y); }
  void step() {
    t += kDt;
    target += kDt * target_mps;
    const Vec3 wanted = base().rotate(law.velocity_mps());
    v += (kDt / 0.2) * (wanted - v) + (kDt * 0.35) * wind_mps;
    p += kDt * v;
    p.z = std::max(p.z, 0.12);
    turn += (kDt / 0.2) * (law.turn_radps() - turn);
    yaw += kDt * turn;
    msg::NavState nav;
    nav.stamp = now();
    nav.q_world_base = base().to<msg::Quat>();
    nav.p_world_m = p.to<msg::Vec3>();
    nav.height_m = p.z;
    const Vec3 d = target - (p + base().rotate({0.14, 0, -0.05}));
    msg::HeadState head;
    head.stamp = now();
    head.mode = mode;
    head.azimuth_rad = std::atan2(d.y, d.x) + noise_rad * random.normal();
    head.elevation_rad = std::atan2(d.z, std::hypot(d.x, d.y)) + noise_rad * random.normal();
    law.set_safety(safety);
    law.step(now(), nav, head, kDt);
  }
  void run(double seconds) {
    for (const double end = t + seconds; t < end;) step();
  }
  double worst_over_m(double seconds) {
    double worst = 0;
    for (const double end = t + seconds; t < end;) {
      step();
      worst = std::max(worst, over_m());
    }
    return worst;
  }
};

TEST(SteerToLaw, FliesOverATargetThatStandsAndStays) {
  Model m;
  m.run(15);
  EXPECT_EQ(m.law.mission().phase, MissionPhase::hold);
  EXPECT_LT(m.worst_over_m(10), 0.05);
  EXPECT_EQ(m.law.mission().phase, MissionPhase::done) << "over the target for long enough: it stays there";
  EXPECT_LT(m.worst_over_m(5), 0.05);
  EXPECT_NEAR(m.p.z, 1.6, 0.05);
}

TEST(SteerToLaw, LearnsWindAndATargetThatMoves) {
  Model still, windy;
  for (Model* m : {&still, &windy}) m->target_mps = {0.15, -0.1, 0}, m->wind_mps = {-1, 1.5, 0};
  still.law.params.learn_per_s2 = 0;
  for (Model* m : {&still, &windy}) m->run(25);
  EXPECT_LT(windy.worst_over_m(5), 0.05);
  EXPECT_GT(still.worst_over_m(5), 0.2) << "without learning it hangs behind";
}

TEST(SteerToLaw, ATargetBehindIsTurnedTo) {
  Model m;
  m.target = {-4, 0.5, 0.25};
  m.run(15);
  EXPECT_LT(m.worst_over_m(3), 0.1);
}

TEST(SteerToLaw, NoisyDirectionsFarAwayDoNotMatterOverTheTarget) {
  Model m;
  m.noise_rad = 0.02;
  m.run(20);
  EXPECT_LT(m.worst_over_m(10), 0.15);
}

TEST(SteerToLaw, VelocitiesStayWithinTheirLimitsAndChangeSlowly) {
  Model m;
  Vec3 before;
  for (int i = 0; i < 5000; ++i) {
    m.step();
    const Vec3 now = m.law.velocity_mps(), change = now - before;
    EXPECT_LE(std::hypot(now.x, now.y), m.law.params.speed_mps + m.law.params.learn_most_mps + 1e-9);
    EXPECT_LE(std::hypot(change.x, change.y), m.law.params.accel_mps2 * kDt + 1e-9);
    EXPECT_LE(std::fabs(now.z), m.law.params.climb_mps + 1e-9);
    before = now;
  }
}

TEST(SteerToLaw, WithoutATargetItHoversAndGoesOnWhenTheHeadHasIt) {
  Model m;
  m.mode = HeadMode::search;
  m.run(8);
  EXPECT_EQ(m.law.mission().phase, MissionPhase::search);
  EXPECT_LT(std::hypot(m.p.x, m.p.y), 0.01);
  m.mode = HeadMode::follow;
  m.run(3);
  EXPECT_EQ(m.law.mission().phase, MissionPhase::approach);
  m.mode = HeadMode::search;
  m.run(2);
  EXPECT_EQ(m.law.mission().phase, MissionPhase::search);
  EXPECT_LT(std::hypot(m.v.x, m.v.y), 0.05) << "it does not fly on blindly";
}

TEST(SteerToLaw, ATargetAtTheHorizonIsFarAndNoNumberOverflows) {
  Model m;
  m.target = {500, 0, 0.25};
  m.run(6);
  EXPECT_TRUE(math::is_finite(m.law.velocity_mps()));
  EXPECT_LE(math::hypot(m.law.target_heading_m().x, m.law.target_heading_m().y), m.law.params.farthest_m + 1);
}

TEST(SteerToLaw, LandsWhereItIsWhenAFailsafeAsksForIt) {
  Model m;
  m.run(6);
  m.safety.action = msg::FailsafeAction::land;
  m.run(6);
  EXPECT_EQ(m.law.mission().phase, MissionPhase::done);
  EXPECT_EQ(m.p.z, 0.12) << "on the ground, not just above it";
}

TEST(SteerToLaw, DoesNotTakeOffWithoutPermission) {
  Model m;
  m.safety.permitted = 0;
  m.run(3);
  EXPECT_EQ(m.law.mission().phase, MissionPhase::wait);
  EXPECT_EQ(m.p.z, 0.12);
}

// ---- the module

TEST(SteerTo, OldOrUnusableInputsGiveNoCommand) {
  const auto status = [](auto change) {
    SteerTo steer;
    rt::ModuleRig rig{steer};
    msg::NavState nav;
    msg::HeadState head;
    nav.stamp = head.stamp = Time{1'000'000'000};
    nav.attitude_valid = nav.height_valid = 1;
    change(nav, head);
    rig.put("state", nav);
    rig.put("head", head);
    return rig.step(Time{1'010'000'000}, 4ms);
  };
  using N = msg::NavState;
  using H = msg::HeadState;
  EXPECT_EQ(status([](N&, H&) {}), rt::StepStatus::ok);
  EXPECT_EQ(status([](N& n, H&) { n.attitude_valid = 0; }), rt::StepStatus::stale);
  EXPECT_EQ(status([](N& n, H&) { n.height_valid = 0; }), rt::StepStatus::stale);
  EXPECT_EQ(status([](N& n, H&) { n.stamp = Time{1}; }), rt::StepStatus::stale);
  EXPECT_EQ(status([](N&, H& h) { h.stamp = Time{1}; }), rt::StepStatus::stale);
  EXPECT_EQ(status([](N& n, H&) { n.q_world_base.w = 4; }), rt::StepStatus::fault);
  EXPECT_EQ(status([](N& n, H&) { n.p_world_m.z = math::kNan; }), rt::StepStatus::fault);
  EXPECT_EQ(status([](N&, H& h) { h.elevation_rad = math::kInf; }), rt::StepStatus::fault);
}

}  // namespace
}  // namespace sinew::air_robot::steer_to_law_test
