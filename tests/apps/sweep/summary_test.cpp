#include "apps/sweep/summary.hpp"

#include <gmock/gmock.h>

#include <filesystem>

#include "apps/sweep/case_text.hpp"
#include "apps/sweep/comparison.hpp"
#include "apps/sweep/results_file.hpp"

namespace sinew::sweep::summary_test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

CaseResult landed(std::uint64_t number, double error_m, const std::string& options = "quad.toml") {
  CaseResult r{number, options + " --seed " + std::to_string(number), 0, error_m <= 0.15, "landed on the pad", "", "ab",
               {}};
  r.measures = {{"landing_error_m", error_m, {0.15, {}}}, {"flight_s", 20 + error_m, {}}};
  if (!r.good) r.code = 1, r.outcome = "landed off the pad", r.why = "landing error";
  return r;
}

TEST(CaseText, IsReadAsAShellReadsIt) {
  const std::vector<std::string> words{"quad.toml", "--fault", "imu:off@5&range:stuck@6", "--set", "a.b=it's", ""};
  EXPECT_EQ(joined(words), "quad.toml --fault 'imu:off@5&range:stuck@6' --set 'a.b=it'\"'\"'s' ''");
  EXPECT_EQ(split_words(joined(words)), words);
  EXPECT_EQ(split_words("  a\t\"b c\"d 'e' "), (std::vector<std::string>{"a", "b cd", "e"}));
  EXPECT_FALSE(split_words("a 'b"));
}

TEST(CaseText, ItsSeedIsToldFromTheRest) {
  const std::string run = "quad.toml --set a.b=1 --seed 7 --camera 64x48";
  EXPECT_EQ(seed_of(run), "7");
  EXPECT_EQ(without_seed(run), "quad.toml --set a.b=1 --camera 64x48");
  EXPECT_THAT(parts_of(run), ElementsAre("quad.toml", "--set a.b=1", "--seed 7", "--camera 64x48"));
  EXPECT_FALSE(seed_of("quad.toml"));
}

TEST(CaseResult, SurvivesItsLine) {
  CaseResult r = landed(3, 0.2);
  r.report = {{"at_rest", true}, {"pad_distance_m", 0.2}, {"faults", {{{"device", "imu"}, {"affected", 3}}}}};
  const CaseResult back = case_result(3, to_json(r));
  EXPECT_EQ(app::to_line(to_json(back)), app::to_line(to_json(r)));
  EXPECT_EQ(back.report, r.report);
  EXPECT_FALSE(back.measures[0].within());
  EXPECT_TRUE(back.measures[1].within());
}

TEST(CaseResult, OfALineOfAnotherShapeHasDefaults) {
  for (const char* text : {"{}", R"({"run":3,"code":"a","good":1,"measures":[],"limits":2,"report":[]})",
                           R"({"measures":{"a":"b","c":null},"limits":{"a":3}})"}) {
    const CaseResult r = case_result(1, app::Json::parse(text));
    EXPECT_TRUE(r.measures.empty() && !r.good && r.run.empty() && r.report.is_null()) << text;
  }
}

TEST(SweepSummary, TellsOutcomesMeasuresAndWhatRepeatsEachFailure) {
  Summary summary;
  for (std::uint64_t i = 1; i <= 18; ++i) summary.add(landed(i, 0.01 * static_cast<double>(i % 5 + 1)));
  summary.add(landed(19, 0.4));
  summary.add({20, "quad.toml --seed 20", 139, false, "crashed: signal 11 (Segmentation fault)", "", "", {}});
  EXPECT_EQ(summary.text(20),
            "  outcome                                         runs   share   95 % interval\n"
            "  good                                              18  90.0 %  69.9 .. 97.2 %\n"
            "    landed on the pad                               18  90.0 %  69.9 .. 97.2 %\n"
            "    BAD: crashed: signal 11 (Segmentation fault)     1   5.0 %   0.9 .. 23.6 %\n"
            "    BAD: landed off the pad                          1   5.0 %   0.9 .. 23.6 %\n"
            "\n"
            "  measure          runs  median   95 %  worst  limit         worst in\n"
            "  landing_error_m    19    0.03  0.085    0.4  at most 0.15  --seed 19\n"
            "  flight_s           19   20.03  20.09   20.4                --seed 19\n"
            "\n"
            "failures\n"
            "  landed off the pad: landing error\n"
            "    sinew run quad.toml --seed 19 --virtual\n"
            "  crashed: signal 11 (Segmentation fault)\n"
            "    sinew run quad.toml --seed 20 --virtual\n");
}

TEST(SweepSummary, AReasonStandsOnceForFailuresInARow) {
  Summary summary;
  for (std::uint64_t i = 1; i <= 2; ++i) summary.add(landed(i, 0.4));
  EXPECT_THAT(summary.text(2), HasSubstr("failures\n  landed off the pad: landing error\n"
                                         "    sinew run quad.toml --seed 1 --virtual\n"
                                         "    sinew run quad.toml --seed 2 --virtual\n"));
}

