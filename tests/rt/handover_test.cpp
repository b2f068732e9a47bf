// The memory-order proof: every execution of small programs keeps the promises with the orders of production, and each
// order, weakened to relaxed alone, breaks one of them.
#include <gtest/gtest.h>

#include <cstdio>

#include "handover_programs.hpp"

namespace sinew::rt::handover_test {
namespace {

using model::Explorer;
using model::Report;

template <class Program>
void expect_sound(const char* name) {
  ModelAtomics::as_in_production();
  const Report r = Explorer::explore<Program>();
  std::printf("[ explored ] %s: %llu runs, %llu partial and %llu complete executions\n", name,
              static_cast<unsigned long long>(r.executions), static_cast<unsigned long long>(r.states),
              static_cast<unsigned long long>(r.complete));
  EXPECT_EQ(r.failure, "") << r.trace;
  EXPECT_FALSE(r.bounded);
  EXPECT_GT(r.complete, 0U);
}

TEST(HandOver, PairsOfOneCommitStayTogether) {
  expect_sound<PairProgram<1, 3, 1, 2>>("two outputs, 3 commits, 1 record, 1 reader twice");
  expect_sound<PairProgram<1, 4, 2, 2>>("two outputs, 4 commits, 2 records, 1 reader twice");
  expect_sound<PairProgram<2, 2, 1, 1>>("two outputs, 2 commits, 1 record, 2 readers");
  expect_sound<PairProgram<2, 3, 2, 1>>("two outputs, 3 commits, 2 records, 2 readers");
}

TEST(HandOver, SlotsAreNeverTornNorLost) {
  expect_sound<LapProgram<1, 3, 1, 2, 2>>("one output, 3 commits, 2 slots, 1 reader twice");
  expect_sound<LapProgram<1, 5, 1, 3, 3>>("one output, 5 commits, 3 slots, 1 reader 3 times");
  expect_sound<LapProgram<2, 3, 1, 2, 1>>("one output, 3 commits, 2 slots, 2 readers");
  expect_sound<LapProgram<2, 5, 1, 4, 1>>("one output, 5 commits, 4 slots, 2 readers");
  expect_sound<LapProgram<2, 4, 1, 4, 2>>("one output, 4 commits, 4 slots, 2 readers twice");
  expect_sound<LapProgram<1, 4, 2, 5, 2>>("one output, 4 commits, queue of 2, 1 reader twice");
}

TEST(HandOver, DropNewestQueueDeliversEachOnce) {
  expect_sound<QueueProgram<3, 1, 2>>("queue of 1, 3 commits, 2 latches");
  expect_sound<QueueProgram<4, 1, 3>>("queue of 1, 4 commits, 3 latches");
  expect_sound<QueueProgram<5, 2, 3>>("queue of 2, 5 commits, 3 latches");
}

TEST(HandOver, OutsiderNoticesWhatWasOverwritten) {
  expect_sound<OutsiderProgram<1, 3, 1, 2, 1>>("outsider: 3 commits, 2 slots, 1 reader");
  expect_sound<OutsiderProgram<1, 4, 1, 2, 2>>("outsider: 4 commits, 2 slots, 1 reader twice");
  expect_sound<OutsiderProgram<1, 5, 2, 3, 1>>("outsider: 5 commits, 3 slots, the oldest of 2");
  expect_sound<OutsiderProgram<2, 3, 1, 2, 1>>("outsider: 3 commits, 2 slots, 2 readers");
}

TEST(HandOver, OutsiderIsFooledWithoutEitherFence) {
  for (bool* fence : {&ModelAtomics::fence_before_reuse, &ModelAtomics::fence_after_reads}) {
    ModelAtomics::as_in_production();
    *fence = false;
    const Report r = Explorer::explore<OutsiderProgram<1, 3, 1, 2, 1>>();
    EXPECT_EQ(r.failure, "an outsider took an overwritten message for whole");
  }
  ModelAtomics::as_in_production();
}

struct Weakened : testing::TestWithParam<std::size_t> {};

TEST_P(Weakened, OrderBreaksAPromise) {
  ModelAtomics::as_in_production();
  const auto& weak = ModelAtomics::all()[GetParam()];
  *weak.order = Order::relaxed;
  std::string broken;
  const auto look = [&broken](const char* name, const Report& r) {
    if (!r.failure.empty()) broken += std::string(name) + ": " + r.failure + "; ";
  };
  look("pair", Explorer::explore<PairProgram<1, 2, 1, 1>>());
  look("lap", Explorer::explore<LapProgram<1, 3, 1, 2, 1>>());
  look("queue", Explorer::explore<QueueProgram<3, 1, 2>>());
  std::printf("[ weakened ] %s: %s\n", weak.name, broken.c_str());
  EXPECT_NE(broken, "");
  ModelAtomics::as_in_production();
}
INSTANTIATE_TEST_SUITE_P(HandOver, Weakened, testing::Range<std::size_t>(0, 12),
                         [](const auto& p) { return std::string(ModelAtomics::all()[p.param].name); });

}  // namespace
}  // namespace sinew::rt::handover_test
