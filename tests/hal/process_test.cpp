#include "hal/linux/process.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "hal/linux/os.hpp"

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

TEST(ChildProcess, ExitCodeIsReported) {
  auto child = ChildProcess::start({"/bin/sh", "-c", "exit 7"});
  ASSERT_TRUE(child);
  EXPECT_EQ((*child)->wait(10s), 7);
}

TEST(ChildProcess, ProgramThatIsNotThereIsNotFound) {
  auto child = ChildProcess::start({"/no/such/program"});
  ASSERT_FALSE(child);
  EXPECT_EQ(child.error().code, Errc::not_found);
}

TEST(ChildProcess, EndsWithItsOwner) {
  int pid = 0;
  {
    auto child = ChildProcess::start({"/bin/sleep", "1000"});
    ASSERT_TRUE(child);
    pid = (*child)->pid();
    EXPECT_FALSE((*child)->poll());
  }
  EXPECT_NE(kill(pid, 0), 0) << "still there";
}

TEST(ChildProcess, OutputGoesToTheLog) {
  const auto log = std::filesystem::temp_directory_path() / ("sinew_child_" + std::to_string(::getpid()));
  auto child = ChildProcess::start({"/bin/sh", "-c", "echo out; echo err >&2"}, log.string());
  ASSERT_TRUE(child);
  ASSERT_EQ((*child)->wait(10s), 0);
  std::ifstream in(log);
  std::string a, b;
  in >> a >> b;
  std::filesystem::remove(log);
  EXPECT_EQ(a + b, "outerr");
}

TEST(Process, StopIsRequestedByASignalAndTheProcessLives) {
  EXPECT_FALSE(stop_requested());
  raise(SIGTERM);
  EXPECT_TRUE(stop_requested());
}

TEST(Process, KnowsItsUse) {
  const ProcessUse use = process_use();
  EXPECT_GT(use.rss_bytes, 100'000u);
  EXPECT_GT(use.cpu.count(), 0);
  EXPECT_FALSE(program_path().empty());
  EXPECT_GE(usable_cpus(), 1u);
}

// The thread sanitizer keeps a thread of its own, so there a process never has only one.
#ifndef __SANITIZE_THREAD__
TEST(ChildProcess, CopyEndsWithWhatItsBodyAnswers) {
  auto child = ChildProcess::fork([] { return 5; });
  ASSERT_TRUE(child);
  EXPECT_EQ((*child)->wait(10s), 5);
}

TEST(ChildProcess, SignalThatEndedItIsNamed) {
  auto child = ChildProcess::fork([] {
    for (;;) ::pause();
    return 0;
  });
  ASSERT_TRUE(child);
  (*child)->kill_now();
  const auto code = (*child)->wait(10s);
  ASSERT_EQ(code, 128 + SIGKILL);
  EXPECT_EQ(describe_exit(*code), "signal 9 (Killed)");
  EXPECT_EQ(describe_exit(3), "exit code 3");
}

#endif

TEST(ChildProcess, ProcessWithMoreThreadsIsNotCopied) {
  WakeWord over{0};
  auto gates = linux_os().start_thread({}, [&] {
    while (over == 0) linux_os().wait(over, 0, kNever);
  });
  ASSERT_TRUE(gates);
  auto child = ChildProcess::fork([] { return 0; });
  over = 1;
  linux_os().wake(over);
  ASSERT_FALSE(child);
  EXPECT_EQ(child.error().code, Errc::not_supported);
}

}  // namespace
}  // namespace sinew::hal
