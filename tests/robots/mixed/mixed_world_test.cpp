// Robots of two kinds in one world.
#include "robots/mixed/world/mixed_world.hpp"

#include <gtest/gtest.h>

#include "apps/toml/body_reader.hpp"
#include "robots/gripper/devices.hpp"
#include "robots/kid/devices.hpp"
#include "robots/robot_kind.hpp"
#include "sim_hil/worlds/json_object.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::plant::mixed_world_test {
namespace {

/// As the files of robots/mixed have it.
WorldChoice choice() {
  WorldChoice c;
  for (const auto& type : robots::all_worlds())
    if (type->info.name == std::string("mixed")) c.type = type;
  const auto op3 =
      std::make_shared<const kinematics::Body>(app::load_body(test::source_dir() + "/robots/kid/op3.toml").body);
  c.robots = {{"finder", {{"start_x_m", -1.2}, {"start_y_m", 2.6}, {"start_heading_deg", -50}}, op3},
              {"fetcher", {{"wheeled", 1}, {"start_x_m", -2.6}, {"start_y_m", -0.9}}, {}},
              {"reserve", {{"wheeled", 1}, {"start_x_m", -2.6}, {"start_y_m", 0.9}}, {}}};
  return c;
}

/// Pixels of the object's colour that a robot's first camera sees.
int orange(World& world, Painter& painter, std::size_t robot) {
  int count = 0;
  for (const std::uint32_t p : painter.draw(world.robot(robot).scene(0))) {
    const std::uint32_t r = p & 255, g = p >> 8 & 255, b = p >> 16 & 255;
    count += r > 100 && g * 10 < r * 6 && b * 10 < r * 3 ? 1 : 0;
  }
  return count;
}

TEST(MixedWorld, GivesEachRobotTheDevicesOfItsKind) {
  const WorldChoice c = choice();
  EXPECT_EQ(c.info_of(0).devices.data(), std::span(kKidDevices).data());
  EXPECT_TRUE(c.info_of(0).has_bodies);
  EXPECT_EQ(c.info_of(1).devices.data(), std::span(kGripperDevices).data());
  EXPECT_FALSE(c.info_of(1).has_bodies);
  EXPECT_TRUE(c.info_of(1).has(FaultDevice::gripper));
  EXPECT_FALSE(c.info_of(0).has(FaultDevice::gripper));
  EXPECT_GE(c.info_of(0).count(Part::camera), c.info_of(1).count(Part::camera))
      << "feeds are counted by the first kind";
}

TEST(MixedWorld, HidesTheObjectFromWheelsAndShowsItToTheHumanoidWhereverTheSeedPutsIt) {
  const WorldChoice c = choice();
  const auto painter = c.type->painter(320, 240, c);
  const std::vector<double> upright(c.type->info.channels(Part::actuators), 0);
  const std::vector<RobotCommand> commands{upright, {}, {}};
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    auto world = c.create(seed);
    ASSERT_TRUE(world);
    for (int i = 0; i < 400; ++i) (*world)->advance(commands);
    EXPECT_GE(orange(**world, *painter, 0), 12) << seed;
    EXPECT_EQ(orange(**world, *painter, 1), 0) << seed;
    EXPECT_EQ(orange(**world, *painter, 2), 0) << seed;
  }
}

TEST(MixedWorld, WithoutTheWallTheyAllSeeIt) {
  WorldChoice c = choice();
  c.values = {{"wall_high_m", 0}};
  const auto painter = c.type->painter(320, 240, c);
  auto world = c.create(1);
  ASSERT_TRUE(world);
  for (int i = 0; i < 8; ++i) (*world)->advance(std::vector<RobotCommand>(3));
  EXPECT_GT(orange(**world, *painter, 1), 0);
  EXPECT_GT(orange(**world, *painter, 2), 0);
}

TEST(MixedWorld, HasOneVerdictForAllAndKnowsThatNothingHasBegun) {
  auto world = choice().create(1);
  ASSERT_TRUE(world);
  for (int i = 0; i < 80; ++i) (*world)->advance(std::vector<RobotCommand>(3));
  for (std::size_t i = 0; i < 3; ++i) {
    const Verdict v = (*world)->robot(i).verdict();
    EXPECT_FALSE(v.good);
    EXPECT_FALSE(v.begun);
    EXPECT_EQ(v.outcome, "nobody has held the object");
  }
}

TEST(MixedWorld, IsTheSameAgainWithTheSameSeed) {
  const WorldChoice c = choice();
  std::vector<math::Vec3> ends;
  for (const std::uint64_t seed : {3u, 3u, 4u}) {
    auto made = MixedWorld::create(c, seed);
    ASSERT_TRUE(made);
    const std::vector<double> wheels{3, 4, 2};
    const std::vector<double> upright(c.type->info.channels(Part::actuators), 0);
    const std::vector<RobotCommand> commands{upright, wheels, {}};
    for (int i = 0; i < 2000; ++i) (*made)->advance(commands);
    ends.push_back((*made)->pitch().truth(1).torso.p_m);
  }
  EXPECT_EQ(ends[0].x, ends[1].x);
  EXPECT_EQ(ends[0].y, ends[1].y);
  EXPECT_NE(ends[0].y, ends[2].y);
  EXPECT_GT(ends[0].x, -2.6) << "it drove";
}

}  // namespace
}  // namespace sinew::plant::mixed_world_test
