#include "robots/terrain/world/terrain_world.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_hil/mujoco/room.hpp"

namespace sinew::plant::terrain_world_test {
namespace {

constexpr Terrain kAll[] = {Terrain::hills, Terrain::steps, Terrain::buildings};

std::unique_ptr<TerrainWorld> world(Terrain terrain, std::uint64_t seed = 1) {
  TerrainOptions o;
  o.terrain = terrain;
  o.quad.seed = seed;
  o.quad.sensor_errors = false;
  auto made = TerrainWorld::create(o);
  EXPECT_TRUE(made);
  return std::move(*made);
}

void wait(TerrainWorld& w, double seconds, double command = 0) {
  const std::array<double, kRotors> all{command, command, command, command};
  const RobotCommand one(all);
  for (int i = 0; i < seconds * 1e9 / kStepNs; ++i) w.advance({&one, 1});
}

TEST(Ground, StepsAreAtMostAFifthOfTwoMetresAndSlopesAtMostAHalf) {
  for (const Terrain t : kAll)
    for (double across : {-2.0, 0.0, 2.0})
      for (double x = 0; x < 100; x += 0.05) {
        const double here = ground_m(t, x, across), there = ground_m(t, x + 0.1, across);
        EXPECT_GE(here, 0);
        EXPECT_LE(std::fabs(there - here), t == Terrain::steps ? 0.401 : 0.05) << static_cast<int>(t) << ' ' << x;
      }
}

TEST(TerrainWorld, TheHeightFieldIsTheGroundThatTheWorldJudgesBy) {
  for (const Terrain t : kAll) {
    auto w = world(t);
    for (const double x : {20.3, 28.7, 31.0, 47.0, 66.2}) {
      const double y = lane_m(t) + 1.3, z = ground_m(t, x, 1.3);
      w->quad().place({x, y, z + 1.5}, {});
      wait(*w, 0.011);  // the next range
      const double fallen = z + 1.5 - w->quad().truth().p_world_m.z;
      EXPECT_NEAR(w->due().range_sample.range_m, 1.5 - 0.04 - fallen, 0.03) << static_cast<int>(t) << ' ' << x;
      EXPECT_NEAR(w->height_m(), 1.5 - fallen, 1e-5);
    }
  }
}

TEST(TerrainWorld, AVehicleThatFallsOntoAHillTouchesTheGround) {
  auto w = world(Terrain::hills);
  const double z = ground_m(Terrain::hills, 24, 0);
  EXPECT_GT(z, 0.3);
  w->quad().place({24, lane_m(Terrain::hills), z + 1.5}, {});
  wait(*w, 0.4);
  EXPECT_FALSE(w->quad().truth().contact);
  wait(*w, 1.1);
  EXPECT_TRUE(w->quad().truth().contact);
  EXPECT_NEAR(w->height_m(), 0.12, 0.08);
  EXPECT_EQ(w->verdict().outcome, "touched the ground");
  EXPECT_FALSE(w->verdict().good);
}

TEST(TerrainWorld, StandsStillOnItsFloorAndHasNotBegun) {
  auto w = world(Terrain::buildings);
  wait(*w, 1);
  EXPECT_NEAR(w->height_m(), 0.12, 0.01);
  EXPECT_FALSE(w->verdict().begun);
  EXPECT_EQ(w->verdict().outcome, "did not fly");
}

TEST(HeightScore, TheRightHeightIsSpeedByMotion) {
  HeightScore score(0.75);
  for (int i = 0; i < 500; ++i) score.add(2, 1.5, 0.01);
  EXPECT_NEAR(score.off_most(), 0, 1e-12);
  EXPECT_EQ(score.share_within(), 1);
  for (int i = 0; i < 10; ++i) score.add(3, 1.5, 0.01);  // half too high, for a tenth of a second
  EXPECT_LT(score.off_most(), 0.06);
  for (int i = 0; i < 500; ++i) score.add(3, 1.5, 0.01);
  EXPECT_NEAR(score.off_most(), 0.5, 0.01);
  EXPECT_NEAR(score.share_within(), 0.5, 0.01);
  EXPECT_NEAR(score.least_m(), 2, 1e-12);
}

constexpr std::string_view kField =
    R"(<mujoco><compiler discardvisual="false"/><custom><text name="field" data="%"/></custom>
  <asset><hfield name="field" nrow="2" ncol="2" size="1 1 1 0.1"/></asset>
  <worldbody><geom type="hfield" hfield="field"/></worldbody></mujoco>)";

TEST(Room, AHeightFieldWithoutAsManyHeightsAsPointsOrWithOneOverItsTopIsRefused) {
  const auto load = [](std::string_view heights) {
    std::string xml(kField);
    xml.replace(xml.find('%'), 1, heights);
    return load_room(xml, RoomUse::physics).has_value();
  };
  EXPECT_TRUE(load("0 500 1000 20"));
  EXPECT_FALSE(load("0 500 1000"));
  EXPECT_FALSE(load("0 500 1001 20"));
  EXPECT_FALSE(load("0 500 -1 20"));
  EXPECT_FALSE(load("0 five 1000 20"));
}

}  // namespace
}  // namespace sinew::plant::terrain_world_test