TEST(SweepSummary, SaysHowManyRunsAreStillToCome) {
  Summary summary;
  EXPECT_EQ(summary.text(5), "no run of 5 has ended\n");
  summary.add(landed(1, 0.1));
  EXPECT_THAT(summary.text(5), HasSubstr("(1 of 5 runs)"));
}

TEST(SweepSummary, SettingsAreToldApartByWhatTheyDoNotShare) {
  Summary summary;
  for (std::uint64_t i = 0; i < 4; ++i) {
    summary.add(landed(i, 0.1, "quad.toml --set a.b=1 --camera 64x48"));
    summary.add(landed(i, 0.2, "quad.toml --set a.b=2 --camera 64x48"));
  }
  const std::string text = summary.text(8);
  EXPECT_THAT(text, HasSubstr("  --set a.b=1     4     4  100.0 %  51.0 .. 100.0 %"));
  EXPECT_THAT(text, HasSubstr("  --set a.b=2     4     0    0.0 %    0.0 .. 49.0 %"));
}

TEST(SweepSummary, EndsAtDifferentTimesAreOneOutcome) {
  Summary summary;
  for (std::uint64_t i = 0; i < 3; ++i)
    summary.add({i,
                 "a --seed " + std::to_string(i),
                 1,
                 false,
                 "did not land: the simulator died (signal 9) at " + std::to_string(i) + ".5 s",
                 "",
                 "",
                 {}});
  EXPECT_THAT(summary.text(3), HasSubstr("BAD: did not land: the simulator died (signal 9)     3"));
}

TEST(SweepSummary, ManyKindsOfEverythingStayShort) {
  Summary summary;
  for (std::uint64_t i = 0; i < 1000; ++i)
    summary.add(
        {i, "a --set b.c=" + std::to_string(i) + " --seed 1", 1, false, "outcome " + std::to_string(i), "", "", {}});
  const std::string text = summary.text(1000);
  EXPECT_LT(std::count(text.begin(), text.end(), '\n'), 150);
  EXPECT_THAT(text, HasSubstr("(other outcomes)"));
  EXPECT_THAT(text, HasSubstr("and others with 960 runs"));
  EXPECT_THAT(text, HasSubstr("and 980 more"));
}

class Compared : public ::testing::Test {
 protected:
  ~Compared() override { fs::remove(path_); }
  void before(const std::vector<CaseResult>& results) {
    std::string why;
    const auto file = ResultsFile::open(path_, {1000, {{"a", 1}}}, {}, why);
    ASSERT_TRUE(file) << why;
    for (const CaseResult& r : results) ASSERT_TRUE(file->append(r.number, to_json(r), why)) << why;
  }
  std::string now(const std::vector<CaseResult>& results) {
    std::string why;
    const auto comparison = Comparison::open(path_, why);
    if (!comparison) return why;
    for (const CaseResult& r : results)
      if (!comparison->add(r, why)) return why;
    return comparison->text();
  }
  const std::string path_ = (fs::temp_directory_path() / "compared.jsonl").string();
};

TEST_F(Compared, PairsAreToldByWhatChanged) {
  before({landed(1, 0.1), landed(2, 0.2), landed(3, 0.1), landed(4, 0.3)});
  const std::string text = now({landed(1, 0.09), landed(2, 0.1), landed(3, 0.2), landed(5, 0.1)});
  EXPECT_THAT(text, HasSubstr(": 3 pairs; 1 run without one there\n"
                              "  good before and now 1, bad before and now 0, better 1, worse 1\n"
                              "  no evidence of a difference: chance explains it (p = 1, exact McNemar test)\n"));
  EXPECT_THAT(
      text,
      HasSubstr("worse\n  landed on the pad -> landed off the pad\n    sinew run quad.toml --seed 3 --virtual\n"));
  EXPECT_THAT(
      text,
      HasSubstr("better\n  landed off the pad -> landed on the pad\n    sinew run quad.toml --seed 2 --virtual\n"));
}

TEST_F(Compared, RunsWithOtherOptionsArePairsBySeed) {
  std::vector<CaseResult> old, fresh;
  for (std::uint64_t i = 0; i < 8; ++i) {
    old.push_back(landed(i, 0.2, "quad.toml --set a.b=1"));
    fresh.push_back(landed(i, 0.1, "quad.toml --set a.b=2"));
  }
  before(old);
  EXPECT_THAT(now(fresh), HasSubstr("8 pairs by seed, since their options differ"));
  EXPECT_THAT(now(fresh),
              HasSubstr("better 8, worse 0\n  better, and not by chance (p = 0.00781, exact McNemar test)"));
  fresh.push_back(landed(3, 0.1, "quad.toml --set a.b=3"));
  EXPECT_THAT(now(fresh), HasSubstr("several of these have the same seed: no pairs"));
}

}  // namespace
}  // namespace sinew::sweep::summary_test
