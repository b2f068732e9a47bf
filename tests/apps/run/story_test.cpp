// How a run is told at its end: the time line, the two verdicts, the cause of a miss.
#include "apps/flight/story.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <optional>

#include "apps/flight/estimate_error.hpp"
#include "apps/robot_file/validity.hpp"
#include "apps/run/miss_cause.hpp"
#include "apps/run/run_summary.hpp"
#include "apps/view/status_table.hpp"

namespace sinew::app::story_test {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;
using Weight = Story::Weight;

TEST(Story, LinesAreInTheOrderOfTimeWhateverCameFirst) {
  Story story;
  story.add(8.52, Weight::result, "camera_lost: camera.raw silent for 500 ms -> land");
  story.add(0, Weight::detail, "waiting");
  EXPECT_THAT(story.lines(10),
              ElementsAre("    0.0 s  waiting", "    8.5 s  camera_lost: camera.raw silent for 500 ms -> land"));
}

TEST(Story, LeavesOutWhatSaysLeastFromTheMiddleAndSaysHowMuch) {
  Story story;
  for (int i = 0; i < 6; ++i) {
    story.add(i, Weight::phase, "phase " + std::to_string(i));
    story.add(i, Weight::detail, "detail");
  }
  story.add(3, Weight::result, "stop");
  EXPECT_THAT(story.lines(6),
              ElementsAre("    0.0 s  phase 0", "    1.0 s  phase 1", "    3.0 s  stop", "    4.0 s  phase 4",
                          "    5.0 s  phase 5", "           8 more between them: --verbose"));
  EXPECT_THAT(story.lines(13), SizeIs(13));
}

TEST(Story, OfEndlessEventsTheResultsAndBothEndsAreKept) {
  Story story;
  story.add(0, Weight::result, "armed");
  for (int i = 0; i < 5000; ++i) story.add(i, Weight::phase, std::to_string(i));
  const auto lines = story.lines(10);
  ASSERT_THAT(lines, SizeIs(10));
  EXPECT_EQ(lines[0], "    0.0 s  armed");
  EXPECT_EQ(lines[1], "    0.0 s  0");
  EXPECT_EQ(lines[8], " 4999.0 s  4999");
  EXPECT_EQ(lines[9], "           4992 more between them: --verbose");
  EXPECT_LE(story.events().size(), Story::kMost);
}

TEST(EstimateError, ComparesFromTheFirstValidPairOnWhateverTheWorldsBeginWith) {
  EstimateError error;
  msg::NavState estimate, truth;
  truth.p_world_m = {5, 5, 0};
  truth.q_world_base = {0.7071067811865476, 0, 0, 0.7071067811865476};  // looks along y, the estimator says x
  error.add(estimate, truth);
  EXPECT_FALSE(error.result()) << "nothing is valid yet";
  estimate.q_world_base = {1, 0, 0, 0};
  estimate.attitude_valid = estimate.position_valid = 1;
  error.add(estimate, truth);
  truth.p_world_m = {5, 7, 0};  // two metres straight on
  estimate.p_world_m = {1.7, 0.4, 0};
  error.add(estimate, truth);
  ASSERT_TRUE(error.result());
  EXPECT_NEAR(error.result()->last_m, 0.5, 1e-9);
  estimate.p_world_m = {2, 0, 0};
  error.add(estimate, truth);
  EXPECT_NEAR(error.result()->last_m, 0, 1e-9);
  EXPECT_NEAR(error.result()->worst_m, 0.5, 1e-9);
}

// ---- why an outcome is not good

WorldReport missed_by_wind() {
  return *parse_report(R"({"valid":true,"verdict":{"outcome":"landed off the pad","good":false,
      "measures":[{"key":"e","label":"landing error","unit":"m","value":0.412,"at_most":0.15},
                  {"key":"v","label":"touchdown speed","unit":"m/s","value":0.3,"at_most":0.5}],
      "conditions":[{"key":"w","label":"strongest wind","unit":"m/s","value":3.44,"at_most":2}]}})");
}

TEST(MissCause, IsWhatIsFarthestBeyondItsLimit) {
  const WorldReport report = missed_by_wind();
  MissEvidence e{.report = &report, .saturated = 0.012};
  EXPECT_EQ(miss_cause(e), "landing error 0.412 m (at most 0.15); strongest wind 3.44 m/s (at most 2)");
  e.saturated = 0.05;
  EXPECT_EQ(miss_cause(e), "landing error 0.412 m (at most 0.15); actuators at a limit 5 % of the time (at most 1)");
  e.estimate = EstimateError::Result{.worst_m = 0.9, .last_m = 0.1};
  EXPECT_THAT(miss_cause(e), EndsWith("; estimate off by up to 0.9 m (at most 0.1)"));
}

