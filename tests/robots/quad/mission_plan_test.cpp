#include "robots/quad/mission_plan.hpp"

#include <gmock/gmock.h>

namespace sinew::control::mission_plan_test {
namespace {

using math::Vec3;
using msg::FlightMode;
using msg::MissionPhase;
using ::testing::ElementsAre;

/// A vehicle that follows the reference exactly, until the test changes that.
struct Follower {
  MissionPlan plan;
  msg::NavState nav;
  std::int64_t now_ns = 0;
  bool pad_in_sight = true;
  std::vector<MissionPhase> phases;

  Follower() {
    nav.attitude_valid = nav.height_valid = nav.position_valid = nav.ground_seen = 1;
    nav.p_world_m.z = nav.height_m = 0.12;
    nav.pad_world_m = {0.7, -0.4, 0};
  }
  void step() {
    now_ns += 5'000'000;
    nav.stamp = {now_ns};
    if (pad_in_sight && nav.height_m > 0.8) {
      nav.pad_known = 1;
      nav.pad_stamp = nav.stamp;
    }
    plan.step({now_ns}, nav, 0.005);
    if (phases.empty() || phases.back() != plan.state().phase) phases.push_back(plan.state().phase);
    follow(plan.setpoint());
  }
  void follow(const msg::FlightSetpoint& s) {
    nav.v_world_mps = {};
    if (!s.armed || s.mode == FlightMode::idle || !nav.position_valid) return;
    if (s.mode == FlightMode::position) nav.p_world_m = s.p_world_m;
    nav.v_world_mps = s.v_world_mps;
    if (s.mode == FlightMode::velocity) nav.p_world_m.z += 0.005 * s.v_world_mps.z;
    if (nav.p_world_m.z <= 0.12) {
      nav.p_world_m.z = 0.12;
      nav.v_world_mps = {};
    }
    nav.height_m = nav.p_world_m.z;
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 200); ++i) step();
  }
  bool run_to(MissionPhase phase, double limit_s = 60) {
    for (int i = 0; i < static_cast<int>(limit_s * 200) && plan.state().phase != phase; ++i) step();
    return plan.state().phase == phase;
  }
};

TEST(MissionPlan, FliesItsPhasesInOrder) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::done));
  EXPECT_THAT(f.phases, ElementsAre(MissionPhase::wait, MissionPhase::arm, MissionPhase::climb, MissionPhase::search,
                                    MissionPhase::approach, MissionPhase::hold, MissionPhase::descend,
                                    MissionPhase::touchdown, MissionPhase::done));
  EXPECT_NEAR(f.nav.p_world_m.x, 0.7, 0.02);
  EXPECT_NEAR(f.nav.p_world_m.y, -0.4, 0.02);
  EXPECT_FALSE(f.plan.setpoint().armed);
}

TEST(MissionPlan, NeverArmsWithoutAValidEstimate) {
  Follower f;
  f.nav.position_valid = 0;
  for (int i = 0; i < 20000; ++i) {
    f.step();
    ASSERT_FALSE(f.plan.setpoint().armed);
  }
  EXPECT_THAT(f.phases, ElementsAre(MissionPhase::wait));
}

TEST(MissionPlan, EstimateThatFlickersDoesNotArm) {
  Follower f;
  for (int i = 0; i < 20000; ++i) {
    f.nav.position_valid = i % 200 != 0;  // never longer than a second
    f.step();
    ASSERT_FALSE(f.plan.setpoint().armed);
  }
}

TEST(MissionPlan, EstimateLostInFlightAbortsAndDisarms) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::search));
  f.nav.position_valid = f.nav.height_valid = 0;
  ASSERT_TRUE(f.run_to(MissionPhase::abort, 0.5));
  f.step();
  EXPECT_TRUE(f.plan.setpoint().armed);
  EXPECT_EQ(f.plan.setpoint().mode, FlightMode::velocity);
  EXPECT_LT(f.plan.setpoint().v_world_mps.z, 0);
  ASSERT_TRUE(f.run_to(MissionPhase::done, f.plan.params.blind_s + 1));
  EXPECT_FALSE(f.plan.setpoint().armed);
}

TEST(MissionPlan, AbortWithAPositionSinksToTheGroundBeforeItDisarms) {
  Follower f;
  f.pad_in_sight = false;
  f.plan.params.timeout_s = 8;
  ASSERT_TRUE(f.run_to(MissionPhase::abort));
  ASSERT_TRUE(f.run_to(MissionPhase::done));
  EXPECT_NEAR(f.nav.height_m, 0.12, 1e-9);
}

