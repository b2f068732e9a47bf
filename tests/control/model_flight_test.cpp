// Whole flights in the tests' own small model: properties that must hold for any plant, and the same bits everywhere.
#include <gmock/gmock.h>

#include "flight.hpp"

namespace sinew::control::test::model_flight_test {
namespace {

using msg::MissionPhase;
using ::testing::ElementsAre;

FlightReport fly(const QuadModelOptions& o, const math::Vec3& pad_world_m = {0.6, 0.5, 0}) {
  QuadModel world(o);
  Flight flight(world, o.seed);
  flight.pad_world_m = pad_world_m;
  return flight.run(60);
}

TEST(ModelFlight, TakesOffFindsThePadLandsOnItAndDisarms) {
  const FlightReport r = fly({});
  EXPECT_THAT(r.phases, ElementsAre(MissionPhase::wait, MissionPhase::arm, MissionPhase::climb, MissionPhase::search,
                                    MissionPhase::approach, MissionPhase::hold, MissionPhase::descend,
                                    MissionPhase::touchdown, MissionPhase::done));
  EXPECT_LT(r.end_pad_distance_m, 0.10);
  EXPECT_LT(r.touch_speed_mps, 0.4);
  EXPECT_LT(r.worst_pad_distance_error_m, 0.10);
  EXPECT_LT(r.worst_tilt_error_rad, 0.03);
}

TEST(ModelFlight, LandsWithFivePercentMoreAndLessMassAndInWind) {
  for (const double mass : {1.14, 1.26}) {
    QuadModelOptions o;
    o.mass_kg = mass;
    o.force_world_n = {0.4, -0.3, 0};
    const FlightReport r = fly(o);
    EXPECT_EQ(r.phase, MissionPhase::done);
    EXPECT_LT(r.end_pad_distance_m, 0.15) << mass << " kg";
    EXPECT_LT(r.touch_speed_mps, 0.5) << mass << " kg";
  }
}

TEST(ModelFlight, StartHeadingDoesNotMatter) {
  for (const double yaw : {-2.5, 1.0, 3.1}) {
    QuadModelOptions o;
    o.q_start = math::Quat::from_axis_angle({0, 0, 1}, yaw);
    const FlightReport r = fly(o);
    EXPECT_EQ(r.phase, MissionPhase::done);
    EXPECT_LT(r.end_pad_distance_m, 0.12) << "yaw " << yaw;
  }
}

TEST(ModelFlight, PadThatIsNotThereEndsOnTheGroundUprightAndDisarmed) {
  QuadModel world;
  Flight flight(world, 1);
  flight.pad_visible_from_s = 1e9;
  const FlightReport r = flight.run(120);
  EXPECT_EQ(r.phase, MissionPhase::done);
  EXPECT_EQ(r.phases[r.phases.size() - 2], MissionPhase::abort);
  EXPECT_LT(r.touch_speed_mps, 1.0);
  EXPECT_LT(r.end_speed_mps, 0.01);
  EXPECT_LT(r.max_tilt_rad, 0.4);
}

TEST(ModelFlight, SilentRangeFinderEndsOnTheGroundUprightAndDisarmed) {
  QuadModel world;  // has no barometer either
  Flight flight(world, 1);
  flight.pad_world_m = {0.6, 0.5, 0};
  flight.range_until_s = 7;
  const FlightReport r = flight.run(60);
  EXPECT_EQ(r.phase, MissionPhase::done);
  EXPECT_LT(r.touch_speed_mps, 1.5);
  EXPECT_LT(r.end_speed_mps, 0.01);
  EXPECT_LT(r.max_tilt_rad, 0.4);
}

TEST(ModelFlight, SameSeedTwiceGivesTheSameBytesAndAnotherSeedOthers) {
  QuadModelOptions o;
  const std::uint64_t first = fly(o).hash;
  EXPECT_EQ(fly(o).hash, first);
  o.seed = 2;
  EXPECT_NE(fly(o).hash, first);
}

TEST(ModelFlight, HasTheSameBitsOnEveryCompilerAndMachine) {
  // Changes with every change of the algorithms or their numbers; must not change with anything else.
  EXPECT_EQ(fly({}).hash, 13018789886620953211u);
}

}  // namespace
}  // namespace sinew::control::test::model_flight_test
