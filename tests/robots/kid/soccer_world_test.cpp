// The world of the humanoids, as a session sees it.
#include "robots/kid/world/soccer_world.hpp"

#include <gtest/gtest.h>

#include <set>

#include "apps/toml/body_reader.hpp"
#include "robots/robot_kind.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::plant::soccer_world_test {
namespace {

constexpr int kSecond = 4000;  // steps

WorldChoice choice(std::size_t robots = 1) {
  WorldChoice c;
  for (const auto& type : robots::all_worlds())
    if (type->info.name == std::string("soccer")) c.type = type;
  c.body = std::make_shared<const kinematics::Body>(app::load_body(test::source_dir() + "/robots/kid/op3.toml").body);
  for (std::size_t i = 0; robots > 1 && i < robots; ++i) c.robots.push_back({"kid" + std::to_string(i), {}, {}});
  return c;
}

std::vector<double> of_all(double rad) {
  return std::vector<double>(choice().type->info.channels(Part::actuators), rad);
}

TEST(SoccerWorld, HasALimbForEachGroupAndEverySampleInItsTime) {
  const WorldChoice c = choice();
  EXPECT_EQ(c.type->info.count(Part::actuators), kinematics::kLimbs);
  EXPECT_EQ(c.type->info.count(Part::joints), kinematics::kLimbs);
  EXPECT_EQ(c.type->info.count(Part::camera), 2u);
  auto world = c.create(1);
  ASSERT_TRUE(world);
  const std::vector<double> command = of_all(0);
  int imu = 0, soles = 0, joints = 0, battery = 0, truth = 0, cameras = 0;
  for (int i = 0; i < kSecond; ++i) {
    const Due& due = (*world)->step(command);
    imu += due.imu, soles += due.soles, joints += due.joints, battery += due.battery, truth += due.truth;
    cameras += due.cameras == 3;
    EXPECT_LE(due.imu_sample.stamp, (*world)->now());
  }
  EXPECT_EQ(imu, 500);
  EXPECT_EQ(soles, 125);
  EXPECT_EQ(joints, 125);
  EXPECT_EQ(battery, 10);
  EXPECT_EQ(truth, 100);
  EXPECT_EQ(cameras, 10) << "both at once";
  const Due& due = (*world)->robot(0).due();
  EXPECT_EQ((*world)->now().ns - due.imu_sample.stamp.ns, 10'000'000);
  const double weight_n = 9.81 * c.body->mass_kg();
  double pressed_n = 0;
  for (const double n : due.soles_sample.force_n) pressed_n += n;
  EXPECT_NEAR(pressed_n, weight_n, 0.25 * weight_n) << "it stands";
  EXPECT_EQ(due.joints_samples[1].count, kKidArmJoints);
  EXPECT_EQ(due.joints_samples[1].mode[2], msg::JointMode::enabled);
  EXPECT_EQ(due.joints_samples[1].mode[3], msg::JointMode::absent) << "this body has three joints in an arm";
  EXPECT_EQ(due.joints_samples[3].ready, 0b111111u);
}

TEST(SoccerWorld, ALimbWithoutACommandGivesNoTorqueWhileOthersGoOn) {
  auto world = choice().create(1);
  ASSERT_TRUE(world);
  std::vector<double> command = of_all(0.2);
  std::fill(command.begin() + kKidHeadJoints, command.begin() + kKidHeadJoints + kKidArmJoints, math::kNan);
  for (int i = 0; i < kSecond / 2; ++i) (*world)->step(command);
  const Due& due = (*world)->robot(0).due();
  EXPECT_EQ(due.joints_samples[0].ready, 0b11u);
  EXPECT_NEAR(due.joints_samples[0].position_rad[0], 0.2, 0.05);
  EXPECT_EQ(due.joints_samples[1].ready, 0u);
  EXPECT_NEAR(due.joints_samples[1].effort_nm[0], 0, 0.05);
  EXPECT_FALSE((*world)->robot(0).still());
  for (int i = 0; i < 4 * kSecond; ++i) (*world)->step({});
  EXPECT_TRUE((*world)->robot(0).still()) << "it lies where it fell";
  EXPECT_EQ((*world)->robot(0).verdict().outcome, "fell");
  EXPECT_FALSE((*world)->robot(0).verdict().good);
}

TEST(SoccerWorld, EachOfSeveralRobotsHasItsOwnBodyAndItsOwnCameras) {
  WorldChoice c = choice(2);
  c.robots[1].body =
      std::make_shared<const kinematics::Body>(app::load_body(test::source_dir() + "/robots/kid/nao.toml").body);
  auto made = c.create(1);
  ASSERT_TRUE(made);
  World& world = **made;
  const std::vector<double> stand = of_all(0);
  const RobotCommand both[] = {stand, stand};
  for (int i = 0; i < kSecond / 10; ++i) world.advance(both);
  const Scene one = world.robot(0).scene(0), other = world.robot(1).scene(0), second = world.robot(1).scene(1);
  EXPECT_EQ(one.bodies, 1 + c.body->links.size() + c.robots[1].body->links.size());
  EXPECT_GT(std::abs(one.camera.p_world_m.y - other.camera.p_world_m.y), 0.5);
  EXPECT_NE(other.camera.p_world_m.z, second.camera.p_world_m.z) << "NAO's cameras are above each other";
  const auto painter = c.type->painter(160, 120, c);
  const std::vector<std::uint32_t> seen(painter->draw(other).begin(), painter->draw(other).end());
  EXPECT_EQ(seen.size(), 160u * 120u);
  EXPECT_GT(std::set<std::uint32_t>(seen.begin(), seen.end()).size(), 4u) << "carpet, lines, sky and more";
}

TEST(SoccerWorld, ARobotWithoutABodyAndTwoInOnePlaceAreRefused) {
  WorldChoice c = choice();
  c.body.reset();
  EXPECT_EQ(c.create(1).error().code, hal::Errc::bad_argument);
  WorldChoice two = choice(2);
  for (NamedRobot& robot : two.robots) robot.values["start_y_m"] = 0;
  EXPECT_EQ(two.create(1).error().code, hal::Errc::bad_argument);
}

}  // namespace
}  // namespace sinew::plant::soccer_world_test
