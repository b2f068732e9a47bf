#include "record/run/step_log.hpp"

#include "../../rt/counting_new.hpp"
#include "../../rt/graph_fixture.hpp"
#include "modules.hpp"

namespace sinew::record::step_log_test {
namespace {

using namespace std::chrono_literals;

struct Told final : StepLog::Visitor {
  void step(const LoggedStep& s) override { steps.push_back(s); }
  void request(const LoggedRequest& r) override { requests.push_back(r); }
  void state(const LoggedState& s) override {
    states.push_back(s);
    states.back().bytes = {};
  }
  void lost(std::uint32_t thread, std::uint64_t entries) override { gaps.emplace_back(thread, entries); }
  std::vector<LoggedStep> steps;
  std::vector<LoggedRequest> requests;
  std::vector<LoggedState> states;
  std::vector<std::pair<std::uint32_t, std::uint64_t>> gaps;
};

class StepLogTest : public ::testing::Test {
 protected:
  StepLogTest() {
    robot.add<Numbers>("numbers");
    robot.periodic("t", 1, 1ms, {"numbers"});
    robot.build();
  }
  rt::StepRecord record(std::uint32_t number) const {
    rt::StepRecord r;
    r.number = number;
    r.ports = &ports;
    return r;
  }
  struct NoPorts final : rt::StepPorts {
    const rt::InputBase* input(std::uint32_t) const noexcept override { return nullptr; }
    std::span<const rt::SlotHeader* const> published(std::uint32_t) const noexcept override { return {}; }
    std::size_t state_bytes() const noexcept override { return 0; }
    void save_state(std::span<std::byte>) const noexcept override {}
    virtual ~NoPorts() = default;
  } ports;
  rt::Robot robot;
};

TEST_F(StepLogTest, GoesRoundItsRingForEver) {
  StepLog log(robot.graph(), 20ms);
  Told told;
  for (std::uint32_t n = 0; n < 10'000; ++n) {
    log.completed(record(n));
    if (n % 3 == 0) log.read(0, told);
  }
  log.read(0, told);
  ASSERT_EQ(told.steps.size(), 10'000u);
  for (std::uint32_t n = 0; n < 10'000; ++n) {
    ASSERT_EQ(told.steps[n].number, n);
    ASSERT_EQ(told.steps[n].order, n);
  }
  EXPECT_TRUE(told.gaps.empty());
}

TEST_F(StepLogTest, WhatFindsNoRoomIsCountedWhereItIsMissing) {
  StepLog log(robot.graph(), 20ms);
  Told told;
  const auto fill = [&] {
    for (std::uint32_t n = 0; n < 100; ++n) log.completed(record(n));
  };
  fill();
  log.read(0, told);
  const std::size_t fit = told.steps.size();
  ASSERT_LT(fit, 100u);
  EXPECT_TRUE(told.gaps.empty()) << "what is missing is at the end, where more may come";
  log.completed(record(1000));
  log.read(0, told);
  ASSERT_EQ(told.gaps.size(), 1u);
  EXPECT_EQ(told.gaps[0].second, 100 - fit);
  ASSERT_EQ(told.steps.size(), fit + 1);
  EXPECT_EQ(told.steps.back().number, 1000u);
  EXPECT_EQ(told.steps.back().order, 100u);
  fill();
  log.read(0, told, true);
  ASSERT_EQ(told.gaps.size(), 2u) << "nothing follows: now it is told";
}

TEST_F(StepLogTest, RequestsStandAmongTheSteps) {
  StepLog log(robot.graph(), 20ms);
  Told told;
  rt::Request request;
  request.kind = rt::Request::Kind::set_period;
  request.value = std::int64_t{5};
  log.completed(record(0));
  log.taken(request, {3, false}, rt::Time{77});
  log.completed(record(1));
  log.read(0, told);
  ASSERT_EQ(told.steps.size(), 2u);
  ASSERT_EQ(told.requests.size(), 1u);
  EXPECT_EQ(told.steps[0].order, 0u);
  EXPECT_EQ(told.requests[0].order, 1u);
  EXPECT_EQ(told.steps[1].order, 2u);
  EXPECT_EQ(told.requests[0].request.value, request.value);
  EXPECT_EQ(told.requests[0].effect, (rt::Effect{3, false}));
  EXPECT_EQ(told.requests[0].now, rt::Time{77});
}

TEST_F(StepLogTest, WhatWasOverLaterStaysForAnotherTime) {
  StepLog log(robot.graph(), 20ms);
  Told told;
  for (const std::uint32_t n : {0u, 1u, 2u}) {
    rt::StepRecord r = record(n);
    r.completed = rt::Time{100 * n};
    log.completed(r);
  }
  rt::Request request;
  request.kind = rt::Request::Kind::set_period;
  request.value = std::int64_t{5};
  log.taken(request, {3, false}, rt::Time{250});
  log.read(0, told, false, rt::Time{100});
  EXPECT_EQ(told.steps.size(), 2u);
  log.read(0, told, false, rt::Time{249});
  EXPECT_EQ(told.steps.size(), 3u);
  EXPECT_TRUE(told.requests.empty());
  log.read(0, told);
  EXPECT_EQ(told.requests.size(), 1u);
  EXPECT_TRUE(told.gaps.empty());
}

TEST_F(StepLogTest, AStateThatIsAskedForComesBehindTheNextStepOnce) {
  StepLog log(robot.graph(), 20ms);  // none by itself
  Told told;
  log.completed(record(0));
  log.ask_state(0);
  log.completed(record(1));
  log.completed(record(2));
  log.read(0, told);
  ASSERT_EQ(told.states.size(), 1u);
  EXPECT_EQ(told.states[0].number, 1u);
  EXPECT_EQ(told.states[0].order, 2u) << "behind the steps 0 and 1";
  EXPECT_EQ(told.steps.size(), 3u);
}

TEST(StepLogOfTwoThreads, TellingAStepAllocatesNothing) {
  rt::Robot robot;
  robot.configure_options.recorded = true;
  robot.add<Numbers>("numbers");
  robot.add<Sums>("sums", {{"latest", "numbers.out"}, {"all", "numbers.out"}});
  robot.periodic("fast", 2, 1ms, {"numbers"});
  robot.periodic("slow", 1, 3ms, {"sums"});
  StepLog log(robot.build(), 20ms);
  rt::RunnerOptions options;
  options.observer = &log;
  rt::Runner runner(robot.graph(), options);
  Told told;
  const auto cycle = [&](std::uint32_t thread, rt::Time now) {
    runner.thread(thread).begin(now, false, now);
    runner.thread(thread).start(0, now);
    runner.thread(thread).complete(0, now + 5us, 5us);
    runner.thread(thread).end(now + 5us);
  };
  std::uint64_t more = 0;
  for (std::int64_t ms = 0; ms < 300; ++ms) {
    if (ms % 10 == 0) log.ask_state(static_cast<std::uint32_t>(ms / 10 % 2));  // as for a ring
    const std::uint64_t before = test::allocations();
    cycle(0, rt::Time{ms * 1'000'000});
    if (ms % 3 == 0) cycle(1, rt::Time{ms * 1'000'000});
    more += test::allocations() - before;
    if (ms < 200) log.read(0, told), log.read(1, told);  // then it is full
  }
  EXPECT_EQ(more, 0u);
  log.read(0, told, true);
  EXPECT_FALSE(told.gaps.empty()) << "the way of a full ring was taken, too";
  EXPECT_GT(told.steps.size(), 200u);
  EXPECT_GT(told.states.size(), 10u);
}

}  // namespace
}  // namespace sinew::record::step_log_test
