// The learned landing: what it makes of sightings, its policy's text, and who flies when.
#include <gtest/gtest.h>

#include "robots/quad/learned_landing.hpp"
#include "robots/quad/mission_plan.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::control::landing_test {
namespace {

using namespace std::chrono_literals;
using math::Vec3;

constexpr std::int64_t kPictureNs = 33'333'250;

/// A vehicle that looks at the pad in the origin, and its exact sightings.
struct Vehicle {
  Vec3 p{0.5, -0.3, 2}, v, gyro;
  math::Quat q;
  std::int64_t now_ns = 0;
  bool sees = true;

  msg::NavState nav() const {
    msg::NavState n;
    n.stamp = {now_ns};
    n.attitude_valid = n.height_valid = n.position_valid = 1;
    n.q_world_base = q.to<msg::Quat>();
    n.v_world_mps = v.to<msg::Vec3>();
    n.gyro_radps = gyro.to<msg::Vec3>();
    n.p_world_m = p.to<msg::Vec3>();
    n.height_m = p.z;
    return n;
  }
  msg::PadSighting sighting() const {
    msg::PadSighting s;
    s.stamp = {now_ns};
    s.range_m = math::kNan;
    if (!sees) return s;
    const LandingViewParams params;
    const Vec3 to_pad = Vec3{} - p, d = (q * params.q_base_optical).conjugate().rotate(to_pad / math::norm(to_pad));
    s.found = 1;
    s.confidence = 0.9;
    s.direction_optical = d.to<msg::Vec3>();
    s.range_m = math::norm(to_pad);
    return s;
  }
  void fly(LandingView& view, int pictures) {
    for (int i = 0; i < pictures; ++i) {
      now_ns += kPictureNs;
      p += v * (1e-9 * kPictureNs);
      view.see(sighting(), nav());
    }
  }
};

TEST(LandingView, FindsOffsetHeightAndTheirRates) {
  Vehicle vehicle;
  vehicle.v = {-0.2, 0.1, -0.3};
  LandingView view;
  vehicle.fly(view, 60);
  ASSERT_TRUE(view.known());
  EXPECT_FALSE(view.blind());
  EXPECT_NEAR(view.offset_m(0), -vehicle.p.x, 1e-3);
  EXPECT_NEAR(view.offset_m(1), -vehicle.p.y, 1e-3);
  EXPECT_NEAR(view.offset_mps(0), 0.2, 1e-3);
  EXPECT_NEAR(view.offset_mps(1), -0.1, 1e-3);
  EXPECT_NEAR(view.height_m(), vehicle.p.z, 1e-3);
  EXPECT_NEAR(view.height_mps(), -0.3, 1e-3);
}

TEST(LandingView, LeaningDoesNotLookLikeMoving) {
  Vehicle vehicle;
  LandingView view;
  vehicle.fly(view, 10);
  vehicle.q = math::Quat::from_yaw_pitch_roll({0.6, 0.2, -0.1});
  vehicle.fly(view, 1);
  EXPECT_NEAR(view.offset_m(0), -0.5, 1e-6);
  EXPECT_NEAR(view.offset_m(1), 0.3, 1e-6);
  EXPECT_NEAR(view.offset_mps(0), 0, 1e-6);
}

TEST(LandingView, TurnsTheAttitudeBackToTheInstantOfThePicture) {
  Vehicle vehicle;
  LandingView view;
  vehicle.fly(view, 10);
  const msg::PadSighting seen = vehicle.sighting();
  vehicle.gyro = {0.5, -0.8, 0.2};
  msg::NavState later = vehicle.nav();
  later.stamp.ns += 30'000'000;
  later.q_world_base = (vehicle.q * math::Quat::exp(vehicle.gyro * 0.03)).to<msg::Quat>();
  LandingView fresh;
  fresh.see(seen, later);
  EXPECT_NEAR(fresh.offset_m(0), -0.5, 1e-9);
  EXPECT_NEAR(fresh.offset_m(1), 0.3, 1e-9);
}

TEST(LandingView, GoesOnWithTheInertialVelocityAndThenDoesNotKnow) {
  Vehicle vehicle;
  vehicle.v = {-0.3, 0, 0};
  LandingView view;
  vehicle.fly(view, 30);
  vehicle.sees = false;
  vehicle.fly(view, 15);  // 0.5 s
  EXPECT_TRUE(view.known());
  EXPECT_NEAR(view.offset_m(0), -vehicle.p.x, 0.01);
  vehicle.fly(view, 10);
  EXPECT_FALSE(view.known());
}

TEST(LandingView, BelowHalfAMetreThePictureIsNotUsed) {
  Vehicle vehicle;
  vehicle.p = {0.1, 0, 0.7};
  vehicle.v = {0, 0, -0.3};
  LandingView view;
  vehicle.fly(view, 25);  // down to 0.45 m
  ASSERT_TRUE(view.blind());
  const double before = view.offset_m(0);
  vehicle.p.x = 0.4;  // the picture would say so
  vehicle.fly(view, 20);
  EXPECT_TRUE(view.known());
  EXPECT_NEAR(view.offset_m(0), before, 1e-9);
  EXPECT_NEAR(view.height_m(), vehicle.p.z, 0.01);
  vehicle.v.z = 0.5;
  vehicle.fly(view, 40);  // up again
  EXPECT_FALSE(view.blind());
}

TEST(LandingView, IgnoresPicturesThatAreNotNewerAndNonsense) {
  Vehicle vehicle;
  LandingView view;
  vehicle.fly(view, 20);
  const double before = view.offset_m(0);
  msg::PadSighting old = vehicle.sighting();
  vehicle.p.x = 3;
  old.range_m = 9;
  view.see(old, vehicle.nav());
  EXPECT_EQ(view.offset_m(0), before);
  msg::PadSighting odd = vehicle.sighting();
  odd.stamp.ns += kPictureNs;
  odd.range_m = math::kInf;
  view.see(odd, vehicle.nav());
  EXPECT_NEAR(view.offset_m(0), before, 1e-6);
}

/// A policy that always wants this.
LandingPolicy constant(double towards_mps, double sink_mps) {
  LandingPolicy policy(LandingActions::discrete);
  const auto prefer = [](learn::QFunction& q, double action) {
    const auto columns = q.actions().at(action);
    for (std::size_t c = 0; c < q.actions().columns(); ++c)
      for (std::size_t f = 0; f < q.basis().size(); ++f) q.weights()[c * q.basis().size() + f] = columns[c];
  };
  prefer(policy.aside, towards_mps);
  prefer(policy.down, sink_mps);
  return policy;
}

TEST(LandingPolicy, LearnsOneSideAndFliesBoth) {
  Vehicle vehicle;
  LandingView view;
  vehicle.fly(view, 10);  // the pad lies at -x, +y
  const LandingWish wish = constant(0.6, 0.35).wish(view);
  EXPECT_EQ(wish.aside_mps[0], -0.6);
  EXPECT_EQ(wish.aside_mps[1], 0.6);
  EXPECT_EQ(wish.sink_mps, 0.35);
}

TEST(LandingPolicy, WeightsAreTheSameAfterATripThroughText) {
  LandingPolicy policy(LandingActions::continuous);
  double v = -3.3;
  for (double& w : policy.aside.weights()) w = double(float(v += 0.0371));
  std::vector<double> back(policy.aside.weights().size());
  EXPECT_EQ(read_weights(weights_text(policy.aside.weights()), back), "");
  EXPECT_TRUE(std::equal(back.begin(), back.end(), policy.aside.weights().begin()));
}

TEST(LandingPolicy, TextThatIsNoWeightsIsRefusedWithThePlace) {
  std::vector<double> two{7, 8};
  EXPECT_EQ(read_weights("1 2 3", two), "number 3: 2 are needed, here are more");
  EXPECT_EQ(read_weights("1", two), "2 numbers are needed, here are 1");
  EXPECT_EQ(read_weights("", two), "2 numbers are needed, here are 0");
  EXPECT_EQ(read_weights("1 2x", two), "number 2: '2x': a number such as -1.25");
  EXPECT_EQ(read_weights("1 inf", two), "number 2: 'inf': a number such as -1.25");
  EXPECT_EQ(read_weights("1 1e99", two), "number 2: '1e99': a number such as -1.25");
  EXPECT_EQ(two, (std::vector<double>{7, 8}));  // untouched
  EXPECT_EQ(read_weights(" 1\n-2.5\t", two), "");
  EXPECT_EQ(two, (std::vector<double>{1, -2.5}));
}

TEST(LandingPilot, DecidesAtSomePicturesAndKeepsTheWishBetween) {
  Vehicle vehicle;
  LandingPilot pilot;
  std::vector<bool> due;
  for (int i = 0; i < 13; ++i) {
    vehicle.now_ns += kPictureNs;
    due.push_back(pilot.see(vehicle.sighting(), vehicle.nav()));
    if (due.back()) pilot.act({{0.1, -0.2}, 0.3});
    EXPECT_EQ(pilot.velocity_mps(), (Vec3{0.1, -0.2, -0.3}));
  }
  EXPECT_EQ(std::count(due.begin(), due.end(), true), 3);
}

TEST(LandingPilot, SinksAtItsOwnSpeedWhenBlindAndHoversWhenThePadIsNotKnown) {
  Vehicle vehicle;
  vehicle.p = {0, 0, 0.45};
  LandingPilot pilot;
  vehicle.fly(pilot.view, 3);
  ASSERT_TRUE(pilot.view.blind());
  pilot.act({{0.1, 0}, 0.5});
  EXPECT_EQ(pilot.velocity_mps(), (Vec3{0.1, 0, -pilot.params.blind_sink_mps}));
  pilot.reset();
  pilot.act({{0.1, 0}, 0.5});
  EXPECT_EQ(pilot.velocity_mps(), Vec3{});
}

TEST(LearnedLanding, CommandsWhatItsPolicyWants) {
  LearnedLanding landing;
  rt::ModuleRig rig(landing);
  const LandingPolicy policy = constant(0.3, 0.2);
  rig.set("actions", std::string("discrete"));
  rig.set("aside", weights_text(policy.aside.weights()));
  rig.set("down", weights_text(policy.down.weights()));
  Vehicle vehicle;
  vehicle.now_ns = kPictureNs;
  rig.put("sighting", vehicle.sighting());
  rig.put("state", vehicle.nav());
  ASSERT_EQ(rig.step({vehicle.now_ns}, 33ms), rt::StepStatus::ok);
  const auto* guide = rig.get<msg::FlightSetpoint>("guide");
  ASSERT_NE(guide, nullptr);
  EXPECT_EQ(Vec3(guide->v_world_mps), (Vec3{-0.3, 0.3, -0.2}));
  EXPECT_EQ(guide->mode, msg::FlightMode::velocity);
  // Without a new picture there is nothing new to say.
  EXPECT_EQ(rig.step({vehicle.now_ns + 33'000'000}, 33ms), rt::StepStatus::stale);
}

TEST(LearnedLanding, AFaultySightingIsAFault) {
  LearnedLanding landing;
  rt::ModuleRig rig(landing);
  const LandingPolicy policy = constant(0.3, 0.2);
  rig.set("actions", std::string("discrete"));
  rig.set("aside", weights_text(policy.aside.weights()));
  rig.set("down", weights_text(policy.down.weights()));
  Vehicle vehicle;
  vehicle.now_ns = kPictureNs;
  msg::PadSighting s = vehicle.sighting();
  s.direction_optical.x = math::kNan;
  rig.put("sighting", s);
  rig.put("state", vehicle.nav());
  EXPECT_EQ(rig.step({vehicle.now_ns}, 33ms), rt::StepStatus::fault);
}

TEST(LearnedLanding, WithoutItsWeightsItDoesNotStartAndSaysWhy) {
  LearnedLanding landing;
  rt::ModuleRig rig(landing);
  rig.set("aside", std::string("1 2 three"));
  EXPECT_FALSE(rig.configure());
  std::string all;
  for (const rt::Problem& p : rig.problems()) all += rt::to_string(p, "quad_learned.toml") + "\n";
  EXPECT_NE(all.find("aside: number 3: 'three': a number such as -1.25"), std::string::npos) << all;
  EXPECT_NE(all.find("down: "), std::string::npos) << all;
}

/// The mission with a guide: the vehicle follows exactly.
struct Guided {
  MissionPlan plan;
  msg::NavState nav;
  std::int64_t now_ns = 0;
  std::vector<msg::MissionPhase> phases;
  Vec3 guide{0, 0, -0.3};
  bool speaks = true, sees = true;

