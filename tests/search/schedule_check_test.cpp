#include "apps/search/schedule_check.hpp"

#include <gtest/gtest.h>

#include "rt/exec/discrete_executor.hpp"

namespace sinew::search::schedule_check_test {
namespace {

using namespace std::chrono_literals;
using msg::Duration;
using msg::Time;

class Idle final : public rt::Module {
 public:
  void declare(rt::Declaration&) override {}
  rt::StepStatus step(const rt::Step&) noexcept override { return rt::StepStatus::ok; }
};

class ScheduleCheckTest : public ::testing::Test {
 protected:
  ScheduleCheckTest() {
    types.add<Idle>("Idle");
    rt::GraphSpec spec;
    spec.robot = "r";
    spec.board = "sim";
    spec.modules = {{.name = "a", .type = "Idle", .exec = {rt::ExecModel::Kind::constant, 700us, {}, 1.0}},
                    {.name = "b", .type = "Idle", .exec = {rt::ExecModel::Kind::constant, 500us, {}, 1.0}}};
    rt::ThreadSpec t;
    t.name = "t";
    t.priority = 10;
    t.period = 1ms;
    t.phase = 250us;
    t.order = {{"a", 0}, {"b", 0}};
    spec.threads = {t};
    graph = std::make_unique<rt::Graph>(spec, types);
  }
  rt::StepRecord step(std::uint32_t number, Time release, Duration dt) const {
    rt::StepRecord r;
    r.number = number;
    r.release = r.now = release;
    r.dt = dt;
    r.exec = 700us;
    r.completed = release + r.exec;
    return r;
  }
  std::string failed() const { return verdict.first() ? verdict.first()->invariant : ""; }
  rt::ModuleTypes types;
  std::unique_ptr<rt::Graph> graph;
  Verdict verdict;
};

TEST_F(ScheduleCheckTest, ARealRunIsRightWhereverItIsLookedAt) {
  // 1.2 ms in periods of 1 ms: every second release is skipped.
  ASSERT_TRUE(graph->check({true, 0}).empty());
  hal::EmptyBoard board;
  ASSERT_TRUE(graph->configure(board));
  ScheduleCheck check(*graph, verdict);
  struct Looks final : hal::GrantSource, rt::RunObserver {
    hal::Result<hal::Time> next_grant(hal::Time done) override {
      if (granted) check->look(done, executor->runner());
      granted = true;
      return done + 333us;
    }
    void completed(const rt::StepRecord& record) noexcept override { check->completed(record); }
    ScheduleCheck* check = nullptr;
    rt::DiscreteExecutor* executor = nullptr;
    bool granted = false;
  } looks;
  looks.check = &check;
  hal::ManualClock clock;
  rt::DiscreteExecutor executor(*graph, clock, looks, {.duration = 50ms, .observer = &looks});
  looks.executor = &executor;
  ASSERT_TRUE(executor.run());
  EXPECT_EQ(failed(), "") << (verdict.first() ? verdict.first()->what : "");
  EXPECT_EQ(executor.runner().thread_stats(0).skips.value(), 25u);
}

TEST_F(ScheduleCheckTest, AReleaseBesideTheGridIsNamed) {
  ScheduleCheck check(*graph, verdict);
  check.completed(step(0, Time{250'000}, 1ms));
  check.completed(step(1, Time{2'250'000}, 2ms));
  EXPECT_EQ(failed(), "");
  check.completed(step(2, Time{3'251'000}, 1001us));
  EXPECT_EQ(failed(), "phase");
}

TEST_F(ScheduleCheckTest, AWrongDtIsNamed) {
  ScheduleCheck check(*graph, verdict);
  check.completed(step(0, Time{250'000}, 1ms));
  check.completed(step(1, Time{2'250'000}, 1ms));
  EXPECT_EQ(failed(), "phase");
}

TEST_F(ScheduleCheckTest, AMissingStepIsNamed) {
  ScheduleCheck check(*graph, verdict);
  check.completed(step(0, Time{250'000}, 1ms));
  check.completed(step(2, Time{1'250'000}, 1ms));
  EXPECT_EQ(failed(), "steps");
}

TEST_F(ScheduleCheckTest, AStepThatNobodyHeardOfIsNamed) {
  ASSERT_TRUE(graph->check({true, 0}).empty());
  hal::EmptyBoard board;
  ASSERT_TRUE(graph->configure(board));
  hal::ManualClock clock;
  hal::FixedGrant grants(Time{10'000'000});
  rt::DiscreteExecutor executor(*graph, clock, grants, {.duration = 10ms});
  ASSERT_TRUE(executor.run());
  ScheduleCheck check(*graph, verdict);  // told of no step
  check.look(Time{10'000'000}, executor.runner());
  EXPECT_EQ(failed(), "counters");
}

}  // namespace
}  // namespace sinew::search::schedule_check_test
