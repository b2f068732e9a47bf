#include "robots/air_robot/world/places.hpp"

#include <gtest/gtest.h>

#include <array>

#include "robots/air_robot/devices.hpp"

namespace sinew::plant::places_test {
namespace {

constexpr PlaceNumber kAll[] = {PlaceNumber::arena, PlaceNumber::empty_arena, PlaceNumber::town, PlaceNumber::room};

PlaceMap map_of(PlaceNumber number) {
  auto map = load_place(number);
  EXPECT_TRUE(map);
  return std::move(*map);
}

TEST(Places, EachHasRoomForAllVehiclesOfEachKindAtItsStartPoses) {
  for (const PlaceNumber number : kAll)
    for (const VehicleKind* kind : {&kAirRobot, &kP3at, &kP2at, &kFrontSteered, &kRearSteered}) {
      Place place(map_of(number), {});
      ASSERT_EQ(place.map().starts.size(), kMostRobots);
      for (const StartPose& start : place.map().starts)
        EXPECT_TRUE(place.enter(*kind, Place::standing(start, *kind), {})) << place.map().name << ' ' << start.name;
      for (int i = 0; i < 400; ++i) place.advance({});
      for (std::size_t i = 0; i < kMostRobots; ++i) {
        EXPECT_TRUE(place.vehicle(i)->body().stands) << place.map().name << ' ' << i;
        EXPECT_FALSE(place.vehicle(i)->body().touches) << place.map().name << ' ' << i;
      }
    }
}

TEST(Places, TheFocalLengthThatRobotFilesKnowIsTheVehicles) {
  EXPECT_NEAR(kAirFocalPerHeight, kAirRobot.focal_per_height, 1e-6);
  EXPECT_EQ(kAirCameraJoints, kCameraJoints);
}

TEST(Places, TheWayOfTheTargetIsFree) {
  for (const PlaceNumber number : kAll) {
    Place place(map_of(number), {1, 1.0, false});
    for (int i = 0; i < 60 * 4000; ++i) {
      place.advance({});
      if (i % 100 != 0) continue;
      for (const Solid& s : place.map().solids)
        EXPECT_GT(clearance(s, place.target_m()).distance_m, place.map().target_radius_m - 0.01)
            << place.map().name << " at " << place.target_m().x << ", " << place.target_m().y;
    }
  }
}

TEST(Places, AP3atDrivesOverTheRampsOfTheArenaAndAFieldOfSteps) {
  Place place(map_of(PlaceNumber::arena), {});
  const auto slot = place.enter(kP3at, {{-0.6, -3.6, kP3at.rest_m}, 0}, {});
  const auto steps = place.enter(kP3at, {{3.3, 3.2, kP3at.rest_m}, 0}, {});
  ASSERT_TRUE(slot && steps);
  Vehicle &v = *place.vehicle(*slot), &w = *place.vehicle(*steps);
  v.drive({{}, 5, 5});
  w.drive({{}, 5, 5});
  double highest = 0, highest_step = 0;
  for (int i = 0; i < 18 * 4000 && v.body().p_world_m.x < 7.6; ++i) {
    place.advance({});
    highest = std::max(highest, v.body().p_world_m.z);
    highest_step = std::max(highest_step, w.body().p_world_m.z);
  }
  EXPECT_NEAR(highest, 0.6 + kP3at.rest_m, 0.03) << "on the platform";
  EXPECT_GT(v.body().p_world_m.x, 7.5) << "and down again";
  EXPECT_NEAR(v.body().p_world_m.z, kP3at.rest_m, 0.01);
  EXPECT_EQ(v.touches(), 0u);
  EXPECT_GT(highest_step, kP3at.rest_m + 0.12);
  EXPECT_GT(w.body().p_world_m.x, 6.0) << "over the steps";
}

TEST(Places, OnlyOutdoorsThereAreSatellites) {
  EXPECT_EQ(Place(map_of(PlaceNumber::arena), {}).satellites({0, 0, 0}), 0u);
  EXPECT_EQ(Place(map_of(PlaceNumber::room), {}).satellites({0, 0, 0}), 0u);
  const Place town(map_of(PlaceNumber::town), {});
  EXPECT_GE(town.satellites({0, 0, 0}), 4u);
  EXPECT_LT(town.satellites({27.5, 8, 0}), town.satellites({0, 0, 60})) << "beside a tower, and above all of them";
}

}  // namespace
}  // namespace sinew::plant::places_test