TEST(MissionPlan, SearchWidensUntilThePadIsSeen) {
  Follower f;
  f.pad_in_sight = false;
  ASSERT_TRUE(f.run_to(MissionPhase::search));
  double widest = 0;
  for (int i = 0; i < 200 * 25; ++i) {
    f.step();
    widest = std::max({widest, math::fabs(f.nav.p_world_m.x), math::fabs(f.nav.p_world_m.y)});
  }
  EXPECT_GT(widest, 1.5);
  EXPECT_LE(widest, f.plan.params.search_radius_m + 0.1);
  f.pad_in_sight = true;
  EXPECT_TRUE(f.run_to(MissionPhase::done));
}

TEST(MissionPlan, PadNeverSeenEndsInAnAbortOnTheGround) {
  Follower f;
  f.pad_in_sight = false;
  ASSERT_TRUE(f.run_to(MissionPhase::done, 200));
  EXPECT_THAT(f.phases, ElementsAre(MissionPhase::wait, MissionPhase::arm, MissionPhase::climb, MissionPhase::search,
                                    MissionPhase::abort, MissionPhase::done));
  EXPECT_NEAR(f.nav.height_m, 0.12, 1e-9);
}

TEST(MissionPlan, PadLostHighUpGoesBackToTheSearchHeight) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::descend));
  f.pad_in_sight = false;
  ASSERT_TRUE(f.run_to(MissionPhase::search, 5));
  f.run(4);
  EXPECT_GT(f.nav.height_m, f.plan.params.search_height_m - 0.1);
  f.pad_in_sight = true;
  EXPECT_TRUE(f.run_to(MissionPhase::done));
}

TEST(MissionPlan, PadOutOfSightCloseToTheGroundIsNoReasonToStop) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::descend));
  while (f.nav.height_m > f.plan.params.commit_below_m) f.step();
  f.pad_in_sight = false;
  ASSERT_TRUE(f.run_to(MissionPhase::done));
  EXPECT_EQ(f.phases.back(), MissionPhase::done);
  EXPECT_EQ(f.phases[f.phases.size() - 2], MissionPhase::touchdown);
}

TEST(MissionPlan, SinkingPausesWhileOffThePad) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::descend));
  f.run(0.5);
  for (int i = 0; i < 200; ++i) {
    f.nav.p_world_m.x = 0.7 + 0.6;  // a gust holds it off
    f.nav.v_world_mps = {};
    f.now_ns += 5'000'000;
    f.nav.stamp = f.nav.pad_stamp = {f.now_ns};
    f.plan.step({f.now_ns}, f.nav, 0.005);
    ASSERT_EQ(f.plan.setpoint().v_world_mps.z, 0);
  }
}

TEST(MissionPlan, GroundIsFeltWhereTheHeightIsWrong) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::descend));
  f.run(0.5);
  const double stuck_at = f.nav.p_world_m.z;  // it stands on something, and the height does not say so
  int steps = 0;
  while (f.plan.state().phase == MissionPhase::descend && steps < 2000) {
    f.step();
    f.nav.p_world_m.z = f.nav.height_m = stuck_at;
    f.nav.v_world_mps = {};
    ++steps;
  }
  EXPECT_EQ(f.plan.state().phase, MissionPhase::touchdown);
  EXPECT_GT(steps, 200 * f.plan.params.stuck_high_s * 0.9);
}

TEST(MissionPlan, WhatFloatsForSecondsBeforeItSinksIsNotOnTheGround) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::descend));
  f.run(0.5);
  const double floats_at = f.nav.p_world_m.z;
  for (int i = 0; i < 800; ++i) {
    f.step();
    f.nav.p_world_m.z = f.nav.height_m = floats_at;
    f.nav.v_world_mps = {};
    ASSERT_EQ(f.plan.state().phase, MissionPhase::descend);
  }
  EXPECT_TRUE(f.run_to(MissionPhase::done));
}

TEST(MissionPlan, AHeightThatNoRangeFinderMeasuresStopsNoMotorInTheAir) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::search));
  f.plan.set_safety({true, msg::FailsafeAction::land});
  f.nav.ground_seen = 0;
  const double above = 0.4;  // of what the barometer believes
  f.nav.p_world_m.z = 0.7;
  while (f.nav.p_world_m.z > 0.125) {
    f.step();
    f.nav.height_m = f.nav.p_world_m.z - above;
    f.nav.v_world_mps.z = -0.1;  // and slower than it is
    ASSERT_EQ(f.plan.state().phase, MissionPhase::abort) << f.nav.p_world_m.z;
  }
}

TEST(MissionPlan, GroundIsFeltThoughTheEstimateRisesAndTheVehicleRocks) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::search));
  f.plan.set_safety({true, msg::FailsafeAction::land});
  f.nav.ground_seen = 0;
  for (int i = 0; i < 600; ++i) {
    f.step();
    f.nav.p_world_m.z = f.nav.height_m = 0.5;
    f.nav.v_world_mps.z = i % 40 < 10 ? -0.2 : 0.1;
  }
  EXPECT_EQ(f.plan.state().phase, MissionPhase::done);
}

