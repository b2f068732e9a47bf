#include "apps/view/gap_text.hpp"

#include <gtest/gtest.h>

#include "apps/view/status_table.hpp"
#include "hal/board.hpp"

namespace sinew::app::gap_text_test {
namespace {

using namespace std::chrono_literals;

class Idle final : public rt::Module {
 public:
  void declare(rt::Declaration&) override {}
  rt::StepStatus step(const rt::Step&) noexcept override { return rt::StepStatus::ok; }
};

class GapText : public ::testing::Test {
 protected:
  GapText() {
    types.add<Idle>("test::Idle");
    for (const char* name : {"stabilise", "vision"}) {
      rt::ThreadSpec thread;
      thread.name = name;
      thread.period = 1ms;
      thread.order.push_back({std::string(name) + "_module", 0});
      rt::ModuleSpec module;
      module.name = thread.order[0].value;
      module.type = "test::Idle";
      spec.threads.push_back(thread);
      spec.modules.push_back(module);
    }
    graph = std::make_unique<rt::Graph>(spec, types);
    EXPECT_TRUE(graph->check({}).empty());
    EXPECT_TRUE(graph->configure(board));
    runner = std::make_unique<rt::Runner>(*graph, rt::RunnerOptions{});
  }
  rt::GraphSpec spec;
  rt::ModuleTypes types;
  hal::EmptyBoard board;
  std::unique_ptr<rt::Graph> graph;
  std::unique_ptr<rt::Runner> runner;
};

TEST_F(GapText, ARunWithoutGapsSaysNothing) {
  EXPECT_EQ(gap_lines(*graph, *runner), "");
  EXPECT_EQ(StatusTable().render(rows_of(*graph, *runner), rt::Time{1}, 0).find("gap"), std::string::npos);
}

TEST_F(GapText, EveryThreadsGapsAreNamedWithTheirCause) {
  runner->thread(0).stats().taken.add(80ms, 1);
  runner->thread(1).stats().throttled.add(49ms, 2);
  runner->thread(1).stats().throttled.add(54ms, 1);
  const std::string text =
      "thread stabilise: 1 gap of 80 ms: the processor was taken away, by the machine's host or by threads of higher "
      "priority\n"
      "thread vision: 3 gaps of 49 ms to 54 ms: looks like the kernel's real-time throttle "
      "(kernel.sched_rt_runtime_us): a fixed-priority thread that does not sleep uses it up\n";
  EXPECT_EQ(gap_lines(*graph, *runner), text);
  StatusTable table;
  EXPECT_NE(table.render(rows_of(*graph, *runner), rt::Time{1}, 0).find(text), std::string::npos)
      << "and in the live table";
  EXPECT_NE(table.render(rows_of(*graph, *runner), rt::Time{2}, 39).find("\nthread vision: 3 gaps of 49 ms to 54 ms\n"),
            std::string::npos);
}

}  // namespace
}  // namespace sinew::app::gap_text_test
