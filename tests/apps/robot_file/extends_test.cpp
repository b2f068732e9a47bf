// A robot file that extends another one.
#include "apps/robot_file/extends.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "apps/robot_file/robot_file.hpp"
#include "apps/toml/body_reader.hpp"
#include "drivers/board/device_board.hpp"
#include "drivers/board/driver_list.hpp"

namespace sinew::app::extends_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* kBase = R"([robot]
name = "base"
board = "none"

[module.b]
type = "B"
[module.b.params]
gain = 1.5
"odd key" = "text with \"quotes\""

[module.a]
type = "A"
in.x = "b.out"

[[thread]]
name = "fast"
period_us = 1000
priority = 80
order = ["b", "a"]

[[thread]]
name = "slow"
period_us = 100000
priority = 10
order = ["z"]
)";

class Extends : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = (std::filesystem::temp_directory_path() / ("sinew_extends_" + std::to_string(::getpid()))).string();
    std::filesystem::create_directories(folder_ + "/below");
    write("below/base.toml", kBase);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ + "/" + name) << text; }
  LoadedRobot load(const std::string& text) const {
    write("robot.toml", text);
    return load_robot(folder_ + "/robot.toml");
  }
  std::string folder_;
};

TEST_F(Extends, AKeyTakesThePlaceOfTheSameKeyAndAllElseStays) {
  const LoadedRobot loaded = load(R"(extends = "below/base.toml"
[robot]
name = "other"
[module.b.params]
gain = 2.0
[[thread]]
name = "slow"
priority = 5
[module.c]
type = "C"
)");
  EXPECT_TRUE(loaded.problems.empty()) << rt::to_string(loaded.problems[0], "robot");
  const rt::GraphSpec& graph = loaded.robot.graph;
  EXPECT_EQ(graph.robot, "other");
  EXPECT_EQ(graph.board, "none");
  ASSERT_EQ(graph.modules.size(), 3u);
  EXPECT_EQ(graph.modules[0].name, "b") << "in the order of the files, not of the alphabet";
  EXPECT_EQ(graph.modules[1].name, "a");
  EXPECT_EQ(graph.modules[2].name, "c");
  EXPECT_EQ(std::get<double>(graph.modules[0].params.at("gain").value), 2.0);
  EXPECT_EQ(std::get<std::string>(graph.modules[0].params.at("odd key").value), "text with \"quotes\"");
  ASSERT_EQ(graph.threads.size(), 2u);
  EXPECT_EQ(graph.threads[0].priority, 80);
  EXPECT_EQ(graph.threads[1].priority, 5);
  EXPECT_EQ(graph.threads[1].period, std::chrono::milliseconds(100));
  EXPECT_THAT(loaded.robot.text, HasSubstr("[module.c]  # " + folder_ + "/robot.toml:"));
}

TEST_F(Extends, WhatIsResolvedStandsAloneAndIsTheSame) {
  const LoadedRobot loaded = load("extends = \"below/base.toml\"\n[robot]\nname = \"other\"\n");
  const ResolvedRobot again = resolve_robot(loaded.robot.text, "elsewhere.toml");
  EXPECT_FALSE(again.extended);
  const LoadedRobot alone = parse_robot(again.text, "elsewhere.toml");
  EXPECT_TRUE(alone.problems.empty()) << rt::to_string(alone.problems[0], "alone") << again.text;
  EXPECT_EQ(alone.robot.graph.modules.size(), loaded.robot.graph.modules.size());
}

TEST_F(Extends, ArraysOfSmallNumbersAreResolvedAsTheyAre) {
  const LoadedRobot loaded = load(R"(extends = "below/base.toml"
[actuator.m]
command = "a.x"
channels = 2
limit = [[-0.04, 1e-4], [-1.0, 0.9]]
lease_ms = 20
)");
  EXPECT_THAT(loaded.problems, testing::IsEmpty());
  EXPECT_THAT(loaded.robot.text, HasSubstr("limit = [ [ -0.0"));
  ASSERT_EQ(loaded.robot.graph.actuators.size(), 1u);
  ASSERT_EQ(loaded.robot.graph.actuators[0].channel_limits.size(), 2u);
  EXPECT_EQ(loaded.robot.graph.actuators[0].channel_limits[0].min, -0.04);
  EXPECT_EQ(loaded.robot.graph.actuators[0].channel_limits[0].max, 1e-4);
}