TEST(MissionPlan, WithoutTheRangeFinderItSinksSlowlyFromHigherUp) {
  Follower f;
  const MissionParams& p = f.plan.params;
  ASSERT_TRUE(f.run_to(MissionPhase::search));
  f.plan.set_safety({true, msg::FailsafeAction::land});
  for (const bool seen : {true, false})
    for (const double height : {p.slow_below_m + 0.1, p.slow_below_m + p.slow_unseen_m + 0.1}) {
      f.nav.ground_seen = seen;
      f.nav.p_world_m.z = f.nav.height_m = height;
      f.step();
      const bool fast = seen || height > p.slow_below_m + p.slow_unseen_m;
      EXPECT_EQ(f.plan.setpoint().v_world_mps.z, fast ? -p.sink_fast_mps : -p.sink_slow_mps) << seen << ' ' << height;
    }
}

TEST(MissionPlan, OnTheGroundItDoesNotClimbAgainBecauseItSeesNoPad) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::descend));
  f.run(0.5);
  f.pad_in_sight = false;
  for (int i = 0; i < 2000 && f.plan.state().phase == MissionPhase::descend; ++i) {
    f.step();
    f.nav.p_world_m.z = f.nav.height_m = 0.7;  // half a metre more than there is
    f.nav.v_world_mps = {};
  }
  EXPECT_EQ(f.plan.state().phase, MissionPhase::touchdown);
}

TEST(MissionPlan, AClimbThatGetsNowhereIsAborted) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::climb));
  for (double s = 0; s < f.plan.params.climb_limit_s + 0.1; s += 0.005) {
    f.step();
    f.nav.p_world_m.z = f.nav.height_m = 0.5;
  }
  EXPECT_EQ(f.plan.state().phase, MissionPhase::abort);
}

TEST(MissionPlan, WhatNeverSettlesAboveThePadDescendsInTheEnd) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::hold));
  for (double s = 0; s < f.plan.params.hold_limit_s - 0.1; s += 0.005) {
    f.step();
    f.nav.v_world_mps.z = 0.3;
    ASSERT_EQ(f.plan.state().phase, MissionPhase::hold);
  }
  f.run(0.2);
  EXPECT_EQ(f.plan.state().phase, MissionPhase::descend);
}

TEST(MissionPlan, WhatFallsDoesNotGoOnClimbing) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::climb));
  f.run(1);
  f.nav.v_world_mps.z = -1.4;
  f.step();
  EXPECT_EQ(f.plan.state().phase, MissionPhase::climb);
  f.nav.v_world_mps.z = -1.6;
  f.step();
  EXPECT_EQ(f.plan.state().phase, MissionPhase::abort);
}

TEST(MissionPlan, AnAbortEndsWhateverTheEstimateSays) {
  Follower f;
  ASSERT_TRUE(f.run_to(MissionPhase::search));
  f.plan.set_safety({true, msg::FailsafeAction::land});
  for (double s = 0; s < f.plan.params.abort_limit_s + 0.1; s += 0.005) {
    f.step();
    f.nav.p_world_m.z = f.nav.height_m = 2;
    f.nav.v_world_mps.z = -8;  // sinks, and never gets lower
  }
  EXPECT_EQ(f.plan.state().phase, MissionPhase::done);
  EXPECT_FALSE(f.plan.setpoint().armed);
}

constexpr MissionSafety kLand{true, msg::FailsafeAction::land}, kNotPermitted{false, msg::FailsafeAction::none},
    kStopped{false, msg::FailsafeAction::stop};

TEST(MissionPlan, WaitsForThePermissionToArm) {
  Follower f;
  f.plan.set_safety(kNotPermitted);
  for (int i = 0; i < 2000; ++i) {
    f.step();
    ASSERT_FALSE(f.plan.setpoint().armed);
  }
  f.plan.set_safety({});
  EXPECT_TRUE(f.run_to(MissionPhase::done));
}

TEST(MissionPlan, APermissionThatEndsBeforeTheClimbMeansWaitingAgain) {
  for (const MissionSafety& safety : {kNotPermitted, kLand, kStopped}) {
    Follower f;
    ASSERT_TRUE(f.run_to(MissionPhase::arm));
    f.plan.set_safety(safety);
    f.run(3);
    EXPECT_EQ(f.plan.state().phase, MissionPhase::wait);
    EXPECT_FALSE(f.plan.setpoint().armed);
    f.plan.set_safety({});
    EXPECT_TRUE(f.run_to(MissionPhase::done));
  }
}

class LandWhereItIs : public ::testing::TestWithParam<MissionPhase> {};

