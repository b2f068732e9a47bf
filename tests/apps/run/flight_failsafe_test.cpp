// Failsafes in flight: the whole quadrotor loses a device in the air, and lands or stops as its robot file says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fault_world.hpp"
#include "msg/operator.hpp"

namespace sinew::app::test::flight_failsafe_test {
namespace {

using msg::FailsafeAction;
using msg::MissionPhase;

constexpr Time kLoss{8'000'300'000};

class FlightFailsafe : public ::testing::Test {
 protected:
  /// Flies until the mission is done; `lose` once, at kLoss.
  void fly(std::function<void(FaultWorld&)> lose) {
    flight.at_each_grant = [this, lose](Time now) {
      if (now < kLoss || lost_) return;
      lost_ = true;
      height_m = flight.world->model.truth().p_world_m.z;
      lose(*flight.world);
    };
    flight.fly(60s);
    EXPECT_EQ(flight.world->motors.wrong, 0);
    EXPECT_GT(height_m, 0.5) << "it was in the air";
  }
  std::uint32_t bit(const std::string& name) const {
    for (std::size_t i = 0; i < flight.spec.failsafes.size(); ++i)
      if (flight.spec.failsafes[i].name == name) return 1u << i;
    ADD_FAILURE() << "no failsafe " << name;
    return 0;
  }
  void expect_action(const std::string& name, FailsafeAction action) {
    ASSERT_FALSE(flight.actions.empty());
    EXPECT_EQ(flight.actions[0].state.action, action);
    EXPECT_EQ(flight.actions[0].state.latched, bit(name));
  }
  void expect_landed(double most_mps) {
    ASSERT_FALSE(flight.phases.empty());
    EXPECT_EQ(flight.phases.back(), MissionPhase::done);
    EXPECT_EQ(flight.phases[flight.phases.size() - 2], MissionPhase::abort);
    EXPECT_LT(flight.world->model.truth().p_world_m.z, 0.13);
    EXPECT_LT(flight.world->fastest_fall_mps, most_mps);
    EXPECT_LT(flight.world->largest_tilt_rad, 0.4);
    EXPECT_EQ(flight.world->motors.at(flight.clock.now())[0], 0);
  }
  FaultFlight flight;
  double height_m = 0;

 private:
  bool lost_ = false;
};

TEST_F(FlightFailsafe, WithoutItsCameraItLandsWhereItIs) {
  fly([](FaultWorld& w) { w.camera_works = false; });
  expect_action("camera_lost", FailsafeAction::land);
  expect_landed(0.8);
}

TEST_F(FlightFailsafe, WithoutItsRangeFinderItLandsByTheBarometer) {
  fly([](FaultWorld& w) { w.range_works = false; });
  expect_action("range_lost", FailsafeAction::land);
  expect_landed(0.8);
}

TEST_F(FlightFailsafe, WithNeitherRangeFinderNorBarometerItComesDownBlindly) {
  fly([](FaultWorld& w) { w.range_works = w.baro_works = false; });
  expect_action("range_lost", FailsafeAction::land);
  expect_landed(1.6);
}

TEST_F(FlightFailsafe, WithNeitherCameraNorRangeFinderItLands) {
  fly([](FaultWorld& w) { w.range_works = w.camera_works = false; });
  expect_action("range_lost", FailsafeAction::land);
  expect_landed(0.8);
}

TEST_F(FlightFailsafe, AStuckImuStopsTheMotorsForGood) {
  fly([](FaultWorld& w) { w.imu_stuck = true; });
  expect_action("imu_stuck", FailsafeAction::stop);
  const auto stop = flight.first_stop_since(kLoss);
  ASSERT_TRUE(stop);
  // 20 ms after the first of the equal samples, of 8.001 s, with the command that the last of them leads to.
  EXPECT_EQ(*stop, Time{8'021'029'000} + flight.spec.guardian.exec.constant);
  EXPECT_FALSE(flight.any_write_since(*stop));
}

TEST_F(FlightFailsafe, ALowBatteryLandsAfterItsSecond) {
  fly([](FaultWorld& w) { w.voltage_v = 12.8; });
  expect_action("battery_low", FailsafeAction::land);
  const Time sample{8'025'000'000};  // the first low one; the thread comes round to it later
  EXPECT_EQ(flight.actions[0].at, flight.guardian_step_since(flight.first_battery_since(sample) + 1s));
  expect_landed(0.8);
}

/// A robot whose operator must be heard: an external topic, a condition on it, arming by hand.
class LinkedFlight : public FlightFailsafe {
 protected:
  LinkedFlight() {
    rt::TopicSpec link;
    link.name = "operator.link";
    link.external = rt::ExternalSpec{.type = "OperatorLink", .thread = "housekeeping"};
    link.external->exec = {rt::ExecModel::Kind::constant, 1us, {}, 1.0};
    flight.spec.topics.push_back(link);
    rt::FailsafeSpec lost;
    lost.name = "link_lost";
    lost.topic = {"operator.link", 0};
    lost.time = 1s;
    lost.action = FailsafeAction::land;
    flight.spec.failsafes.push_back(lost);
    flight.spec.guardian.arming = rt::GuardianSpec::Arming::manual;
  }
  /// The operator speaks ten times a second until `silent_from`, and arms at 3 s.
  void fly_until_silent(Time silent_from) {
    flight.at_each_grant = [this, silent_from](Time now) {
      if (now >= next_word_ && now < silent_from) {
        const msg::OperatorLink word{.stamp = now};
        EXPECT_TRUE(flight.graph->publish("operator.link", std::as_bytes(std::span(&word, 1))));
        next_word_ = now + 100ms;
      }
      if (!armed_ && now >= Time{3'000'000'000}) armed_ = flight.graph->arm().has_value();
    };
    flight.fly(60s);
    EXPECT_EQ(flight.world->motors.wrong, 0);
  }

 private:
  Time next_word_{};
  bool armed_ = false;
};

TEST_F(LinkedFlight, FliesWhileTheOperatorIsHeard) {
  fly_until_silent(Time{INT64_MAX});
  EXPECT_TRUE(flight.actions.empty());
  ASSERT_FALSE(flight.phases.empty());
  EXPECT_EQ(flight.phases.back(), MissionPhase::done);
  ASSERT_TRUE(flight.first_write());
  EXPECT_GT(*flight.first_write(), Time{3'000'000'000}) << "not before it is armed";
}

TEST_F(LinkedFlight, LandsWhereItIsWhenTheOperatorIsNotHeardAnyMore) {
  fly_until_silent(Time{9'500'000'000});
  expect_action("link_lost", FailsafeAction::land);
  EXPECT_EQ(flight.actions[0].at, flight.guardian_step_since(flight.last_published("operator.link") + 1s));
  expect_landed(0.8);
}

TEST_F(LinkedFlight, DoesNotArmWithoutAnOperator) {
  fly_until_silent(Time{0});
  EXPECT_FALSE(flight.any_write_since(Time{0}));
  EXPECT_EQ(flight.phases.back(), MissionPhase::wait);
}

}  // namespace
}  // namespace sinew::app::test::flight_failsafe_test
