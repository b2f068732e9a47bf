// The step contract (rt/module.hpp, rt/README.md) in small graphs under the discrete executor.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "graph_fixture.hpp"
#include "test_modules.hpp"

namespace sinew::rt::step_contract_test {
namespace {

using ::testing::ElementsAre;

// ---- what a step sees

TEST(StepContract, OutputsAppearAtCompletionNotAtStart) {
  Robot robot;
  robot.add<Numbers>("numbers");
  Relay& relay = robot.add<Relay>("relay", {{"in", "numbers.out"}});
  robot.module("numbers").exec.constant = 600us;
  robot.periodic("slow", 10, 1ms, {"numbers"});
  robot.periodic("fast", 20, 500us, {"relay"});
  robot.run(2400us);  // numbers: starts at 10 us, works 600 us and is preempted for 10 us by each relay
  EXPECT_THAT(relay.seen, ElementsAre(-1, -1, 0, 0, 1));
  ASSERT_EQ(robot.steps("numbers").size(), 2u);
  EXPECT_EQ(robot.steps("numbers")[0].now, Time{10'000});
  EXPECT_EQ(robot.steps("numbers")[0].completed, Time{620'000});
}

TEST(StepContract, InputsAreLatchedOnceForTheWholeStep) {
  Robot robot;
  robot.add<Numbers>("numbers");
  class Slow final : public Module {  // reads at the start and when it is asked again: the same slot
   public:
    void declare(Declaration& d) override { d.in("in", in_), d.out("out", out_); }
    StepStatus step(const Step&) noexcept override {
      if (!in_.get()) return StepStatus::stale;
      out_.loan().number = in_.get()->number;
      return StepStatus::ok;
    }

   private:
    In<Pair> in_;
    Out<Pair> out_;
  };
  robot.add<Slow>("slow", {{"in", "numbers.out"}});
  Relay& relay = robot.add<Relay>("relay", {{"in", "slow.out"}});
  robot.module("slow").exec.constant = 5ms;
  robot.periodic("fast", 20, 1ms, {"numbers"});
  robot.periodic("slow", 10, 10ms, {"slow"}).phase = 500us;
  robot.on_topics("end", 5, {"slow.out"}, {"relay"});
  robot.run(20ms);
  EXPECT_THAT(relay.seen, ElementsAre(0, 10)) << "what was newest when the step started, 5 ms before";
}

TEST(StepContract, TheOutputsOfAStepAreVisibleTogether) {
  Robot robot;
  robot.add<Twin>("twin");
  TwinReader& reader = robot.add<TwinReader>("reader", {{"a", "twin.a"}, {"b", "twin.b"}});
  robot.module("twin").exec.constant = 370us;
  robot.periodic("writer", 10, 1ms, {"twin"});
  robot.periodic("reader", 20, 130us, {"reader"});
  robot.run(1s);
  EXPECT_GT(reader.a_seen.size(), 7000u);
  EXPECT_EQ(reader.a_seen, reader.b_seen);
}

TEST(StepContract, AStaleStepPublishesNothingAndItsLoansAreForgotten) {
  Robot robot;
  robot.add<Twin>("twin");  // every third step is stale
  Logger& logger = robot.add<Logger>("logger", {{"in", "twin.a"}});
  robot.periodic("main", 10, 1ms, {"twin", "logger"});
  robot.run(8500us);
  EXPECT_THAT(logger.seen, ElementsAre(0, 1, 3, 4, 6, 7));
  EXPECT_EQ(robot.runner().topic_stats(robot.graph().find_topic("twin.a")).messages.value(), 6u);
  EXPECT_EQ(robot.stats("twin").stale.value(), 3u);
  EXPECT_EQ(robot.stats("twin").ok.value(), 6u);
}

TEST(StepContract, ASequenceGoesOnWhereADiscardedStepLeftIt) {
  Robot robot;
  robot.configure_options.taps = {"twin.b"};
  robot.add<Twin>("twin");
  robot.periodic("main", 10, 1ms, {"twin"});
  robot.run(8500us);
  In<Pair> tap;
  Latch latch(robot.graph().segment());
  latch.bind(tap, robot.graph().taps()[0]);
  const Latched latched(latch);
  ASSERT_NE(tap.get(), nullptr);
  EXPECT_EQ(tap.get()->number, 7u);
  EXPECT_EQ(tap.header(0)->sequence, kNearWrap + 5);
  EXPECT_EQ(tap.header(0)->commit, 6u);
}

TEST(StepContract, ModulesRunInTheOrderOfTheFileAndSeeEarlierOnesInTheSameCycle) {
  Robot robot;
  robot.add<Relay>("second", {{"in", "first.out"}});  // of the modules' order nothing depends
  robot.add<Numbers>("first");
  Relay& third = robot.add<Relay>("third", {{"in", "second.out"}});
  robot.periodic("main", 10, 1ms, {"first", "second", "third"});
  robot.run(2500us);
  EXPECT_THAT(third.seen, ElementsAre(0, 1, 2));
  std::vector<std::uint32_t> order;
  for (const auto& r : robot.records.all) order.push_back(r.module);
  EXPECT_THAT(order, ElementsAre(1, 0, 2, 1, 0, 2, 1, 0, 2));
}

TEST(StepContract, APreviousInputHoldsTheMessageOfTheCycleBefore) {
  Robot robot;
  Relay& relay = robot.add<Relay>("relay", {{"in", "numbers.out"}}, true);
  robot.add<Numbers>("numbers");
  robot.periodic("main", 10, 1ms, {"relay", "numbers"});
  robot.run(3500us);
  EXPECT_THAT(relay.seen, ElementsAre(-1, 0, 1, 2));
}

TEST(StepContract, InsideAThreadTheReaderGetsTheWritersOwnSlot) {
  Robot robot;
  Numbers& numbers = robot.add<Numbers>("numbers");
  Relay& relay = robot.add<Relay>("relay", {{"in", "numbers.out"}});
  robot.periodic("main", 10, 1ms, {"numbers", "relay"});
  robot.run(100us);
  ASSERT_NE(relay.address, nullptr);
  EXPECT_EQ(relay.address, numbers.address);
}

TEST(StepContract, BetweenThreadsTheReaderGetsTheWritersOwnSlot) {
  Robot robot;
  Numbers& numbers = robot.add<Numbers>("numbers");
  Relay& relay = robot.add<Relay>("relay", {{"in", "numbers.out"}});
  robot.periodic("writer", 10, 1ms, {"numbers"});
  robot.on_topics("reader", 20, {"numbers.out"}, {"relay"});
  robot.run(100us);
  ASSERT_NE(relay.address, nullptr);
  EXPECT_EQ(relay.address, numbers.address);
}

// ---- queues

TEST(StepContract, AQueueHoldsAllSinceTheLastStep) {
  Robot robot;
  robot.add<Numbers>("numbers");
  Logger& logger = robot.add<Logger>("logger", {{"in", "numbers.out"}}, QueueOptions{.depth = 4});
  robot.periodic("writer", 20, 1ms, {"numbers"});
  robot.periodic("reader", 10, 3ms, {"logger"}).phase = 2500us;
  robot.run(12ms);
  EXPECT_THAT(logger.seen, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11));
  EXPECT_EQ(logger.dropped, 0u);
}

TEST(StepContract, AFullQueueDropsTheOldestOrTheNewestAndCounts) {
  Robot robot;
  robot.add<Numbers>("numbers");
  Logger& oldest = robot.add<Logger>("oldest", {{"in", "numbers.out"}}, QueueOptions{.depth = 2});
  Logger& newest =
      robot.add<Logger>("newest", {{"in", "numbers.out"}}, QueueOptions{.depth = 2, .overflow = Overflow::drop_newest});
  robot.periodic("writer", 20, 1ms, {"numbers"});
  robot.periodic("reader", 10, 5ms, {"oldest", "newest"}).phase = 4500us;
  robot.run(10ms);
  EXPECT_THAT(oldest.seen, ElementsAre(3, 4, 8, 9));
  EXPECT_THAT(newest.seen, ElementsAre(0, 1, 5, 6));
  EXPECT_EQ(oldest.dropped, 6u);
  EXPECT_EQ(newest.dropped, 6u);
  EXPECT_EQ(robot.runner().topic_drops(robot.graph().find_topic("numbers.out")), 12u);
}

TEST(StepContract, NothingIsLostOverTheSequenceWrap) {
  Robot robot;  // sequences begin 256 before the wrap
  robot.add<Numbers>("numbers");
  Logger& oldest = robot.add<Logger>("oldest", {{"in", "numbers.out"}}, QueueOptions{.depth = 4});
  Logger& newest =
      robot.add<Logger>("newest", {{"in", "numbers.out"}}, QueueOptions{.depth = 4, .overflow = Overflow::drop_newest});
  Relay& relay = robot.add<Relay>("relay", {{"in", "numbers.out"}});
  robot.periodic("writer", 20, 1ms, {"numbers"});
  robot.periodic("reader", 10, 3ms, {"oldest", "newest", "relay"}).phase = 2500us;
  robot.run(3s);
  std::vector<std::uint32_t> all(3000);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(oldest.seen, all);
  EXPECT_EQ(newest.seen, all);
  ASSERT_EQ(relay.seen.size(), 1000u);
  for (std::size_t i = 0; i < relay.seen.size(); ++i) ASSERT_EQ(relay.seen[i], static_cast<std::int64_t>(3 * i + 2));
}

// ---- dt, now, number, random

TEST(StepContract, DtIsReleaseToReleaseAndNowIsTheInstantOfTheLatch) {
  Robot robot;
  robot.add<Numbers>("busy");
  robot.module("busy").exec.constant = 300us;
  robot.add<Numbers>("numbers");
  robot.periodic("urgent", 20, 2ms, {"busy"});
  robot.periodic("main", 10, 1ms, {"numbers"});
  robot.run(3500us);
  const auto steps = robot.steps("numbers");
  ASSERT_EQ(steps.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(steps[k].dt, Duration{1ms}) << "the first too, and late steps";
    EXPECT_EQ(steps[k].release, Time{static_cast<std::int64_t>(k) * 1'000'000});
    EXPECT_EQ(steps[k].now - steps[k].release, k % 2 == 0 ? Duration{300us} : Duration{0});
    EXPECT_EQ(steps[k].number, k);
  }
}

TEST(StepContract, DtGrowsOverSkippedReleases) {
  Robot robot;
  robot.add<Numbers>("numbers");
  robot.module("numbers").exec = {ExecModel::Kind::trace, {}, {100us, 2500us, 100us, 100us}, 1.0};
  robot.periodic("main", 10, 1ms, {"numbers"});
  robot.run(5500us);
  std::vector<Duration> dt;
  for (const auto& s : robot.steps("numbers")) dt.push_back(s.dt);
  EXPECT_THAT(dt, ElementsAre(1ms, 1ms, 3ms, 1ms));
  EXPECT_EQ(robot.thread_stats("main").overruns.value(), 2u);
  EXPECT_EQ(robot.thread_stats("main").skips.value(), 2u);
}

TEST(StepContract, DtIsNeverZero) {
  Robot robot;
  robot.add<Numbers>("numbers");
  Relay& relay = robot.add<Relay>("relay", {{"in", "numbers.out"}});
  robot.module("numbers").exec.constant = 1ns;
  robot.module("relay").exec.constant = 1ns;
  robot.periodic("writer", 10, 10us, {"numbers"});
  robot.on_topics("reader", 20, {"numbers.out"}, {"relay"}, 3us);
  robot.run(1ms);
  EXPECT_GT(relay.seen.size(), 100u);
  for (const auto& s : robot.records.all) ASSERT_GT(s.dt, Duration{0});
}

TEST(StepContract, RandomNumbersDependOnSeedModuleAndStepAlone) {
  const auto run = [](std::uint64_t seed, int priority, bool crowded) {
    Robot robot;
    robot.spec.seed = seed;
    if (crowded) {
      robot.add<Dice>("other");
      robot.periodic("other", 50, 700us, {"other"});
    }
    Dice& dice = robot.add<Dice>("dice");
    robot.periodic("main", priority, 1ms, {"dice"});
    robot.run(20ms);
    return dice.thrown;
  };
  const auto first = run(7, 10, false);
  EXPECT_EQ(first, run(7, 60, true));
  EXPECT_NE(first, run(8, 10, false));
  EXPECT_NE(first[0], first[1]);
}

}  // namespace
}  // namespace sinew::rt::step_contract_test
