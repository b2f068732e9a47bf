#include "hal/platform.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <array>
#include <thread>
#include <vector>

#include "hal/linux/shared_memory.hpp"

namespace sinew::hal::os_test {
namespace {

using namespace std::chrono_literals;

TEST(LinuxOs, ThreadHasWhatWasAskedForOrSaysWhatIsMissing) {
  int policy = -1;
  sched_param param{};
  int cpus = 0;
  std::array<char, 16> name{};
  auto thread = system_os().start_thread({.name = "control", .fifo_priority = 20, .cpus = {0}}, [&] {
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
  auto thread = system_os().start_thread({.name = "lost", .cpus = {1000}}, [&] { ran = true; });
  ASSERT_TRUE(thread);
  (*thread)->join();
  EXPECT_TRUE(ran);
  EXPECT_NE((*thread)->shortfall().find("CPU set refused"), std::string::npos);
}

TEST(LinuxOs, AWaitForSeveralWordsEndsWithTheWakeOfAnyOfThem) {
  std::vector<WakeWord> words(3);
  // More than one call of the kernel takes: the others are looked at from time to time.
  std::vector<WakeWord> crowd(kMostWords + 1);
  for (auto* const all : {&words, &crowd}) {
    const auto ended = [&] {
      std::vector<SeenWord> seen;
      for (const WakeWord& w : *all) seen.push_back({&w, 0});
      while (all->back().load() == 0) wait_any_shared(seen, kNever);
    };
    std::thread waiter(ended);
    all->back().store(1);
    wake_shared(all->back());
    waiter.join();  // for ever, if the wake is missed
  }
  // A word that was changed before.
  wait_any_shared(std::vector<SeenWord>{{&words[0], 0}, {&words[1], 0}, {&words[2], 0}}, kNever);
}

}  // namespace
}  // namespace sinew::hal::os_test
