// The kernel's real-time throttle itself: a thread that does not sleep meets it. Takes up to three seconds of one
// processor.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "graph_fixture.hpp"
#include "hal/linux/system_files.hpp"
#include "probe_os.hpp"
#include "rt/exec/real_time_executor.hpp"

namespace sinew::rt::throttle_test {
namespace {

/// Uses up 12 ms of processor time in each of its first steps and sees for itself when one took as much longer as the
/// kernel freezes; after them it lets the machine go, whatever the test does.
class Hungry final : public Module {
 public:
  static constexpr std::uint64_t kSteps = 250;
  Hungry(hal::Os& os, Duration throttle) : os_(os), throttle_(throttle) {}
  void declare(Declaration&) override {}
  StepStatus step(const Step& step) noexcept override {
    if (step.number >= kSteps) {
      full.store(true, std::memory_order_relaxed);
      return StepStatus::ok;
    }
    const Time begin = os_.now();
    const Duration before = os_.thread_cpu_time();
    Duration used{};
    while (used < 12ms) used = os_.thread_cpu_time() - before;
    const Duration lost = os_.now() - begin - used;
    if (lost > throttle_ * 9 / 10 && lost < throttle_ * 11 / 10) frozen.store(true, std::memory_order_relaxed);
    return StepStatus::ok;
  }
  std::atomic<bool> frozen{false}, full{false};

 private:
  hal::Os& os_;
  const Duration throttle_;
};

TEST(KernelThrottle, IsNamedWhereItFreezesAThreadThatDoesNotSleep) {
  const hal::SystemFiles files("/");
  const auto period_us = files.number("proc/sys/kernel/sched_rt_period_us");
  const auto runtime_us = files.number("proc/sys/kernel/sched_rt_runtime_us");
  if (!period_us || !runtime_us || *runtime_us < 0) GTEST_SKIP() << "this kernel does not throttle fixed priorities";
  RealTimeOptions options;
  options.throttle = {std::chrono::microseconds(*period_us), std::chrono::microseconds(*period_us - *runtime_us)};
  if (options.throttle.period > 1s || options.throttle.frozen < GapWatch::kGap)
    GTEST_SKIP() << "its throttle comes too rarely or takes too little: " << *runtime_us << " of " << *period_us
                 << " us";
  options.lock_memory = options.keep_awake = false;

  ProbeOs os;
  Robot robot;
  robot.virtual_time = false;
  Hungry& hungry = robot.add<Hungry>("hungry", {}, os, options.throttle.frozen);
  ThreadSpec& thread = robot.periodic("main", 50, 10ms, {"hungry"});
  thread.overrun = ThreadSpec::Overrun::catch_up;
  thread.cpus = {0};  // each processor has a throttle of its own
  RealTimeExecutor executor(robot.build(), os, options);
  ASSERT_TRUE(executor.start());
  if (!executor.shortfalls().empty()) GTEST_SKIP() << executor.shortfalls()[0];
  const ThreadStats& stats = executor.runner().thread_stats(0);
  while (!hungry.full && stats.throttled.count.value() == 0) std::this_thread::sleep_for(10ms);
  executor.stop();
  const std::uint64_t named = stats.throttled.count.value();
  if (!hungry.frozen && named == 0)
    GTEST_SKIP() << "this kernel let it run for three seconds; it took " << stats.taken.count.value() << " other gaps";
  EXPECT_GE(named, 1u) << "but " << stats.taken.count.value() << " gaps of another kind";
}

}  // namespace
}  // namespace sinew::rt::throttle_test
