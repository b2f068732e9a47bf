// The loop of the discrete executor makes no trapped call.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "graph_fixture.hpp"
#include "rt/trap.hpp"
#include "test_modules.hpp"
#include "trap.hpp"

namespace sinew::rt::discrete_loop_test {
namespace {

/// Sets the trap from each grant to the next call for one.
class TrappedGrants final : public hal::GrantSource {
 public:
  explicit TrappedGrants(Time end) : end_(end) {}
  ~TrappedGrants() override { trap::state = {}; }
  hal::Result<Time> next_grant(Time done) override {
    trap::state = {};
    ++grants;
    if (done >= end_) return hal::Error{hal::Errc::closed, "end"};
    trap::state = {"the executor's loop", &calls};
    return done + 700us;
  }
  std::uint32_t calls = 0, grants = 0;

 private:
  const Time end_;
};

TEST(DiscreteExecutor, ItsLoopAllocatesLocksAndCallsTheKernelNotOnce) {
  if (!sinew::trap::is_set()) GTEST_SKIP() << "no trap in this build";
  TrappedGrants probe(Time{1});
  ASSERT_TRUE(probe.next_grant({}));
  // Compilers know that malloc looks at nobody's variables, and may drop what nobody keeps.
  std::atomic_signal_fence(std::memory_order_seq_cst);
  void* volatile kept = std::malloc(1);
  std::free(kept);
  std::atomic_signal_fence(std::memory_order_seq_cst);
  trap::state = {};
  ASSERT_EQ(probe.calls, 2u) << "the trap does not count";

  Robot robot;
  FakeActuators& motors = robot.board.add("motors", robot.clock);
  robot.add<Twin>("twin");
  robot.add<TwinReader>("reader", {{"a", "twin.a"}, {"b", "twin.b"}});
  robot.add<Logger>("logger", {{"in", "twin.a"}}, QueueOptions{.depth = 3, .overflow = Overflow::drop_newest});
  robot.add<Dice>("dice");
  class Command final : public Module {
   public:
    void declare(Declaration& d) override { d.out("out", out_); }
    StepStatus step(const Step&) noexcept override {
      msg::ActuatorCommand& c = out_.loan();
      c.count = 1;
      c.armed = 1;
      return StepStatus::ok;
    }

   private:
    Out<msg::ActuatorCommand> out_;
  };
  robot.add<Command>("command");
  robot.periodic("writer", 10, 1ms, {"twin", "dice", "command"});
  robot.periodic("reader", 20, 130us, {"reader"});
  robot.on_topics("logger", 30, {"twin.b"}, {"logger"}, 300us);
  robot.spec.actuators.push_back({"motors", {"command.out", 0}, 1, 0, 1, 0, 20ms, ActuatorSpec::Safe::stop, 0});
  Graph& graph = robot.build();
  TrappedGrants grants(Time{500'000'000});
  DiscreteExecutor executor(graph, robot.clock, grants, {.start = {}, .hash_topics = true, .observer = &robot.records});
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(graph.set_enabled("dice", i % 2 == 1));
  ASSERT_TRUE(executor.run());
  EXPECT_EQ(grants.calls, 0u);
  EXPECT_GT(grants.grants, 700u);
  EXPECT_GT(robot.records.all.size(), 5000u);
  EXPECT_GT(motors.events.size(), 400u);
}

}  // namespace
}  // namespace sinew::rt::discrete_loop_test
