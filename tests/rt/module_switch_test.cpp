// Modules that are stopped after faults, disabled and enabled.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "graph_fixture.hpp"
#include "test_modules.hpp"

namespace sinew::rt::module_switch_test {
namespace {

using ::testing::ElementsAre;

class Faulty final : public Module {
 public:
  void declare(Declaration& d) override { d.out("out", out_); }
  void reset() override { since_reset = 0; }
  StepStatus step(const Step& step) noexcept override {
    ++since_reset;
    out_.loan().number = step.number;
    return fails ? StepStatus::fault : StepStatus::ok;
  }
  bool fails = false;
  std::uint32_t since_reset = 0;

 private:
  Out<Pair> out_;
};

TEST(StepContract, RepeatedFaultsStopThatModuleAndNoOther) {
  Robot robot;
  robot.fault_limit = 4;
  Faulty& faulty = robot.add<Faulty>("faulty");
  Relay& relay = robot.add<Relay>("relay", {{"in", "faulty.out"}});
  robot.periodic("main", 10, 1ms, {"faulty", "relay"});
  robot.grants.at(Time{2'500'000}, [&] { faulty.fails = true; });
  robot.run(20500us);
  EXPECT_EQ(robot.steps("faulty").size(), 3u + 4u);
  EXPECT_EQ(robot.stats("faulty").fault.value(), 4u);
  EXPECT_EQ(robot.stats("faulty").stops.value(), 1u);
  EXPECT_EQ(robot.stats("faulty").stopped.value(), 1u);
  EXPECT_EQ(robot.steps("relay").size(), 21u);
  EXPECT_EQ(relay.seen.back(), 2) << "nothing new came, nothing wrong either";
  EXPECT_EQ(robot.stats("relay").stopped.value(), 0u);
}

TEST(StepContract, FaultsThatDoNotFollowEachOtherStopNothing) {
  Robot robot;
  robot.fault_limit = 2;
  class EverySecond final : public Module {
   public:
    void declare(Declaration&) override {}
    StepStatus step(const Step& step) noexcept override { return step.number % 2 ? StepStatus::fault : StepStatus::ok; }
  };
  robot.add<EverySecond>("module");
  robot.periodic("main", 10, 1ms, {"module"});
  robot.run(99500us);
  EXPECT_EQ(robot.stats("module").fault.value(), 50u);
  EXPECT_EQ(robot.stats("module").stops.value(), 0u);
}

TEST(StepContract, EnablingResetsTheModuleAndStartsItsStepsAnew) {
  Robot robot;
  robot.fault_limit = 2;
  Faulty& faulty = robot.add<Faulty>("faulty");
  robot.periodic("main", 10, 1ms, {"faulty"});
  Graph& graph = robot.build();
  hal::Result<Ticket> off = hal::Error{}, on = hal::Error{};
  robot.grants.at(Time{2'500'000}, [&] { off = graph.set_enabled("faulty", false); });
  robot.grants.at(Time{4'500'000}, [&] { on = graph.set_enabled("faulty", true); });
  robot.grants.at(Time{6'500'000}, [&] { faulty.fails = true; });
  robot.grants.at(Time{9'500'000}, [&] {
    faulty.fails = false;
    EXPECT_EQ(robot.stats("faulty").stopped.value(), 1u);
    EXPECT_TRUE(graph.set_enabled("faulty", true));
  });
  robot.run(11500us);
  std::vector<std::uint32_t> numbers;
  for (const auto& s : robot.steps("faulty")) numbers.push_back(s.number);
  EXPECT_THAT(numbers, ElementsAre(0, 1, 2, /* 3, 4 ms: off */ 0, 1, 2, 3, /* stopped at 8, 9 */ 0, 1));
  EXPECT_EQ(faulty.since_reset, 2u);
  EXPECT_EQ(graph.effect(*on), Effect{0});
  EXPECT_EQ(graph.effect(*off), Effect{3});
}

TEST(StepContract, EnablingAModuleThatRunsChangesNothing) {
  Robot robot;
  Faulty& faulty = robot.add<Faulty>("faulty");
  robot.periodic("main", 10, 1ms, {"faulty"});
  Graph& graph = robot.build();
  robot.grants.at(Time{2'500'000}, [&] { EXPECT_TRUE(graph.set_enabled("faulty", true)); });
  robot.run(4500us);
  EXPECT_EQ(faulty.since_reset, 5u);
}

TEST(StepContract, AModuleThatIsDisabledInTheFileWaitsToBeEnabled) {
  Robot robot;
  robot.add<Faulty>("faulty");
  robot.module("faulty").enabled = false;
  robot.periodic("main", 10, 1ms, {"faulty"});
  Graph& graph = robot.build();
  robot.grants.at(Time{2'500'000}, [&] { EXPECT_TRUE(graph.set_enabled("faulty", true)); });
  robot.run(4500us);
  EXPECT_EQ(robot.steps("faulty").size(), 2u);
}

}  // namespace
}  // namespace sinew::rt::module_switch_test