TEST_F(Extends, ChainsAreFollowedAndTablesCanBeTakenAway) {
  write("middle.toml", "extends = \"below/base.toml\"\n[module.c]\ntype = \"C\"\n");
  const LoadedRobot loaded = load(R"(extends = "middle.toml"
without = ["module.a", "thread.slow"]
[[thread]]
name = "fast"
order = ["b", "c"]
)");
  EXPECT_TRUE(loaded.problems.empty()) << rt::to_string(loaded.problems[0], "robot");
  std::vector<std::string> names;
  for (const auto& m : loaded.robot.graph.modules) names.push_back(m.name);
  EXPECT_THAT(names, ElementsAre("b", "c"));
  ASSERT_EQ(loaded.robot.graph.threads.size(), 1u);
  EXPECT_EQ(loaded.robot.graph.threads[0].order.size(), 2u);
}

TEST_F(Extends, AFileThatExtendsNothingIsReadAsItIs) {
  const LoadedRobot loaded = load(kBase);
  EXPECT_EQ(loaded.robot.text, kBase);
  EXPECT_FALSE(loaded.robot.extended);
}

TEST_F(Extends, WhatIsWrongWithTheFilesIsNamedWithItsFileAndLine) {
  const auto problem = [&](const std::string& text) {
    const LoadedRobot loaded = load(text);
    return loaded.problems.empty() ? "none" : to_string(loaded.problems[0], loaded.robot);
  };
  const std::string own = folder_ + "/robot.toml:", below = "extends = \"below/base.toml\"\n";
  EXPECT_EQ(problem("\nextends = \"nowhere.toml\""),
            own + "2: extends: \"nowhere.toml\": a file that can be read: " + folder_ + "/nowhere.toml");
  EXPECT_EQ(problem("extends = 5"), own + "1: extends: : the path of another file, a text");
  EXPECT_EQ(problem("extends = \"robot.toml\""),
            own + "1: extends: \"robot.toml\": a file that does not extend this one: they go in a circle");
  EXPECT_EQ(problem(below + "without = [\"module.z\"]"),
            own + "2: without: \"module.z\": a table of the file that is extended, such as \"module.pad\"");
  EXPECT_EQ(problem(below + "without = 3"), own + "2: without: : an array of tables' names, such as \"module.pad\"");
  write("below/odd.toml", "\n\u00b0 = 1\n");
  EXPECT_EQ(problem("extends = \"below/odd.toml\""),
            folder_ + "/below/odd.toml:2: TOML: syntax: only ASCII outside of comments");
  write("below/circle.toml", "\n\nextends = \"../robot.toml\"\n");
  EXPECT_EQ(problem("extends = \"below/circle.toml\""),
            folder_ +
                "/below/circle.toml:3: extends: \"../robot.toml\": a file that does not extend this one: they go "
                "in a circle");
  write("below/broken.toml", "[robot\n");
  EXPECT_THAT(problem("extends = \"below/broken.toml\""), StartsWith(folder_ + "/below/broken.toml:1: TOML: syntax: "));
}

