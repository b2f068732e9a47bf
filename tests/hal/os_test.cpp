#include "hal/linux/os.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <array>

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

TEST(LinuxOs, SleepNeverEndsBeforeItsTime) {
  Os& os = linux_os();
  for (int i = 0; i < 20; ++i) {
    const Time until = os.now() + 200us;
    os.sleep_until(until);
    EXPECT_GE(os.now(), until);
  }
}

TEST(LinuxOs, WaitReturnsAtOnceWhenTheWordDiffers) {
  WakeWord word{7};
  linux_os().wait(word, 6, kNever);  // would hang for ever if it slept
}

TEST(LinuxOs, WaitEndsAtItsDeadline) {
  WakeWord word{0};
  const Time deadline = linux_os().now() + 2ms;
  while (linux_os().now() < deadline) linux_os().wait(word, 0, deadline);
  EXPECT_GE(linux_os().now(), deadline);
}

TEST(LinuxOs, WakeEndsAWaitOfAnotherThread) {
  Os& os = linux_os();
  WakeWord word{0};
  std::atomic<int> seen{0};
  auto thread = os.start_thread({.name = "sleeper", .cpus = {}}, [&] {
    while (word.load(std::memory_order_acquire) == 0) os.wait(word, 0, kNever);
    seen = 1;
  });
  ASSERT_TRUE(thread);
  word.store(1, std::memory_order_release);
  os.wake(word);
  (*thread)->join();
  EXPECT_EQ(seen, 1);
}

TEST(LinuxOs, ThreadHasWhatWasAskedForOrSaysWhatIsMissing) {
  int policy = -1;
  sched_param param{};
  int cpus = 0;
  std::array<char, 16> name{};
  auto thread = linux_os().start_thread({.name = "control", .fifo_priority = 20, .cpus = {0}}, [&] {
    pthread_getschedparam(pthread_self(), &policy, &param);
    cpu_set_t set;
    pthread_getaffinity_np(pthread_self(), sizeof(set), &set);
    cpus = CPU_COUNT(&set);
    pthread_getname_np(pthread_self(), name.data(), name.size());
  });
  ASSERT_TRUE(thread);
  (*thread)->join();
  EXPECT_STREQ(name.data(), "control");
  EXPECT_EQ(cpus, 1);
  if ((*thread)->shortfall().empty()) {
    EXPECT_EQ(policy, SCHED_FIFO);
    EXPECT_EQ(param.sched_priority, 20);
  } else {
    EXPECT_NE((*thread)->shortfall().find("SCHED_FIFO refused"), std::string::npos);
  }
}

TEST(LinuxOs, CpuThatDoesNotExistIsNamedAndTheThreadStillRuns) {
  bool ran = false;
  auto thread = linux_os().start_thread({.name = "lost", .cpus = {1000}}, [&] { ran = true; });
  ASSERT_TRUE(thread);
  (*thread)->join();
  EXPECT_TRUE(ran);
  EXPECT_NE((*thread)->shortfall().find("CPU set refused"), std::string::npos);
}

TEST(LinuxOs, SharedMemoryThatNoMachineHasIsRefused) {
  EXPECT_EQ(linux_os().shared_memory("sinew-test", SIZE_MAX).error().code, Errc::out_of_memory);
  EXPECT_EQ(linux_os().shared_memory("sinew-test", SIZE_MAX / 4096 * 4096).error().code, Errc::out_of_memory);
}

TEST(LinuxOs, SharedMemoryIsZeroedAndPageAligned) {
  auto memory = linux_os().shared_memory("sinew-test", 10'000);
  ASSERT_TRUE(memory);
  EXPECT_GE((*memory)->size(), 10'000u);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>((*memory)->data()) % 4096, 0u);
  for (std::size_t i = 0; i < (*memory)->size(); ++i) ASSERT_EQ((*memory)->data()[i], std::byte{0});
}

TEST(LinuxOs, ThreadCpuTimeGrowsWithWorkAndNotWithSleep) {
  Os& os = linux_os();
  const Duration before = os.thread_cpu_time();
  volatile std::uint64_t sum = 0;
  while (os.thread_cpu_time() - before < 1ms) sum = sum + 1;
  EXPECT_GT(sum, 0u);
}

}  // namespace
}  // namespace sinew::hal
