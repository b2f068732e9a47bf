#include "rt/exec/chain_budget.hpp"

#include <gtest/gtest.h>

#include "graph_fixture.hpp"
#include "test_modules.hpp"

namespace sinew::rt::chain_budget_test {
namespace {

using Result = ChainVerdict::Result;

/// One message in ten is published 300 us after its stamp, the others 100 us after.
struct Chained : Robot {
  explicit Chained(Duration budget, double allowed = 0) {
    add<Numbers>("numbers");
    module("numbers").exec = {ExecModel::Kind::trace, {}, std::vector<Duration>(10, 100us), 1.0};
    module("numbers").exec.trace[7] = 300us;
    periodic("main", 10, 1ms, {"numbers"});
    spec.chains.push_back({"chain", {"numbers.out", 0}, {"numbers.out", 0}, budget, 0, allowed});
  }
};

ChainVerdict verdict(Duration budget, double allowed = 0, Duration run = 99500us) {
  Chained robot(budget, allowed);
  robot.run(run);
  return chain_within_budget(robot.runner(), "chain");
}

TEST(ChainBudget, PassesWhenNoMessageIsOlder) {
  const auto kept = verdict(300us);
  EXPECT_TRUE(kept) << kept.text;
  EXPECT_EQ(kept.text, "chain chain: 0 of 100 messages older than 0.3 ms, 0 allowed");
}

TEST(ChainBudget, FailsWhenMoreMessagesThanAllowedAreOlder) {
  const auto kept = verdict(299us);
  EXPECT_FALSE(kept);
  EXPECT_EQ(kept.result, Result::fail);
  EXPECT_EQ(kept.text, "chain chain: 10 of 100 messages older than 0.299 ms, 0 allowed");
  EXPECT_TRUE(verdict(299us, 0.1)) << "a tenth may be";
  EXPECT_FALSE(verdict(299us, 0.09));
}

TEST(ChainBudget, IsNoPassWhereNothingCameOrNothingIsAsked) {
  const auto nothing = verdict(300us, 0, 50us);
  EXPECT_FALSE(nothing);
  EXPECT_EQ(nothing.result, Result::nothing_came);
  EXPECT_EQ(nothing.text, "chain chain: no message reached numbers.out");
  EXPECT_EQ(verdict(0us).result, Result::no_budget);
  Chained robot(1ms);
  robot.run(1ms);
  EXPECT_EQ(chain_within_budget(robot.runner(), "chian").result, Result::unknown);
}

}  // namespace
}  // namespace sinew::rt::chain_budget_test