TEST(MissCause, IsAFailsafeBeforeAFaultBeforeAnyCondition) {
  WorldReport report = missed_by_wind();
  report.faults = {{.text = "imu:off@9", .device = "imu"}, {.text = "baro:off@1", .device = "baro", .affected = 7}};
  MissEvidence e{.report = &report};
  EXPECT_THAT(miss_cause(e), EndsWith("; fault baro:off@1 struck 7 times"));
  e.failsafes = {"camera_lost", "range_lost"};
  EXPECT_THAT(miss_cause(e), EndsWith("; failsafe camera_lost acted"));
}

TEST(MissCause, SaysWhatWasMeasuredWhereNothingIsBeyondItsLimit) {
  WorldReport report = missed_by_wind();
  report.verdict->measures.clear();
  report.verdict->conditions[0].value = 1;
  EXPECT_EQ(
      miss_cause({.report = &report, .unfinished = "climbing", .ended_s = 3, .saturated = 0.0}),
      "the run ended after 3.0 s while climbing; all conditions were within their limits: strongest wind 1 m/s (at "
      "most 2), actuators at a limit 0 % of the time (at most 1)");
  EXPECT_EQ(miss_cause({}), "neither the simulator nor the robot measured any condition");
}

TEST(MissCause, OfAMissionThatSomebodyEndedIsNoneOnlyThePhaseItWasIn) {
  WorldReport report = missed_by_wind();
  MissEvidence e{.report = &report, .unfinished = "climbing", .ended_early = "interrupted", .ended_s = 5.2};
  e.failsafes = {"camera_lost"};
  EXPECT_EQ(miss_cause(e), "interrupted while climbing");
  e.unfinished.clear();  // its mission was done before
  EXPECT_EQ(miss_cause(e), "landing error 0.412 m (at most 0.15); failsafe camera_lost acted");
}

TEST(MissCause, CountsLateFramesInRealTimeOnly) {
  const WorldReport report = *parse_report(R"({"valid":true,"frames":90,"render_late":10,"verdict":{"good":false}})");
  EXPECT_EQ(miss_cause({.report = &report, .real_time = true}), "frames late 10 % (at most 1)");
  EXPECT_EQ(miss_cause({.report = &report}), "neither the simulator nor the robot measured any condition");
}

// ---- two verdicts

class Told : public ::testing::Test {
 protected:
  int finish(std::string_view outcome, int code) {
    summary().before_print([this](const RunSummary::Result& result) { end_ = result.end; });
    ::testing::internal::CaptureStdout();
    const int exit_code = summary().finish(outcome, code);
    out_ = ::testing::internal::GetCapturedStdout();
    return exit_code;
  }
  RunSummary& summary() {
    if (!graph_) graph_.emplace(rt::GraphSpec{}, rt::ModuleTypes{});
    if (!summary_) summary_.emplace(*graph_, virtual_, form_);
    return *summary_;
  }
  static TimingVerdict bad_timing() {
    return {.reasons = {"plant: 3.10 ms", "range: late", "imu: late"},
            .worst = "plant: 3.10 ms (at most 2)",
            .what_to_do = "buy a better one"};
  }
  std::optional<rt::Graph> graph_;
  std::optional<RunSummary> summary_;
  RunSummary::Form form_;
  bool virtual_ = false;
  std::string out_, end_;  // what is printed; what the recording says of the end
};

TEST_F(Told, TheMissionMakesTheExitCodeAndTheTimingIsOneLine) {
  summary().timing(bad_timing());
  summary().measure({"landing_error_m", "landing error", "m", 0.04, 0.15, {}});
  EXPECT_EQ(finish("landed on the pad", 0), 0);
  EXPECT_EQ(end_, "over");
  EXPECT_EQ(out_,
            "mission   landed on the pad: landing error 0.04 m (at most 0.15)\n"
            "timing    not valid as a measurement: plant: 3.10 ms (at most 2); buy a better one; 2 more reasons: "
            "--verbose\n"
            "next      --verbose prints threads, modules, topics and hashes, too\n");
}

TEST_F(Told, StrictMakesBothCount) {
  form_.strict = true;
  summary().timing(bad_timing());
  EXPECT_EQ(finish("landed on the pad", 0), 1);
  EXPECT_THAT(out_, HasSubstr("mission   landed on the pad\n")) << "the mission is what it was";
}

