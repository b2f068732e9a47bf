// Flights in the plant without executor and camera; the whole of it is in tests/apps.
#include <gmock/gmock.h>

#include "flight.hpp"
#include "plant_world.hpp"

namespace sinew::control::test::plant_flight_test {
namespace {

using msg::MissionPhase;

class PlantFlight : public ::testing::TestWithParam<int> {};

TEST_P(PlantFlight, LandsOnThePadInGustsWithSpreadOfMassAndMotors) {
  plant::QuadOptions o;
  o.seed = static_cast<std::uint64_t>(GetParam());
  PlantWorld world(o);
  ASSERT_TRUE(world.good());
  Flight flight(world, o.seed);
  const FlightReport r = flight.run(90);
  const plant::FlightSummary& s = world.summary();
  EXPECT_EQ(r.phase, MissionPhase::done);
  EXPECT_TRUE(s.flew);
  EXPECT_TRUE(s.touched_down);
  EXPECT_FALSE(s.crashed);
  EXPECT_LT(s.touchdown_error_m, 0.15);
  EXPECT_LT(s.touchdown_speed_mps, 0.5);
  EXPECT_LT(r.worst_pad_distance_error_m, 0.12);
}
INSTANTIATE_TEST_SUITE_P(Seeds, PlantFlight, ::testing::Range(1, 11));

TEST(PlantFlight, WithoutAnySightingItComesDownSlowlyAndUpright) {
  plant::QuadOptions o;
  o.seed = 4;
  o.gust_mps = 0.5;  // without sightings it drifts with the wind; the walls are not the subject
  PlantWorld world(o);
  ASSERT_TRUE(world.good());
  Flight flight(world, o.seed);
  flight.pad_visible_from_s = 1e9;
  const FlightReport r = flight.run(120);
  EXPECT_EQ(r.phase, MissionPhase::done);
  EXPECT_TRUE(world.summary().touched_down);
  EXPECT_LT(world.summary().touchdown_speed_mps, 1.0);
  EXPECT_LT(r.max_tilt_rad, 0.5);
}

}  // namespace
}  // namespace sinew::control::test::plant_flight_test
