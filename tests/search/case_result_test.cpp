#include "apps/search/case_result.hpp"

#include <gtest/gtest.h>

#include "apps/search/outcome_text.hpp"

namespace sinew::search::case_result_test {
namespace {

using namespace std::chrono_literals;

sweep::JobResult ended(int code, std::string output, std::string errors) {
  sweep::JobResult job;
  job.code = code;
  job.output = std::move(output);
  job.errors = std::move(errors);
  return job;
}

std::string outcome_line(const std::optional<Violation>& violation = {}) {
  Outcome outcome;
  outcome.hash = 7;
  outcome.violation = violation;
  return to_json({}, outcome) + "\n";
}

TEST(CaseResult, AnOutcomeIsReadFromTheOutput) {
  const CaseResult good = case_result(ended(0, "words\n" + outcome_line(), "warning\n"), 300s);
  EXPECT_EQ(good.error, "");
  EXPECT_FALSE(good.outcome.violation);
  EXPECT_EQ(good.outcome.hash, 7u);
  const CaseResult bad = case_result(ended(1, outcome_line(Violation{"tilt", {}, "leans"}), ""), 300s);
  EXPECT_EQ(bad.error, "");
  ASSERT_TRUE(bad.outcome.violation);
  EXPECT_EQ(bad.outcome.violation->invariant, "tilt");
}

TEST(CaseResult, ACrashIsAViolationWithTheLastWords) {
  const CaseResult r = case_result(ended(128 + 6, outcome_line(), "one\nterminate called\n\n"), 300s);
  ASSERT_TRUE(r.outcome.violation);
  EXPECT_EQ(r.outcome.violation->invariant, "crash");
  EXPECT_EQ(r.outcome.violation->what, "the process died of signal 6: terminate called");
}

TEST(CaseResult, AHangIsAViolation) {
  sweep::JobResult job = ended(128 + 9, "", "");
  job.hung = true;
  const CaseResult r = case_result(job, 300s);
  ASSERT_TRUE(r.outcome.violation);
  EXPECT_EQ(r.outcome.violation->invariant, "end");
  EXPECT_EQ(r.outcome.violation->what, "the process hangs: no outcome within 300 s");
}

TEST(CaseResult, WhatCouldNotBeFlownSaysNothingAboutTheRobot) {
  EXPECT_EQ(case_result(ended(2, "", "sinew-fuzz: no plant\n"), 300s).error, "exit code 2: sinew-fuzz: no plant");
  EXPECT_EQ(case_result(ended(0, "no outcome\n", ""), 300s).error, "exit code 0: no outcome");
  sweep::JobResult none;
  none.not_started = "cannot start /x: not found";
  EXPECT_EQ(case_result(none, 300s).error, "cannot start /x: not found");
}

}  // namespace
}  // namespace sinew::search::case_result_test
