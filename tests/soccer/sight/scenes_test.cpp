// What is seen in rendered scenes that neither training nor tuning saw: a few of those of docs/soccer-vision.md.
#include <gtest/gtest.h>

#include "apps/sight/judge.hpp"
#include "apps/toml/body_reader.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::sight::scenes_test {
namespace {

TEST(SoccerSightScenes, AreSeenAsTheyAreInLightThatNoTuningSaw) {
  const app::LoadedBody op3 = app::load_body(test::source_dir() + "/robots/kid/op3.toml");
  ASSERT_TRUE(op3.problems.empty());
  SceneMaker maker(op3.body, {.lighting = Lighting::unseen, .seed = 4711});
  Judgement j;
  judge(maker, 0, 30, {}, j);
  const auto ball = j.at_confidence(0.5);
  std::printf("%s", report(j).c_str());
  EXPECT_GT(j.pictures, 15u);
  EXPECT_GT(ball.recall.all, 3u);
  EXPECT_GE(ball.recall.value(), 0.75);
  EXPECT_GE(ball.precision.value(), 0.9);
  EXPECT_GE(j.lines_right.value(), 0.85);
  EXPECT_GE(j.line_length.value(), 0.7);
  EXPECT_GE(j.borders_right.value(), 0.85);
}

}  // namespace
}  // namespace sinew::sight::scenes_test
