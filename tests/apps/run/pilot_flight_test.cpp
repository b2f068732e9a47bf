// A pilot in flight: the whole quadrotor with a radio control, its switches as failsafe conditions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fault_world.hpp"
#include "msg/pilot.hpp"

namespace sinew::app::test::pilot_flight_test {
namespace {

using msg::FailsafeAction;
using msg::MissionPhase;

constexpr Time kAct{8'300'000'000};

/// robots/quad/quad.toml as docs/sensors.md equips it with a pilot; the samples come from outside, 100 a second.
class PilotFlight : public ::testing::Test {
 protected:
  PilotFlight() {
    rt::TopicSpec radio;
    radio.name = "radio.rc";
    radio.external = rt::ExternalSpec{.type = "RcSample", .thread = "ranging"};
    radio.external->exec = {rt::ExecModel::Kind::constant, 1us, {}, 1.0};
    flight.spec.topics.push_back(radio);
    rt::ModuleSpec pilot;
    pilot.name = "pilot";
    pilot.type = "control::PilotSwitch";
    pilot.in = {{"rc", {"radio.rc", 0}}, {"state", {"filter.state", 0}}, {"mission", {"position.attitude", 0}}};
    pilot.exec = {rt::ExecModel::Kind::constant, 3us, {}, 1.0};
    flight.spec.modules.push_back(pilot);
    for (rt::ThreadSpec& t : flight.spec.threads)
      if (t.name == "navigate") t.order.push_back({"pilot", 0});
    for (rt::ModuleSpec& m : flight.spec.modules) {
      if (m.name == "attitude") m.in["attitude"] = {"pilot.attitude", 0};
      if (m.name == "mission") m.in["pilot"] = {"pilot.switches", 0};
    }
    add("killed", "kill", 0ms, FailsafeAction::stop);
    add("pilot_lost", "lost", 500ms, FailsafeAction::land);
    rc.count = 16;
    rc.channel[4] = rc.channel[5] = -1;
  }
  void add(const char* name, const char* field, Duration time, FailsafeAction action) {
    rt::FailsafeSpec f;
    f.name = name;
    f.kind = rt::FailsafeSpec::Kind::value;
    f.topic = {"pilot.switches", 0};
    f.field = {field, 0};
    f.above = 0.5;
    f.time = time;
    f.action = action;
    flight.spec.failsafes.push_back(f);
  }
  /// Each sample of the radio passes through `change`; false: it does not come.
  void fly(std::function<bool(Time, msg::RcSample&)> change) {
    flight.at_each_grant = [this, change](Time now) {
      if (now < next_) return;
      next_ = now + 10ms;
      if (!change(now, rc)) return;
      rc.stamp = now;
      EXPECT_TRUE(flight.graph->publish("radio.rc", std::as_bytes(std::span(&rc, 1))));
    };
    flight.fly(60s);
    EXPECT_EQ(flight.world->motors.wrong, 0);
  }
  std::uint32_t bit(const std::string& name) const {
    for (std::size_t i = 0; i < flight.spec.failsafes.size(); ++i)
      if (flight.spec.failsafes[i].name == name) return 1u << i;
    return 0;
  }
  void expect_landed() {
    ASSERT_FALSE(flight.phases.empty());
    EXPECT_EQ(flight.phases.back(), MissionPhase::done);
    EXPECT_EQ(flight.phases[flight.phases.size() - 2], MissionPhase::abort);
    EXPECT_LT(flight.world->model.truth().p_world_m.z, 0.13);
    EXPECT_LT(flight.world->fastest_fall_mps, 1.0);
  }
  FaultFlight flight;
  msg::RcSample rc;

 private:
  Time next_{};
};

TEST_F(PilotFlight, APilotWhoOnlyWatchesChangesNothing) {
  fly([](Time, msg::RcSample&) { return true; });
  EXPECT_TRUE(flight.actions.empty());
  ASSERT_FALSE(flight.phases.empty());
  EXPECT_EQ(flight.phases.back(), MissionPhase::done);
  EXPECT_EQ(flight.phases[flight.phases.size() - 2], MissionPhase::touchdown);
}

TEST_F(PilotFlight, TheKillSwitchStopsTheMotorsAtOnceAndForGood) {
  fly([](Time now, msg::RcSample& s) {
    if (now >= kAct) s.channel[5] = now < kAct + 1s ? 1 : -1;
    return true;
  });
  ASSERT_FALSE(flight.actions.empty());
  EXPECT_EQ(flight.actions[0].state.action, FailsafeAction::stop);
  EXPECT_EQ(flight.actions[0].state.latched, bit("killed"));
  const auto stop = flight.first_stop_since(kAct);
  ASSERT_TRUE(stop);
  // In virtual time: a period of the thread that takes the sample, one of the pilot's, one of the commands.
  EXPECT_LE(*stop, kAct + 10ms + 10ms + 5ms + 1ms);
  EXPECT_FALSE(flight.any_write_since(*stop)) << "also after the switch is back";
}

TEST_F(PilotFlight, ALostLinkLands) {
  fly([](Time now, msg::RcSample&) { return now < kAct; });
  ASSERT_FALSE(flight.actions.empty());
  EXPECT_EQ(flight.actions[0].state.action, FailsafeAction::land);
  EXPECT_EQ(flight.actions[0].state.latched, bit("pilot_lost"));
  EXPECT_GE(flight.actions[0].at, kAct + 300ms + 500ms - 20ms) << "lost after 0.3 s, for 0.5 s";
  EXPECT_LE(flight.actions[0].at, kAct + 300ms + 500ms + 20ms);
  expect_landed();
}

TEST_F(PilotFlight, NothingTurnsWithoutAPilotToHear) {
  fly([](Time, msg::RcSample&) { return false; });
  EXPECT_FALSE(flight.any_write_since(Time{0}));
  EXPECT_EQ(flight.phases.back(), MissionPhase::wait);
}

TEST_F(PilotFlight, ThePilotFliesForwardAndHandsBackToALanding) {
  double from_m = 0, to_m = 0, lean_rad = 0;
  fly([&](Time now, msg::RcSample& s) {
    const auto truth = flight.world->model.truth();
    const bool by_hand = now >= kAct && now < kAct + 1500ms;
    s.channel[4] = by_hand ? 1 : -1;
    s.channel[1] = by_hand ? 0.3 : 0;  // leans forward by 0.135 rad
    if (now < kAct) from_m = truth.p_world_m.x;
    if (by_hand) {
      to_m = truth.p_world_m.x;
      const auto ahead = truth.q_world_base.rotate({1, 0, 0});
      lean_rad = std::max(lean_rad, std::asin(-ahead.z));
    }
    return true;
  });
  EXPECT_GT(to_m - from_m, 0.5) << "half of 1.3 m/s^2 for 1.5 s, squared";
  EXPECT_NEAR(lean_rad, 0.135, 0.05);
  EXPECT_TRUE(flight.actions.empty()) << "no failsafe had to act";
  expect_landed();
}

}  // namespace
}  // namespace sinew::app::test::pilot_flight_test
