// The world of the humanoids, as a session sees it.
#include "robots/kid/world/soccer_world.hpp"

#include <gtest/gtest.h>

#include <set>

#include "apps/toml/body_reader.hpp"
#include "robots/robot_kind.hpp"
#include "sim_hil/worlds/json_object.hpp"

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

TEST(SoccerWorld, WithoutDynamicsARobotStandsWithoutTorqueWhateverPushesIt) {
  WorldChoice c = choice();
  c.values = {{"kinematic", 1}, {"push_ns", 20}};
  auto world = c.create(1);
  ASSERT_TRUE(world);
  for (int i = 0; i < 4 * kSecond; ++i) (*world)->step({});
  const WorldTruth truth = (*world)->robot(0).ground_truth();
  EXPECT_FALSE(truth.contact);
  EXPECT_TRUE(truth.landed);
  EXPECT_GT(math::Quat(truth.q_world_base).rotate({0, 0, 1}).z, 0.999);
}

// ---- games

/// A world without dynamics in which a referee leads a game that begins after two seconds.
WorldChoice game(std::size_t robots) {
  WorldChoice c = choice(robots);
  c.values = {{"kinematic", 1}, {"referee", 1}, {"referee_ready_s", 1}, {"referee_set_s", 1}};
  return c;
}

struct Played {
  std::vector<std::vector<msg::RefereeState>> said{};  // to each robot
  std::vector<std::string> report{};
};

/// All robots stand, each with a command.
Played play(const WorldChoice& c, double seconds) {
  auto made = c.create(1);
  EXPECT_TRUE(made);
  World& world = **made;
  const std::vector<double> stand = of_all(0);
  const std::vector<RobotCommand> all(world.robots(), RobotCommand(stand));
  Played played;
  played.said.resize(world.robots());
  for (int i = 0; i < static_cast<int>(seconds * kSecond); ++i) {
    world.advance(all);
    for (std::size_t r = 0; r < world.robots(); ++r)
      if (world.robot(r).due().referee) played.said[r].push_back(world.robot(r).due().referee_sample);
  }
  for (std::size_t r = 0; r < world.robots(); ++r) {
    JsonObject report;
    world.robot(r).add_to(report);
    played.report.push_back(report.done());
  }
  return played;
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(SoccerGame, ABallThatIsRolledIntoTheGoalIsAGoalAndEveryRobotHearsIt) {
  WorldChoice c = game(2);
  c.robots[1].values = {{"team", 1}, {"start_x_m", 2}, {"start_y_m", 2}};
  c.values["ball_roll_mps"] = 3.5;
  c.values["ball_roll_at_s"] = 2.5;
  const Played played = play(c, 6);
  const auto& blue = played.said[0];
  const auto& red = played.said[1];
  ASSERT_EQ(blue.size(), 12u) << "twice a second";
  EXPECT_EQ(blue[0].phase, msg::GamePhase::ready);
  EXPECT_EQ(blue[2].phase, msg::GamePhase::set);
  EXPECT_EQ(blue[4].phase, msg::GamePhase::playing);
  EXPECT_EQ(blue[4].kick, msg::GameKick::own);
  EXPECT_EQ(red[4].kick, msg::GameKick::other);
  EXPECT_EQ(blue[4].own_goals, 0u);
  EXPECT_EQ(blue.back().own_goals, 1u);
  EXPECT_EQ(blue.back().other_goals, 0u);
  EXPECT_EQ(red.back().own_goals, 0u);
  EXPECT_EQ(red.back().other_goals, 1u);
  EXPECT_EQ(blue.back().attacks_right, 1u);
  EXPECT_EQ(red.back().attacks_right, 0u);
  EXPECT_EQ(red.back().team, 1u);
  EXPECT_EQ(blue[5].stamp.ns, 3'000'000'000);
  for (const std::string& report : played.report) {
    EXPECT_TRUE(has(report, "\"goals_of_blue\":1")) << report;
    EXPECT_TRUE(has(report, "goal for team 0, 1:0")) << report;
  }
}

TEST(SoccerGame, ABallThatRollsOutIsThrownIn) {
  WorldChoice c = game(1);
  c.values["ball_roll_mps"] = 3;
  c.values["ball_roll_deg"] = 90;
  c.values["ball_roll_at_s"] = 2.5;
  const Played played = play(c, 5);
  EXPECT_TRUE(has(played.report[0], "throw-in for team")) << played.report[0];
  EXPECT_TRUE(has(played.report[0], "\"ball_y_m\":3")) << played.report[0];
  EXPECT_EQ(played.said[0].back().own_goals, 0u);
}

TEST(SoccerGame, ARobotThatLiesTooLongIsTakenOutAndComesBackAndHasNotWalkedThere) {
  WorldChoice c = game(2);
  c.robots[1].values = {{"team", 1}, {"start_x_m", 2}, {"start_y_m", 1}, {"start_lie", 1}};
  c.values["referee_fallen_s"] = 3;
  c.values["referee_penalty_s"] = 2;
  const Played played = play(c, 7);
  std::size_t penalised = 0;
  for (const msg::RefereeState& said : played.said[1]) {
    if (said.penalty == msg::GamePenalty::none) continue;
    ++penalised;
    EXPECT_EQ(said.penalty, msg::GamePenalty::incapable);
    EXPECT_GT(said.penalty_left_s, 0);
    EXPECT_LE(said.penalty_left_s, 2);
  }
  EXPECT_EQ(penalised, 4u) << "2 s";
  for (const msg::RefereeState& said : played.said[0]) EXPECT_EQ(said.penalty, msg::GamePenalty::none);
  const std::string& report = played.report[1];
  EXPECT_TRUE(has(report, "robot 1: incapable")) << report;
  EXPECT_TRUE(has(report, "robot 1 comes back")) << report;
  EXPECT_TRUE(has(report, "\"y_m\":3")) << "at the touch line: " << report;
  EXPECT_TRUE(has(report, "\"fallen\":false")) << report;
  EXPECT_TRUE(has(report, "\"rises\":0")) << report;
  EXPECT_TRUE(has(report, "\"walked_m\":0,")) << report;
}

TEST(SoccerGame, HasTwoHalvesInWhichSidesChange) {
  WorldChoice c = game(1);
  c.values["referee_half_s"] = 2;
  const Played played = play(c, 9);
  EXPECT_EQ(played.said[0].front().attacks_right, 1u);
  EXPECT_EQ(played.said[0].back().attacks_right, 0u);
  EXPECT_EQ(played.said[0].back().half, 2u);
  EXPECT_EQ(played.said[0].back().phase, msg::GamePhase::finished);
}

TEST(SoccerGame, WithoutARefereeNobodySaysAnything) {
  WorldChoice c = game(1);
  c.values["referee"] = 0;
  const Played played = play(c, 3);
  EXPECT_TRUE(played.said[0].empty());
  EXPECT_FALSE(has(played.report[0], "game"));
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
