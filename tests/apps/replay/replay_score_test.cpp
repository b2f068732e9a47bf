#include "apps/replay/replay_score.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace sinew::app::replay_score_test {
namespace {

TEST(ReplayScore, ALineKeepsEveryBitOfIt) {
  ReplayScore score;
  score.now = {7, 0.1 + 0.2, std::numeric_limits<double>::infinity(), rt::Time{INT64_MAX}};
  score.recorded = {UINT64_MAX, -0.0, std::numeric_limits<double>::denorm_min(), rt::Time{-1}};
  score.missing = 3;
  score.stopped = {"a.mcap: filter: \"it\" stopped\nat once", "b.mcap: pad"};
  score.failed = "none";
  const std::string line = to_line(score);
  EXPECT_EQ(line.find('\n'), line.size() - 1);
  const auto again = parse_replay_score("a module's words\n" + line + "{\"replay_score\":7}\n");
  ASSERT_TRUE(again);
  EXPECT_EQ(to_line(*again), line);
  EXPECT_EQ(again->now.sum_of_squares, 0.1 + 0.2);
  EXPECT_EQ(again->now.max, std::numeric_limits<double>::infinity());
  EXPECT_EQ(again->recorded.max_at.ns, -1);
  EXPECT_EQ(again->stopped, score.stopped);
}

TEST(ReplayScore, OtherTextIsNone) {
  EXPECT_FALSE(parse_replay_score(""));
  EXPECT_FALSE(parse_replay_score("{\"replay_score\":{\"now\":[]}}\n[1]\nnothing"));
}

}  // namespace
}  // namespace sinew::app::replay_score_test