  Guided() {
    nav.attitude_valid = nav.height_valid = nav.position_valid = nav.ground_seen = 1;
    nav.p_world_m.z = nav.height_m = 0.12;
  }
  bool run_to(msg::MissionPhase phase, double limit_s) {
    for (int i = 0; i < static_cast<int>(limit_s * 200) && plan.state().phase != phase; ++i) step();
    return plan.state().phase == phase;
  }
  void step() {
    now_ns += 5'000'000;
    nav.stamp = {now_ns};
    if (sees && nav.height_m > 0.5) nav.pad_known = 1, nav.pad_stamp = nav.stamp;
    plan.set_guide(speaks ? &guide : nullptr);
    plan.step({now_ns}, nav, 0.005);
    if (phases.empty() || phases.back() != plan.state().phase) phases.push_back(plan.state().phase);
    const msg::FlightSetpoint& s = plan.setpoint();
    nav.v_world_mps = {};
    if (!s.armed || s.mode == msg::FlightMode::idle) return;
    nav.v_world_mps = s.v_world_mps;
    if (s.mode == msg::FlightMode::position) nav.p_world_m = s.p_world_m;
    if (s.mode == msg::FlightMode::velocity)
      nav.p_world_m = (Vec3(nav.p_world_m) + Vec3(s.v_world_mps) * 0.005).to<msg::Vec3>();
    if (nav.p_world_m.z <= 0.12) nav.p_world_m.z = 0.12, nav.v_world_mps = {};
    nav.height_m = nav.p_world_m.z;
  }
};

TEST(GuidedMission, TheGuideFliesFromTheSearchToTheGround) {
  Guided f;
  ASSERT_TRUE(f.run_to(msg::MissionPhase::done, 60));
  using enum msg::MissionPhase;
  EXPECT_EQ(f.phases, (std::vector{wait, arm, climb, search, descend, touchdown, done}));
}

TEST(GuidedMission, ASilentGuideMeansHoveringAndSlowSinkingNearTheGround) {
  Guided f;
  ASSERT_TRUE(f.run_to(msg::MissionPhase::descend, 30));
  f.speaks = false;
  f.step();
  EXPECT_EQ(Vec3(f.plan.setpoint().v_world_mps), Vec3{});
  f.nav.p_world_m.z = f.nav.height_m = 0.4;
  f.step();
  EXPECT_EQ(Vec3(f.plan.setpoint().v_world_mps), (Vec3{0, 0, -f.plan.params.sink_slow_mps}));
}

TEST(GuidedMission, ALostPadIsSearchedForAgain) {
  Guided f;
  f.guide = {0.2, 0, 0};
  ASSERT_TRUE(f.run_to(msg::MissionPhase::descend, 30));
  f.sees = false;
  EXPECT_TRUE(f.run_to(msg::MissionPhase::search, 5));
}

}  // namespace
}  // namespace sinew::control::landing_test