TEST_F(Told, InVirtualTimeNoMachineDisturbsSoBothCount) {
  virtual_ = true;
  summary().timing({.reasons = {"imu: 3 samples lost"}, .worst = "imu: 3 samples lost (at most 0)"});
  EXPECT_EQ(finish("landed on the pad", 0), 1);
  EXPECT_THAT(out_, HasSubstr("timing    not valid as a measurement: imu: 3 samples lost (at most 0)\n"));
}

TEST_F(Told, QuietIsTheMissionsLineOnly) {
  form_.quiet = true;
  summary().story().add(1, Weight::result, "stop");
  summary().why("wind");
  EXPECT_EQ(finish("crashed", 1), 1);
  EXPECT_EQ(out_, "mission   crashed\n");
}

TEST_F(Told, AtMostFifteenLinesWhateverHappened) {
  for (int i = 0; i < 99; ++i) summary().story().add(i, Weight::result, "stop");
  for (int i = 0; i < 99; ++i) summary().add("table", "of the length of a book", Json::object());
  summary().timing(bad_timing());
  summary().why("wind");
  summary().recorded("runs/a/run.mcap", "1 MB");
  summary().recorded("runs/b/run.mcap", "2 MB");
  summary().again("sinew sweep robot.toml --seeds 7");
  finish("crashed", 1);
  EXPECT_EQ(std::ranges::count(out_, '\n'), static_cast<std::ptrdiff_t>(RunSummary::kMostLines)) << out_;
  EXPECT_THAT(
      out_,
      HasSubstr(
          "why       wind\nagain     sinew sweep robot.toml --seeds 7\nrecorded  the last: runs/b/run.mcap, 2 MB\n"
          "next      `sinew bag info runs/b/run.mcap`"));
}

TEST_F(Told, WhatRepeatsARunStandsOnlyWhereItWentWrongByItself) {
  summary().again("sinew sweep robot.toml --seeds 7");
  finish("landed", 0);
  EXPECT_THAT(out_, Not(HasSubstr("again")));
  summary_.reset();
  summary().again("sinew sweep robot.toml --seeds 7");
  summary().ended_early("interrupted", 3);
  finish("did not land", 1);
  EXPECT_THAT(out_, Not(HasSubstr("again")));
}

TEST_F(Told, VerboseHasTheWholeTimeLineAndEveryTable) {
  form_.verbose = true;
  for (int i = 0; i < 30; ++i) summary().story().add(i, Weight::result, "stop");
  summary().add("memory", "3.1 MB", Json::object());
  summary().timing(bad_timing());
  finish("crashed", 1);
  EXPECT_THAT(out_, HasSubstr("   29.0 s  stop\n\nmemory              3.1 MB\n"));
  EXPECT_THAT(out_, HasSubstr("invalid             plant: 3.10 ms\ninvalid             range: late\n"));
  EXPECT_THAT(out_, EndsWith("result              crashed, invalid run\n"));
}

TEST_F(Told, JsonHasBothVerdictsAndTheStory) {
  form_.json = true;
  summary().story().add(1.5, Weight::phase, "climbing");
  summary().timing(bad_timing());
  summary().measure({"landing_error_m", "landing error", "m", 0.04, 0.15, {}});
  summary().measure({"height_m", "height", "m", 1.5, {}, 2.0});
  EXPECT_EQ(finish("landed on the pad", 0), 0);
  const Json all = Json::parse(out_);
  EXPECT_EQ(all["mission"], Json::parse(R"({"outcome":"landed on the pad","good":true,"why":"","measures":[
      {"name":"landing_error_m","label":"landing error","value":0.04,"unit":"m","at_most":0.15,"ok":true},
      {"name":"height_m","label":"height","value":1.5,"unit":"m","at_least":2.0,"ok":false}]})"));
  EXPECT_EQ(all["timing"]["valid"], false);
  EXPECT_EQ(all["timing"]["worst"], "plant: 3.10 ms (at most 2)");
  EXPECT_EQ(all["timing"]["what_to_do"], "buy a better one");
  EXPECT_EQ(all["story"], Json::parse(R"([{"at_s":1.5,"text":"climbing"}])"));
  EXPECT_EQ(all["result"], "landed on the pad, invalid run");
  EXPECT_EQ(all["exit_code"], 0);
  EXPECT_THAT(all["invalid_because"], SizeIs(3));
}

