// A robot file that extends another one.
#include "apps/robot_file/extends.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "apps/robot_file/robot_file.hpp"

namespace sinew::app::extends_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

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

TEST_F(Extends, WhatIsWrongIsNamedWithItsFile) {
  const auto problem = [&](const std::string& text) {
    const LoadedRobot loaded = load(text);
    return loaded.problems.empty() ? "none" : rt::to_string(loaded.problems[0], "robot.toml");
  };
  EXPECT_THAT(problem("\nextends = \"nowhere.toml\""),
              HasSubstr("robot.toml:2: extends: \"nowhere.toml\": a robot file that can be read"));
  EXPECT_THAT(problem("extends = 5"), HasSubstr("robot.toml:1: extends: : the path of another robot file"));
  EXPECT_THAT(problem("extends = \"robot.toml\""), HasSubstr("they go in a circle"));
  EXPECT_THAT(problem("extends = \"below/base.toml\"\nwithout = [\"module.z\"]"), HasSubstr("without: \"module.z\""));
  EXPECT_THAT(problem("extends = \"below/base.toml\"\nwithout = 3"), HasSubstr("without: : an array"));
  write("below/broken.toml", "[robot\n");
  EXPECT_THAT(problem("extends = \"below/broken.toml\""), HasSubstr("below/broken.toml:1: "));
}

}  // namespace
}  // namespace sinew::app::extends_test