TEST_F(Extends, AProblemNamesTheFileAndLineWhereItsKeyStands) {
  write("below/wrong.toml", R"([robot]
name = "base"
board = "none"
[[thread]]
name = "fast"
period_us = 1
priority = 80
# A long array: more than one line of the text that is resolved.
order = ["a_module_with_a_long_name", "another_one_with_a_long_name", "and_a_third_with_a_long_name", "fourth"]
colour = "red"
)");
  write("middle.toml", "extends = \"below/wrong.toml\"\n\n[robot]\nseed = -1\n");
  LoadedRobot loaded = load(R"(extends = "middle.toml"
[[thread]]
name = "fast"
priority = 200

[guardian]
arming = "never"
[device.imu]
driver = "icm42600"
rate_hz = -3
)");
  for (rt::Problem& p : drivers::check_devices(loaded.robot.devices, drivers::all_drivers()))
    loaded.problems.push_back(std::move(p));
  add_graph_problems(loaded, {}, {.virtual_time = true});
  std::vector<std::string> lines;
  for (const rt::Problem& p : loaded.problems) lines.push_back(to_string(p, loaded.robot).substr(folder_.size() + 1));
  EXPECT_THAT(
      lines,
      ElementsAre(
          "middle.toml:4: robot.seed: -1: an integer from 0 to 9223372036854775807",
          "below/wrong.toml:6: thread.fast.period_us: 1: a number from 10 to 3600000000",
          "below/wrong.toml:9: thread.fast.order: \"a_module_with_a_long_name\": a module: ",
          "below/wrong.toml:9: thread.fast.order: \"another_one_with_a_long_name\": a module: ",
          "below/wrong.toml:9: thread.fast.order: \"and_a_third_with_a_long_name\": a module: ",
          "below/wrong.toml:9: thread.fast.order: \"fourth\": a module: ",
          "below/wrong.toml:10: thread.fast.colour: \"red\": unknown key; known here: catch_up_max cpus device name "
          "order overrun period_us phase_us precise priority stack_kib timeout_us trigger",
          "robot.toml:4: thread.fast.priority: 200: an integer from 0 to 98",
          "robot.toml:7: guardian.arming: \"never\": one of \"auto\", \"manual\"",
          "robot.toml:8: device.imu.path: missing: the path of the chip's bus, \"/dev/i2c-1\" or \"/dev/spidev0.0\"; "
          "it is "
          "required",
          "robot.toml:10: device.imu.rate_hz: -3: one of 25, 50, 100, 200, 500, 1000, 2000, 4000, 8000"));
}

TEST_F(Extends, TheLastOfAListTakenAwayLeavesNoEmptyList) {
  write("below/chained.toml", std::string(kBase) + "[[chain]]\nname = \"all\"\nfrom = \"a\"\nto = \"b\"\n");
  const LoadedRobot loaded = load("extends = \"below/chained.toml\"\nwithout = [\"chain.all\"]\n");
  EXPECT_THAT(loaded.problems, ::testing::IsEmpty());
  EXPECT_TRUE(loaded.robot.graph.chains.empty());
}

TEST_F(Extends, TheBodyOfARobotIsThatOfAFileWithWhatTheRobotSaysOverIt) {
  write("below/body.toml", R"(name = "doll"
[[servo]]
name = "s"
stall_nm = 1
no_load_radps = 5

[[link]]
name = "torso"
mass_kg = 1

[[link]]
name = "head"
parent = "torso"
at_m = [0, 0, 0.1]
axis = [0, 0, 1]
range_deg = [-90, 90]
servo = "s"
)");
  const std::string robot = R"([robot]
name = "doll"
board = "none"

[body]
extends = "below/body.toml"
[[body.link]]
name = "head"
at_m = [0, 0, 0.2]
)";
  const LoadedRobot loaded = load(robot);
  EXPECT_THAT(loaded.problems, ::testing::IsEmpty());
  ASSERT_TRUE(loaded.robot.body.body);
  EXPECT_EQ(loaded.robot.body.body->name, "doll");
  ASSERT_EQ(loaded.robot.body.body->joints(), 1u);
  EXPECT_EQ(loaded.robot.body.body->links[1].at_m.z, 0.2);
  EXPECT_NEAR(loaded.robot.body.body->links[1].most_rad, 1.5708, 1e-4);
  EXPECT_THAT(loaded.robot.text, HasSubstr("[[body.link]]"));
  EXPECT_TRUE(parse_robot(loaded.robot.text, "recorded").robot.body.body) << "without any other file";
  EXPECT_EQ(load_body(folder_ + "/robot.toml").body.links.size(), 2u) << "as a simulator reads it";

  EXPECT_THAT(rt::to_string(load(robot + "mass_kg = -1\n").problems.at(0), "robot.toml"),
              HasSubstr("body.link.head.mass_kg: -1"));
  const LoadedRobot lost = load("[robot]\nname = \"doll\"\nboard = \"none\"\n[body]\nextends = \"no.toml\"\n");
  ASSERT_EQ(lost.problems.size(), 1u);
  EXPECT_THAT(to_string(lost.problems[0], lost.robot),
              HasSubstr("robot.toml:5: body.extends: \"no.toml\": a file that"));
}

}  // namespace
}  // namespace sinew::app::extends_test
