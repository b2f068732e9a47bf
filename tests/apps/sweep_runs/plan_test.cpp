#include "apps/sweep_runs/plan.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "apps/module_list.hpp"
#include "apps/sweep/case_text.hpp"
#include "apps/sweep_runs/run_result.hpp"
#include "source_dir.hpp"

namespace sinew::app::plan_test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(SeedRange, TakesRangesAndListsInTheirOrder) {
  std::string why;
  const auto seeds = SeedRange::parse("7,1..3,18446744073709551615", why);
  ASSERT_TRUE(seeds) << why;
  EXPECT_EQ(seeds->count(), 5u);
  std::vector<std::uint64_t> all;
  for (std::uint64_t i = 0; i < seeds->count(); ++i) all.push_back(seeds->at(i));
  EXPECT_THAT(all, ElementsAre(7, 1, 2, 3, UINT64_MAX));
}

TEST(SeedRange, RefusesWhatIsNoSeed) {
  std::string why;
  for (const char* text : {"", "a", "1..", "..2", "1..2..3", "1,", "-1", "2..1", "0..18446744073709551615", "1.5"}) {
    EXPECT_FALSE(SeedRange::parse(text, why)) << text;
    EXPECT_THAT(why, HasSubstr("whole numbers, as 1..1000, 3,5,7 or 1..10,20"));
  }
  EXPECT_FALSE(SeedRange::parse("1..5,5..6", why));
  EXPECT_THAT(why, HasSubstr("seed 5 is named twice"));
}

class Plan : public ::testing::Test {
 protected:
  Plan() { axes_.robots = {test::source_dir() + "/robots/seesaw/seesaw.toml"}; }
  std::unique_ptr<SweepPlan> make() { return SweepPlan::make(axes_, all_modules()); }
  std::string text(SweepPlan& plan, std::uint64_t number) {
    return sweep::joined(plan.words(number)).substr(axes_.robots[0].size());
  }
  SweepAxes axes_;
};

TEST_F(Plan, CombinesAllAxesAndChangesTheSeedMostSlowly) {
  axes_.seeds = "1..3";
  axes_.set = {"balance.stiffness=1:3:3", "balance.damping=1,2"};
  axes_.faults = {"none", "imu:off@5&imu:stuck@6"};
  axes_.duration_s = 2.5;
  const auto plan = make();
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->cases(), 3u * 3 * 2 * 2);
  EXPECT_EQ(text(*plan, 0), " --set balance.stiffness=1 --set balance.damping=1 --duration 2.5 --seed 1");
  EXPECT_EQ(text(*plan, 1),
            " --set balance.stiffness=1 --set balance.damping=1 --fault imu:off@5 --fault imu:stuck@6 "
            "--duration 2.5 --seed 1");
  EXPECT_EQ(text(*plan, 2), " --set balance.stiffness=1 --set balance.damping=2 --duration 2.5 --seed 1");
  EXPECT_EQ(text(*plan, 12), " --set balance.stiffness=1 --set balance.damping=1 --duration 2.5 --seed 2");
}

TEST_F(Plan, WithoutSeedsTheRobotFilesIsFlown) {
  const auto plan = make();
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->cases(), 1u);
  EXPECT_EQ(text(*plan, 0), "");
  EXPECT_FALSE(plan->identity().contains("seeds"));
}

TEST_F(Plan, AMillionCasesTakeNoMemoryAndAnyIsFoundAtOnce) {
  axes_.seeds = "0..999999";
  const auto plan = make();
  ASSERT_TRUE(plan);
  EXPECT_EQ(text(*plan, 999'999), " --seed 999999");
  axes_.set = {"balance.stiffness=1:3:1000"};
  ::testing::internal::CaptureStderr();
  EXPECT_FALSE(make());
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("more than 100000000 runs"));
}

TEST_F(Plan, LinesOfAListAreFoundInAnyOrder) {
  const std::string list = (fs::temp_directory_path() / "list").string();
  {
    std::ofstream out(list);
    for (int i = 0; i < 1000; ++i) out << "# line\n--set balance.stiffness=" << i % 50 << " --seed " << i << "\n\n";
  }
  axes_.list = list;
  const auto plan = make();
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->cases(), 1000u);
  for (const std::uint64_t i : {0, 999, 3, 4, 700, 256, 255})
    EXPECT_THAT(text(*plan, i), HasSubstr(" --seed " + std::to_string(i)));
  fs::remove(list);
}

TEST_F(Plan, TheIdentityChangesWithTheContentsOfFiles) {
  const auto one = make();
  const std::string copy = (fs::temp_directory_path() / "seesaw.toml").string();
  fs::copy_file(axes_.robots[0], copy, fs::copy_options::overwrite_existing);
  const std::string before = axes_.robots[0];
  axes_.robots = {copy};
  const auto same = make();
  std::ofstream(copy, std::ios::app) << "# more\n";
  const auto other = make();
  ASSERT_TRUE(one && same && other);
  EXPECT_EQ(one->identity()["contents"][before], same->identity()["contents"][copy]);
  EXPECT_NE(same->identity()["contents"][copy], other->identity()["contents"][copy]);
  fs::remove(copy);
}

sweep::JobResult job(int code, const std::string& output, const std::string& errors = "") {
  sweep::JobResult result;
  result.code = code, result.output = output, result.errors = errors;
  return result;
}

TEST(RunEnd, TakesTheVerdictOutOfTheSummary) {
  const RunEnd whole = end_of_run(
      "a --seed 1",
      job(1,
          "something else\n"
          R"({"mission":{"outcome":"landed off the pad","good":false,"why":"wind","measures":[{"name":"landing_error_m","value":0.4,"at_most":0.15},{"name":"bad"},{"name":"none","value":null}]},"hashes":{"a":"1"},"recording":{"path":"r"},"exit_code":1})"
          "\n"),
      300);
  EXPECT_EQ(whole.result.outcome, "landed off the pad");
  EXPECT_EQ(whole.result.why, "wind");
  EXPECT_EQ(whole.recording, "r");
  ASSERT_EQ(whole.result.measures.size(), 1u);
  EXPECT_EQ(whole.result.measures[0].limits.at_most, 0.15);
  EXPECT_EQ(whole.result.hash.size(), 16u);
  EXPECT_FALSE(whole.interrupted);
}

TEST(RunEnd, AGoodMissionWhoseTimingDoesNotCountIsBad) {
  const RunEnd end = end_of_run(
      "a", job(1, R"({"mission":{"outcome":"landed","good":true,"why":""},"timing":{"worst":"late"},"exit_code":1})"),
      300);
  EXPECT_EQ(end.result.outcome, "landed, but not valid as a measurement");
  EXPECT_EQ(end.result.why, "late");
  EXPECT_FALSE(end.result.good);
}

TEST(RunEnd, CrashesHangsAndRefusalsAreToldApart) {
  EXPECT_EQ(end_of_run("a", job(139, ""), 300).result.outcome, "crashed: signal 11 (Segmentation fault)");
  sweep::JobResult hung = job(137, "");
  hung.hung = true;
  EXPECT_EQ(end_of_run("a", hung, 2.5).result.outcome, "hung: no end within 2.5 s");
  EXPECT_EQ(end_of_run("a", job(2, "", "sinew: no display"), 300).not_begun, "sinew: no display");
  EXPECT_TRUE(end_of_run("a", job(1, R"({"exit_code":1,"ended_early":{"how":"interrupted"}})"), 300).interrupted);
}

}  // namespace
}  // namespace sinew::app::plan_test
