// A run in real time, with real threads that preempt each other, executed again. Nothing is asserted about when.
#include <gtest/gtest.h>

#include <chrono>

#include "again_robot.hpp"
#include "graph_fixture.hpp"
#include "hal/platform.hpp"
#include "memory_record.hpp"
#include "rt/exec/real_time_executor.hpp"
#include "until.hpp"

namespace sinew::rt::real_time_again_test {
namespace {

TEST(RealTimeAgain, EveryStepOfARunInRealTimeComesOutTheSame) {
  const GraphSpec spec = test_spec();
  const ModuleTypes types = test_types();
  Graph graph(spec, types);
  FakeBoard board;
  board.add("motors", hal::system_os());
  ASSERT_TRUE(graph.configure(board, {.first_sequence = kNearWrap}));
  MemoryRecord record(graph, 20ms);
  RealTimeOptions options;
  options.lock_memory = options.keep_awake = options.fixed_priority = false;
  options.runner.observer = &record;
  options.runner.fault_limit = 5;
  RealTimeExecutor executor(graph, hal::system_os(), options);
  ASSERT_TRUE(executor.start());
  const auto steps = [&](const char* module) {
    return executor.runner().module_stats(graph.find_module(module)).steps.value();
  };
  ASSERT_TRUE(until([&] { return steps("mixed") >= 15; }));
  ASSERT_TRUE(graph.arm());
  ASSERT_TRUE(graph.set_param("mixed", "gain", 2.0));
  ASSERT_TRUE(graph.set_period("slow", 3ms));
  ASSERT_TRUE(graph.set_enabled("sampler", false));
  ASSERT_TRUE(until([&] { return steps("mixed") >= 30; }));
  ASSERT_TRUE(graph.set_enabled("sampler", true));
  ASSERT_TRUE(graph.set_enabled("shaky", true));
  ASSERT_TRUE(until([&] { return steps("mixed") >= 60 && steps("commander") >= 150; }));
  executor.stop();

  for (std::uint32_t m = 0; m < graph.modules().size(); ++m) {
    const std::string& name = graph.modules()[m].spec.name;
    std::vector<std::size_t> starts = record.saved(m);
    if (name == "forgetful") starts.clear();  // its state is not declared
    starts.push_back(SIZE_MAX);               // the beginning
    for (const std::size_t at : starts) {
      RunAgain again(spec, types);
      const auto departure = again.run(m, record.of(m), at + 1, SIZE_MAX);
      EXPECT_FALSE(departure) << name << " from " << at << ", entry " << departure->entry << ": " << departure->what;
    }
    EXPECT_GT(record.steps(m), name == "shaky" ? 20u : 30u) << name;
  }
}

}  // namespace
}  // namespace sinew::rt::real_time_again_test
