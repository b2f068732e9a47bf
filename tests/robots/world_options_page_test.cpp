// docs/reference/world-options.md has exactly the worlds' tables of options.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "robots/robot_kind.hpp"
#include "source_dir.hpp"

namespace sinew::robots::world_options_page_test {
namespace {

constexpr const char* kHead = R"(# Options of the simulated worlds

The test `robots_world_options_page_test` writes this page from the tables of the worlds (`robots/*/devices.hpp`) when
`SINEW_WRITE_DOCS=1` is set; without it the test fails when page and tables differ.

Write a key into the table `[sim]` of a robot file (`gust_mps = 3`), or give it to one run:
`sinew run ... --set sim.gust_mps=3`. `sinew check` knows all keys. `sinew-sim` has the option in the second column. Every
world also has the key `seed`, an integer from 0 up; its default is the robot's seed ([robot-file.md](../robot-file.md)).
The seed decides every value without a default. Choosing such a value changes nothing else that the seed decides.
)";

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

std::string table_of(const plant::WorldInfo& world) {
  std::string text = "\n## `world = \"" + std::string(world.name) + "\"`\n\n";
  if (world.options.empty()) return text + "No options but `seed`.\n";
  text += "| key | option of sinew-sim | allowed | default | meaning |\n|---|---|---|---|---|\n";
  for (const plant::WorldOption& o : world.options)
    text += "| `" + std::string(o.key) + "` | `--" + o.option + "` | " + o.allowed() + " | " +
            (o.value ? number(*o.value) : o.otherwise) + " | " + o.doc + " |\n";
  return text;
}

std::string page() {
  std::string text = kHead;
  for (const RobotKind& robot : all_robots())
    if (*robot.world.name) text += table_of(robot.world);
  return text;
}

TEST(WorldOptionsPage, SaysWhatTheTablesOfTheWorldsSay) {
  const std::string path = test::source_dir() + "/docs/reference/world-options.md";
  if (std::getenv("SINEW_WRITE_DOCS")) std::ofstream(path) << page();
  std::ifstream in(path);
  std::ostringstream is;
  is << in.rdbuf();
  EXPECT_EQ(is.str(), page())
      << "docs/reference/world-options.md differs from the tables; SINEW_WRITE_DOCS=1 writes it";
}

TEST(WorldOptionsPage, EveryOptionHasADefaultWithinItsRangeOrSaysWhereItsValueComesFrom) {
  for (const RobotKind& robot : all_robots()) {
    std::set<std::string> names;
    for (const plant::WorldOption& o : robot.world.options) {
      SCOPED_TRACE(std::string(robot.world.name) + "." + o.key);
      EXPECT_TRUE(names.insert(o.key).second);
      EXPECT_TRUE(names.insert(std::string("--") + o.option).second);
      EXPECT_STRNE(o.doc, "");
      EXPECT_LT(o.least, o.most);
      EXPECT_NE(o.value.has_value(), *o.otherwise != '\0');
      EXPECT_TRUE(!o.value || o.allows(*o.value));
      for (const char* taken : {"plant", "world", "camera_width", "camera_height", "relink_s", "bounds", "seed"})
        EXPECT_STRNE(o.key, taken) << "a key of [sim]";
    }
  }
}

}  // namespace
}  // namespace sinew::robots::world_options_page_test