TEST_P(LandWhereItIs, ComesDownAndDisarmsWhateverItWasDoing) {
  Follower f;
  ASSERT_TRUE(f.run_to(GetParam()));
  f.run(0.3);
  const Vec3 from(f.nav.p_world_m);
  f.plan.set_safety(kLand);
  f.step();
  EXPECT_EQ(f.plan.state().phase, MissionPhase::abort);
  f.plan.set_safety({});  // that the cause vanishes changes nothing
  ASSERT_TRUE(f.run_to(MissionPhase::done, 30));
  EXPECT_NEAR(f.nav.p_world_m.x, from.x, 1e-9);
  EXPECT_NEAR(f.nav.height_m, 0.12, 1e-9);
  EXPECT_FALSE(f.plan.setpoint().armed);
}
INSTANTIATE_TEST_SUITE_P(MissionPlan, LandWhereItIs,
                         ::testing::Values(MissionPhase::climb, MissionPhase::search, MissionPhase::approach,
                                           MissionPhase::hold, MissionPhase::descend));

TEST(MissionPlan, AStoppedFlightIsOver) {
  for (const MissionSafety& safety : {kNotPermitted, kStopped}) {
    Follower f;
    ASSERT_TRUE(f.run_to(MissionPhase::search));
    f.plan.set_safety(safety);
    f.step();
    EXPECT_EQ(f.plan.state().phase, MissionPhase::done);
    EXPECT_FALSE(f.plan.setpoint().armed);
    f.plan.set_safety({});
    f.run(5);
    EXPECT_EQ(f.plan.state().phase, MissionPhase::done) << "it does not start again by itself";
  }
}

TEST(MissionPlan, ReferenceKeepsItsSpeedAndAcceleration) {
  Follower f;
  Vec3 before_p, before_v;
  bool has = false;
  const MissionParams& p = f.plan.params;
  while (f.plan.state().phase != MissionPhase::descend && f.now_ns < 60'000'000'000) {
    f.step();
    const msg::FlightSetpoint& s = f.plan.setpoint();
    if (s.mode != FlightMode::position) continue;
    const Vec3 now_p(s.p_world_m), now_v(s.v_world_mps);
    if (has) {
      ASSERT_LT(norm(now_p - before_p), 0.005 * (p.speed_mps + p.climb_mps) + 0.011) << f.now_ns;
      ASSERT_LE(math::hypot(now_v.x, now_v.y), p.speed_mps + 1e-9);
    }
    before_p = now_p;
    before_v = now_v;
    has = true;
  }
  EXPECT_TRUE(has);
}

// ---- with a mate

TEST(MissionPlan, WaitsOnTheGroundUntilTheMateAheadHasLanded) {
  Follower f;
  MissionPhase ahead = MissionPhase::descend;
  for (int i = 0; i < 4000; ++i) f.plan.set_ahead(&ahead, 0.005), f.step();
  EXPECT_EQ(f.plan.state().phase, MissionPhase::wait);
  ahead = MissionPhase::done;
  for (int i = 0; i < 200; ++i) f.plan.set_ahead(&ahead, 0.005), f.step();
  EXPECT_GE(f.plan.state().phase, MissionPhase::arm);
}

TEST(MissionPlan, GoesOnWhenTheMateAheadIsNotHeardForLong) {
  Follower f;
  const MissionPhase ahead = MissionPhase::search;
  for (int i = 0; i < 1000; ++i) f.plan.set_ahead(&ahead, 0.005), f.step();
  int steps = 0;
  for (; f.plan.state().phase == MissionPhase::wait && steps < 4000; ++steps)
    f.plan.set_ahead(nullptr, 0.005), f.step();
  EXPECT_NEAR(steps * 0.005, f.plan.params.ahead_silent_s, 0.02);
}

TEST(MissionPlan, SearchesWhereAMateHasSeenThePad) {
  Follower f;
  f.pad_in_sight = false;
  f.plan.set_told_pad({1.5, -1.0, 0});
  while (f.plan.state().phase != MissionPhase::search && f.now_ns < 30'000'000'000) f.step();
  double nearest_m = 10;
  for (int i = 0; i < 1000; ++i) {
    f.step();
    nearest_m = std::min(nearest_m, math::hypot(f.nav.p_world_m.x - 1.5, f.nav.p_world_m.y + 1.0));
  }
  EXPECT_LT(nearest_m, 0.02) << "before it goes on around that place";
}

TEST(MissionPlan, LandsBesideThePadWhereItIsTold) {
  Follower f;
  f.plan.params.land_x_m = 0.2;
  f.plan.params.land_y_m = -0.5;
  while (f.plan.state().phase != MissionPhase::done && f.now_ns < 90'000'000'000) f.step();
  EXPECT_NEAR(f.nav.p_world_m.x, 0.7 + 0.2, 0.02);
  EXPECT_NEAR(f.nav.p_world_m.y, -0.4 - 0.5, 0.02);
}

}  // namespace
}  // namespace sinew::control::mission_plan_test