TEST_F(Told, ARunThatLostItsWorldIsNeitherAMissionNorAMeasurement) {
  summary().why("the run ended while climbing");
  summary().measure({"landing_error_m", "landing error", "m", 0.04, 0.15, {}});
  summary().lost("the simulator died (signal 9)", 15.23, "signal 9 (Killed)");
  EXPECT_EQ(finish("landed on the pad", 0), 1);
  EXPECT_EQ(end_, "the simulator died (signal 9)");
  EXPECT_EQ(out_,
            "mission   landed on the pad, but the simulator died (signal 9) at 15.2 s: landing error 0.04 m (at most "
            "0.15)\n"
            "timing    not valid as a measurement: the simulator died (signal 9) at 15.2 s\n"
            "   15.2 s  the simulator died (signal 9)\n"
            "why       signal 9 (Killed)\n"
            "next      --verbose prints threads, modules, topics and hashes, too\n");
  summary_.reset();
  form_.json = true;
  summary().lost("the simulator died (signal 9)", 15.23, "");
  EXPECT_EQ(finish("", 0), 1);
  const Json all = Json::parse(out_);
  EXPECT_EQ(all["result"], "the simulator died (signal 9) at 15.2 s, invalid run");
  EXPECT_EQ(all["lost"]["at_s"], 15.23);
  EXPECT_EQ(all["mission"]["good"], false);
}

TEST_F(Told, AnInterruptedRunSaysWhenAndIsJudgedByWhatItReached) {
  summary().ended_early("interrupted", 8.21);
  EXPECT_EQ(finish("did not land", 1), 1);
  EXPECT_THAT(out_, HasSubstr("mission   did not land, interrupted at 8.2 s\n"));
  EXPECT_EQ(end_, "interrupted");
  summary_.reset();
  summary().ended_early("stopped", 8.21);
  EXPECT_EQ(finish("", 0), 0) << "for a robot without a mission that is the ordinary end";
  EXPECT_THAT(out_, HasSubstr("mission   stopped at 8.2 s\n"));
  EXPECT_EQ(end_, "stopped");
}

TEST(Timing, WorstReasonIsTheOneFarthestBeyondItsBound) {
  std::vector<Finding> findings{{"plant_gap_ms", "a", 1.5, 2, true}};
  EXPECT_EQ(worst_of(findings), nullptr);
  findings.push_back({"plant_gap_ms", "b", 3, 2, false});
  findings.push_back({"missed_percent", "c", 0.3, 0.1, false});
  EXPECT_EQ(worst_of(findings)->what, "c");
  findings.push_back({"lost", "d", 7, 0, false});
  EXPECT_EQ(worst_of(findings)->what, "d");
  findings.push_back({"plant", "e", 1, 0, false});
  EXPECT_EQ(worst_of(findings)->what, "e") << "the plant's own word comes first";
  EXPECT_THAT(what_to_do(findings[1], true, "quad.toml"), HasSubstr("`sinew doctor quad.toml`"));
  EXPECT_THAT(what_to_do(findings[3], false, "quad.toml"), Not(HasSubstr("machine"))) << "virtual time has none";
}

// ---- the live table

StatusRows counted(std::uint64_t cycles) {
  StatusRows rows;
  rows.threads = {{.name = "fast", .cycles = cycles}};
  return rows;
}

TEST(StatusTable, RatesAreOfTheLastSecondHoweverOftenItIsDrawn) {
  StatusTable table;
  const auto at = [](double s) { return rt::Time{static_cast<std::int64_t>(s * 1e9)}; };
  EXPECT_THAT(table.render(counted(0), at(10), 0), HasSubstr("fast" + std::string(29, ' ') + "- "));
  EXPECT_THAT(table.render(counted(80), at(10.2), 0), HasSubstr(" 400 Hz")) << "the first second is a short one";
  for (int i = 2; i <= 5; ++i) table.render(counted(80), at(10 + 0.2 * i), 0);
  for (int i = 6; i < 20; ++i) table.render(counted(80 + 200 * (i - 5)), at(10 + 0.2 * i), 0);
  EXPECT_THAT(table.render(counted(80 + 200 * 15), at(14), 0), HasSubstr(" 1000 Hz")) << "not the average of all";
  EXPECT_THAT(table.render(counted(80 + 200 * 15 + 5000), at(24), 0), HasSubstr(" 500 Hz")) << "rarely drawn";
}

}  // namespace
}  // namespace sinew::app::story_test
