// What a world lets its user choose: keys of [sim], --set sim.KEY=VALUE, options of sinew-sim, from one table.
#include "apps/robot_file/world_options.hpp"

#include <gmock/gmock.h>

namespace sinew::app::world_options_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

LoadedRobot with(const std::string& sim) {
  return parse_robot("robot = { name = \"r\", board = \"sim\", seed = 4 }\n[sim]\n" + sim, "r.toml");
}

std::vector<std::string> problems_of(const std::string& sim) {
  std::vector<std::string> lines;
  for (const auto& p : with(sim).problems) lines.push_back(rt::to_string(p, "r.toml"));
  return lines;
}

TEST(WorldOptions, AreKeysOfTheSimTableAndReachTheSimulator) {
  const LoadedRobot loaded = with("wind_mps = 2\ngust_mps = 3.5\nstart_x_m = -1\nseed = 9\n");
  ASSERT_THAT(loaded.problems, IsEmpty());
  EXPECT_THAT(world_arguments(loaded.robot.sim), ElementsAre("--gust=3.5", "--wind=2", "--start-x=-1"));
  EXPECT_EQ(world_seed(loaded.robot), 9u);
  EXPECT_EQ(world_seed(with("").robot), 4u) << "the robot's";
  EXPECT_THAT(world_arguments(with("").robot.sim), IsEmpty()) << "the world's own defaults";
}

TEST(WorldOptions, AValueThatDoesNotFitIsToldWithItsLineAndWhatIsAllowed) {
  EXPECT_THAT(problems_of("gust_mps = 99\nwind_mps = \"much\"\nspread = nan\nsensor_errors = 0.5\nseed = -1\n"),
              testing::UnorderedElementsAre("r.toml:3: sim.gust_mps: 99: a number from 0 to 15 m/s",
                                            "r.toml:4: sim.wind_mps: \"much\": a number from 0 to 15 m/s",
                                            "r.toml:5: sim.spread: nan: a number from 0 to 0.3",
                                            "r.toml:6: sim.sensor_errors: 0.5: an integer from 0 to 1",
                                            "r.toml:7: sim.seed: -1: an integer from 0 to 9223372036854775807"));
}

TEST(WorldOptions, OfAnotherWorldAreNoneOfThisOne) {
  EXPECT_THAT(
      problems_of("world = \"seesaw\"\nstart_offset_m = 3\n"),
      ElementsAre("r.toml:4: sim.start_offset_m: 3: an option of the world quad; the world seesaw has push_radps2"));
  EXPECT_THAT(problems_of("gust_mps = 3\nworld = \"moon\"\n"), ElementsAre(testing::HasSubstr("sim.world: \"moon\"")))
      << "the options of an unknown world are not known either";
}

TEST(WorldOptions, AnUnknownKeyIsToldWithTheOneThatItResembles) {
  EXPECT_THAT(problems_of("wind = 3\n"), ElementsAre(testing::EndsWith("; did you mean wind_mps or wind_toward_deg?")));
  EXPECT_THAT(problems_of("gsut_mps = 3\n"), ElementsAre(testing::EndsWith("; did you mean gust_mps?")));
}

TEST(WorldSetting, TakesThePlaceOfTheKey) {
  SimTable sim = with("gust_mps = 1\n").robot.sim;
  EXPECT_EQ(apply_sim_setting(sim, "sim.gust_mps=3"), "");
  EXPECT_EQ(apply_sim_setting(sim, "sim.seed=12"), "");
  EXPECT_THAT(world_arguments(sim), ElementsAre("--gust=3"));
  EXPECT_EQ(sim.seed, 12u);
  EXPECT_EQ(apply_sim_setting(sim, "mixer.gust_mps=3"), std::nullopt) << "somebody else's";
}

TEST(WorldSetting, IsRefusedInTheWordsOfTheRobotFile) {
  SimTable sim = with("").robot.sim;
  const auto refused = [&](const std::string& setting) {
    const auto why = apply_sim_setting(sim, setting).value_or("not of [sim]");
    const std::string begin = "--set " + setting + ": ";
    EXPECT_TRUE(why.starts_with(begin)) << why;
    return why.substr(std::min(why.size(), begin.size()));
  };
  const std::string kOfRobotsThatTalk =
      "air_loss air_delay_ms air_jitter_ms air_kbps air_range_m air_split_at_s air_split_s clock_offset_s "
      "clock_drift_ppm";
  EXPECT_EQ(refused("sim.gust_mps=99"), "a number from 0 to 15 m/s");
  EXPECT_EQ(refused("sim.gust_mps=much"), "a number from 0 to 15 m/s");
  EXPECT_EQ(refused("sim.seed=-1"), "an integer from 0 to 9223372036854775807");
  EXPECT_EQ(refused("sim.push_radps2=1"),
            "an option of the world seesaw; the world quad has gust_mps wind_mps wind_toward_deg start_offset_m "
            "start_x_m start_y_m start_yaw_deg land_x_m land_y_m battery_charge spread sensor_errors " +
                kOfRobotsThatTalk);
  EXPECT_EQ(refused("sim.gusts_mps=3"),
            "--set takes of [sim] what its world offers, and the seed: gust_mps wind_mps wind_toward_deg "
            "start_offset_m start_x_m start_y_m start_yaw_deg land_x_m land_y_m battery_charge spread sensor_errors " +
                kOfRobotsThatTalk + " seed; did you mean gust_mps?");
  EXPECT_THAT(world_arguments(sim), IsEmpty());
  sim.plant = "unix:plant.sock";
  EXPECT_EQ(refused("sim.gust_mps=3"),
            "only a plant that this run starts itself (plant \"auto\") takes it; another has options of its own");
}

TEST(WorldOptions, WhatAWorldIsMadeWithIsWhatWasSaidLastOrElseTheDefault) {
  const LoadedRobot loaded = with("gust_mps = 3.5\nstart_x_m = -1\n");
  auto choices = world_choices(loaded.robot.sim, {"--gust=4", "--seed", "12", "--gust=5"});
  EXPECT_EQ(choices["gust_mps"], "5");
  EXPECT_EQ(choices["start_x_m"], "-1");
  EXPECT_EQ(choices["wind_mps"], "by the seed, up to half of gust_mps");
  EXPECT_EQ(choices["seed"], "12");
  choices = world_choices(loaded.robot.sim, {});
  EXPECT_EQ(choices["gust_mps"], "3.5");
  EXPECT_FALSE(choices.contains("seed")) << "the run's";
}

TEST(WorldSetting, TheShellIsOfferedThoseOfTheWorld) {
  EXPECT_THAT(world_settings("seesaw"), ElementsAre("sim.push_radps2=", "sim.seed="));
  EXPECT_THAT(world_settings(""), testing::IsSupersetOf({"sim.push_radps2=", "sim.gust_mps=", "sim.rock_deg="}));
}

}  // namespace
}  // namespace sinew::app::world_options_test
