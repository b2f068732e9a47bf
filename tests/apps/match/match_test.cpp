#include <gmock/gmock.h>

#include "apps/match/match_study.hpp"
#include "apps/match/players.hpp"

namespace sinew::app::match_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

sweep::CaseResult match(int goals_a, int goals_b, bool good = true) {
  sweep::CaseResult r;
  r.good = good;
  r.measures = {{"goals_a", static_cast<double>(goals_a), {}}, {"goals_b", static_cast<double>(goals_b), {}}};
  return r;
}

std::vector<sweep::CaseResult> matches(int won, int drawn, int lost) {
  std::vector<sweep::CaseResult> all;
  for (int i = 0; i < won; ++i) all.push_back(match(2, 0));
  for (int i = 0; i < drawn; ++i) all.push_back(match(1, 1));
  for (int i = 0; i < lost; ++i) all.push_back(match(0, 1));
  return all;
}

TEST(MatchStatistics, CountPointsAndGoalsOfFinishedMatchesOnly) {
  auto all = matches(3, 2, 1);
  all.push_back(match(9, 0, false));
  const MatchStatistics s = statistics_of(all);
  EXPECT_EQ(s.matches, 7u);
  EXPECT_EQ(s.unfinished, 1u);
  EXPECT_EQ(s.won, 3u);
  EXPECT_EQ(s.drawn, 2u);
  EXPECT_EQ(s.lost, 1u);
  EXPECT_DOUBLE_EQ(s.points.mean, 4.0 / 6);
  EXPECT_NEAR(s.goal_difference.mean, 5.0 / 6, 1e-12);
}

TEST(MatchStatistics, IntervalsHaveTheWidthThatTheirSpreadGives) {
  // 60 of 100 with the variance of a coin: half the interval is 1.96 * sqrt(0.6 * 0.4 / 100) = 0.096.
  const MatchStatistics s = statistics_of(matches(60, 0, 40));
  EXPECT_NEAR(s.points.low, 0.504, 0.011);
  EXPECT_NEAR(s.points.high, 0.696, 0.011);
  EXPECT_LT(s.goal_difference.low, s.goal_difference.mean);
}

TEST(MatchStatistics, SayWhichTeamIsBetterOnlyWhereChanceDoesNotExplainIt) {
  EXPECT_THAT(verdict_text(statistics_of(matches(70, 10, 20))), HasSubstr("A is better"));
  EXPECT_THAT(verdict_text(statistics_of(matches(20, 10, 70))), HasSubstr("B is better"));
  EXPECT_THAT(verdict_text(statistics_of(matches(52, 0, 48))), HasSubstr("do not show which team is better"));
  EXPECT_THAT(verdict_text(statistics_of(matches(3, 0, 0))), HasSubstr("do not show which team is better"))
      << "three wins say nothing, although no bootstrap of them has anything else";
  EXPECT_EQ(verdict_text(statistics_of({})), "no match was played to its end\n");
}

TEST(Players, ChangeSidesWithTheSeedAndStartOnTheirOwnHalf) {
  MatchOptions options;
  options.teams = {"one.toml", "two.toml"};
  options.robots = 3;
  options.seed = 1;
  const auto odd = players_of(options);
  ASSERT_EQ(odd.size(), 6u);
  EXPECT_EQ(odd[0].name, "blue1");
  EXPECT_EQ(odd[0].team, 0u);
  EXPECT_EQ(odd[5].name, "red3");
  EXPECT_EQ(odd[5].team, 1u);
  options.seed = 2;
  EXPECT_EQ(players_of(options)[0].team, 1u);
  RobotFile robot;
  for (const Player& p : odd) {
    const std::string text = player_text(options, p, "/a/one.toml", robot, {"play"});
    EXPECT_THAT(text, HasSubstr("extends = \"/a/one.toml\""));
    EXPECT_THAT(text, HasSubstr(p.colour == 0 ? "start_x_m = -" : "start_x_m = ")) << p.name;
    EXPECT_THAT(text, HasSubstr("referee_half_s = 300"));
    EXPECT_THAT(text, HasSubstr("[module.play.params]\nplayer = " + std::to_string(p.number) + "\n"));
  }
}

TEST(Players, ALieIsSaidAsAFaultAndBecomesSettingsOfTheModuleThatReports) {
  std::string why;
  EXPECT_THAT(lie_settings("report:wrong(2.5)@60+10", "team", why),
              ElementsAre("team.lie_m=2.5", "team.lie_from_s=60", "team.lie_for_s=10"));
  EXPECT_THAT(lie_settings("report:wrong@5..8", "mates", why),
              ElementsAre("mates.lie_m=3", "mates.lie_from_s=5", "mates.lie_for_s=3"));
  EXPECT_THAT(lie_settings("report:wrong@5", "team", why).back(), "team.lie_for_s=1000000");
  EXPECT_EQ(why, "");
  EXPECT_THAT(lie_settings("report:off@5", "team", why), testing::IsEmpty());
  EXPECT_THAT(why, HasSubstr("a report can be wrong and nothing else"));
  EXPECT_THAT(lie_settings("report:wrong(300)@5", "team", why), testing::IsEmpty());
  EXPECT_EQ(why, "fault 'report:wrong(300)@5': amount '300': m added, -10 to 10");
  EXPECT_THAT(lie_settings("report:wrong(3)@-1", "team", why), testing::IsEmpty());
  EXPECT_THAT(why, HasSubstr("FROM+LENGTH"));
  EXPECT_TRUE(is_lie("report:wrong@5"));
  EXPECT_FALSE(is_lie("radio:wrong@5"));
}

TEST(Players, AreRecordedWithoutTheThreadsThatRunAHundredTimesASecond) {
  rt::GraphSpec graph;
  const auto thread = [&](const char* name, rt::Duration period, const char* module, const char* topic) {
    rt::ThreadSpec& t = graph.threads.emplace_back();
    t.name = name;
    t.trigger = topic ? rt::ThreadSpec::Trigger::topics : rt::ThreadSpec::Trigger::period;
    t.period = period;
    if (topic) t.topics.push_back({topic, 0});
    t.order.push_back({module, 0});
  };
  using namespace std::chrono_literals;
  thread("gait", 8ms, "mover", nullptr);
  thread("poses", {}, "pose", "mover.gait");
  thread("sight", {}, "sight", "pose.pose");
  thread("play", 50ms, "play", nullptr);
  EXPECT_THAT(slow_threads(graph), ElementsAre("sight", "play"));
}

}  // namespace
}  // namespace sinew::app::match_test
