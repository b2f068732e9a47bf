#include "apps/search/case.hpp"

#include <gmock/gmock.h>

#include "apps/search/exec_profile.hpp"
#include "apps/search/generate.hpp"
#include "apps/search/limits.hpp"
#include "apps/search/outcome_text.hpp"

namespace sinew::search::case_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

const std::vector<std::string> kModules = {"filter", "imu", "mixer", "pad"};

Case parsed(std::string_view text) {
  std::string why;
  const auto c = parse_case(text, why);
  EXPECT_TRUE(c) << why;
  return c.value_or(Case{});
}

std::string problem_of(std::string_view text) {
  std::string why;
  EXPECT_FALSE(parse_case(text, why)) << text;
  return why;
}

TEST(Case, EveryWordOfItsTextIsTaken) {
  const Case c =
      parsed("world=77 jitter=12 gust=1.5 stress=pad*2.5 fault=imu:off@5.003+0.001 fault=camera:delayed(80ms)@3+2");
  EXPECT_EQ(c.world, 77u);
  EXPECT_EQ(c.jitter, 12u);
  EXPECT_EQ(c.gust_mps, 1.5);
  EXPECT_EQ(c.stress_of("pad"), 2.5);
  EXPECT_EQ(c.stress_of("imu"), 1.0);
  ASSERT_EQ(c.faults.size(), 2u);
  EXPECT_EQ(c.faults[0], (Fault{"imu", "off", 0, Time{5'003'000'000}, 1ms}));
  EXPECT_EQ(c.faults[1], (Fault{"camera", "delayed", 80, Time{3'000'000'000}, 2s}));
  EXPECT_TRUE(parsed("jitter=none").nominal);
}

TEST(Case, TheTextOfEveryGeneratedCaseReadsBackAsTheSameCase) {
  std::size_t faults = 0, stressed = 0, calm = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    const Case c = generate(seed, kModules);
    EXPECT_EQ(parsed(to_string(c)), c) << to_string(c);
    faults += c.faults.size();
    stressed += !c.stress.empty();
    calm += c.faults.empty();
  }
  EXPECT_GT(faults, 5000u);
  EXPECT_GT(stressed, 1000u);
  EXPECT_GT(calm, 800u);
}

TEST(Case, ASeedGivesOneCaseAndAnotherSeedAnother) {
  EXPECT_EQ(generate(5, kModules), generate(5, kModules));
  EXPECT_NE(generate(5, kModules), generate(6, kModules));
  EXPECT_NE(case_seed(1, 0), case_seed(1, 1));
  EXPECT_NE(case_seed(1, 0), case_seed(2, 0));
}

TEST(Case, WhatIsWrongIsNamedWithWhatIsAllowed) {
  EXPECT_EQ(problem_of("world=x"), "case: world=x: a whole number");
  EXPECT_EQ(problem_of("gust=99"), "case: gust=99: a number from 0 to 15");
  EXPECT_EQ(problem_of("stress=pad"), "case: stress=pad: MODULE*FACTOR, a factor from 0.01 to 1000");
  EXPECT_EQ(problem_of("wind=2"), "case: wind=2: one of world, jitter, gust, stress, fault");
  for (const char* fault : {"imu:off", "imu@3+1", "imu:off@3", "imu:off@3+0", "imu:off@x+1", ":off@1+1", "imu:@1+1",
                            "imu:delayed(5)@1+1", "imu:delayed(5ms@1+1", "imu:off@-1+1"})
    EXPECT_THAT(problem_of(std::string("fault=") + fault), HasSubstr("DEVICE:KIND[(AMOUNT)]@FROM+LENGTH")) << fault;
}

TEST(Case, IsDisturbedFromTheOnsetUntilSomeTimeAfterTheEnd) {
  const Case c = parsed("fault=imu:off@5+0.1");
  EXPECT_FALSE(c.disturbed(Time{4'999'999'999}, 1s));
  EXPECT_TRUE(c.disturbed(Time{5'000'000'000}, 1s));
  EXPECT_TRUE(c.disturbed(Time{6'099'999'999}, 1s));
  EXPECT_FALSE(c.disturbed(Time{6'100'000'000}, 1s));
}

TEST(Excuses, AreOnlyForWhatTheFailsafesCannotCarryOver) {
  const auto of = [](const char* text) { return excuses(parsed(text), {}); };
  EXPECT_FALSE(of("gust=2 stress=filter*4").elsewhere);
  EXPECT_FALSE(of("fault=imu:off@5+0.005").elsewhere);
  EXPECT_FALSE(of("fault=imu:duplicated@5+3").elsewhere);
  EXPECT_TRUE(of("fault=imu:off@5+0.03").failsafe);
  EXPECT_TRUE(of("fault=imu:off@5+0.005 fault=imu:off@5.006+0.005").failsafe) << "two short ones may make a long one";
  EXPECT_FALSE(of("fault=imu:off@5+0.005 fault=imu:off@9+0.005").failsafe);
  EXPECT_TRUE(of("fault=motors:off@5+0.03").failsafe);
  EXPECT_FALSE(of("fault=camera:off@5+0.5").elsewhere);
  EXPECT_TRUE(of("fault=camera:off@5+3").elsewhere);
  EXPECT_FALSE(of("fault=camera:off@5+3").failsafe);
  EXPECT_TRUE(of("fault=range:stuck@5+0.1").elsewhere);
}

TEST(Excuses, KnowHowSoonAFailsafeOfTheRobotFileActs) {
  rt::FailsafeSpec lost;
  lost.topic.value = "camera.raw";
  lost.time = 500ms;
  EXPECT_TRUE(excuses(parsed("fault=camera:off@5+0.6"), {lost}).elsewhere);
  EXPECT_FALSE(excuses(parsed("fault=camera:off@5+0.6"), {}).elsewhere);
  EXPECT_FALSE(excuses(parsed("fault=camera:off@5+0.35"), {lost}).elsewhere);
}

TEST(ExecProfile, WhatItWritesItReads) {
  ExecProfile profile;
  profile.measured = "today";
  std::vector<rt::Duration> samples;
  for (int i = 1; i <= 10000; ++i) samples.push_back(rt::Duration{i});
  profile.module["imu"] = model_of(samples);
  std::vector<rt::Problem> problems;
  const ExecProfile read = parse_profile(to_text(profile), "p.toml", problems);
  ASSERT_TRUE(problems.empty()) << rt::to_string(problems[0], "p.toml");
  EXPECT_EQ(read.measured, "today");
  const auto &a = profile.module["imu"].quantiles, &b = read.module.at("imu").quantiles;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].share, b[i].share);
    EXPECT_EQ(a[i].exec, b[i].exec);
  }
  EXPECT_EQ(a.back().exec, 10000ns);
  EXPECT_NEAR(static_cast<double>(a[2].exec.count()), 5000, 1) << "the median";
}

TEST(ExecProfile, TheRobotFilesExecutionTimeStaysThe99thPercentile) {
  ExecProfile profile;
  profile.module["imu"].kind = rt::ExecModel::Kind::quantiles;
  profile.module["imu"].quantiles = {{0.5, 1us}, {0.99, 2us}, {1.0, 10us}};
  profile.module["other"] = profile.module["imu"];
  rt::GraphSpec graph;
  graph.modules.push_back({.name = "imu", .exec = {rt::ExecModel::Kind::constant, 20us, {}, 1.0}});
  EXPECT_THAT(profile.apply(graph, [](const std::string&) { return 3.0; }), testing::ElementsAre("other"));
  EXPECT_EQ(graph.modules[0].exec.kind, rt::ExecModel::Kind::quantiles);
  EXPECT_EQ(graph.modules[0].exec.factor, 30.0);
}

TEST(ExecProfile, ProblemsAreNamed) {
  std::vector<rt::Problem> problems;
  parse_profile("measured = 3\n[module]\nimu = { exec_us = 3 }\n", "p.toml", problems);
  ASSERT_EQ(problems.size(), 2u);
  EXPECT_EQ(rt::to_string(problems[1], "p.toml"), "p.toml:3: module.imu.exec_quantiles_us: missing: it is required");
}

TEST(Outcome, ReadsBackFromItsLine) {
  Outcome o;
  o.violation = Violation{"tilt", Time{1'500'000'000}, "0.90 rad, \"at most\" 0.80"};
  o.ending = Ending::crashed;
  o.worst = {0.9, 0.01, 0.02};
  o.worst_age_ms["imu_to_motors"] = 5.5;
  o.hash = 0xFEDCBA9876543210u;
  const auto read = parse_outcome(to_json(Case{}, o));
  ASSERT_TRUE(read);
  ASSERT_TRUE(read->violation);
  EXPECT_EQ(read->violation->invariant, "tilt");
  EXPECT_EQ(read->violation->at, o.violation->at);
  EXPECT_EQ(read->violation->what, o.violation->what);
  EXPECT_EQ(read->ending, o.ending);
  EXPECT_EQ(read->worst.tilt_rad, 0.9);
  EXPECT_EQ(read->worst_age_ms, o.worst_age_ms);
  EXPECT_EQ(read->hash, o.hash);
  EXPECT_FALSE(parse_outcome("sinew-sim: no camera"));
  EXPECT_FALSE(parse_outcome("{\"failed\":null}"));
}

}  // namespace
}  // namespace sinew::search::case_test
