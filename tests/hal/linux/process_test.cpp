#include "hal/linux/process.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "hal/platform.hpp"
#include "qemu_user.hpp"

namespace sinew::hal::process_test {
namespace {

constexpr const char* kOwnThread = "it has a thread of its own, and a process with two is not copied";

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

TEST(ChildProcess, ProgramThatIsNotThereIsNotFoundAlsoWhereSignalsInterrupt) {
  struct sigaction before {
  }, action{};
  action.sa_handler = [](int) {};  // without SA_RESTART: read() ends with EINTR
  sigaction(SIGALRM, &action, &before);
  const itimerval often{{0, 500}, {0, 500}}, never{};
  setitimer(ITIMER_REAL, &often, nullptr);
  int not_found = 0;
  for (int i = 0; i < 300; ++i) {
    auto child = ChildProcess::start({"/no/such/program"});
    not_found += !child && child.error().code == Errc::not_found;
  }
  setitimer(ITIMER_REAL, &never, nullptr);
  sigaction(SIGALRM, &before, nullptr);
  EXPECT_EQ(not_found, 300);
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

ChildOptions piped() {
  ChildOptions options;
  options.piped = true;
  return options;
}

TEST(ChildProcess, PipedOutputAndErrorsAreReadApartAlsoAfterTheEnd) {
  auto child = ChildProcess::start({"/bin/sh", "-c", "cat; echo out; echo err >&2"}, piped());
  ASSERT_TRUE(child);
  ASSERT_EQ((*child)->wait(10s), 0) << "its input is empty";
  std::string output, errors;
  while ((*child)->read_output(output, errors)) continue;
  EXPECT_EQ(output, "out\n");
  EXPECT_EQ(errors, "err\n");
}

TEST(ChildProcess, OfSeveralTheOneWithNewsIsNamed) {
  auto silent = ChildProcess::start({"/bin/sleep", "1000"}, piped());
  auto speaks = ChildProcess::start({"/bin/sh", "-c", "echo word; exec sleep 1000"}, piped());
  auto dies = ChildProcess::start({"/bin/sh", "-c", "exec sleep 1000"}, piped());
  ASSERT_TRUE(silent && speaks && dies);
  ChildProcess* const all[] = {silent->get(), speaks->get(), dies->get()};
  std::string output, errors;
  std::vector<std::size_t> ready;
  for (const Time end = system_os().now() + 20s; output.empty() && system_os().now() < end;) {
    ChildProcess::wait_for_any(all, 20s, ready);
    if (std::find(ready.begin(), ready.end(), 1u) != ready.end()) (*speaks)->read_output(output, errors);
  }
  EXPECT_EQ(output, "word\n");
  kill((*dies)->pid(), SIGKILL);
  for (const Time end = system_os().now() + 20s; !(*dies)->poll() && system_os().now() < end;)
    ChildProcess::wait_for_any(all, 20s, ready);
  EXPECT_EQ((*dies)->poll(), 128 + SIGKILL);
  EXPECT_NE(std::find(ready.begin(), ready.end(), 2u), ready.end());
  EXPECT_FALSE((*silent)->poll());
}

TEST(ChildProcess, AStoppedOneIsKnownAndNoEndedOne) {
  auto child = ChildProcess::start({"/bin/sleep", "1000"});
  ASSERT_TRUE(child);
  const auto becomes = [&](bool stopped) {
    for (const Time end = system_os().now() + 20s; system_os().now() < end;) {
      EXPECT_FALSE((*child)->poll());
      if ((*child)->is_stopped() == stopped) return true;
      system_os().sleep_until(system_os().now() + 1ms);
    }
    return false;
  };
  EXPECT_FALSE((*child)->is_stopped());
  kill((*child)->pid(), SIGSTOP);
  EXPECT_TRUE(becomes(true));
  kill((*child)->pid(), SIGCONT);
  EXPECT_TRUE(becomes(false));
}

TEST(ChildProcess, OneThatDoesNotHearTheTerminalOutlivesItsCtrlC) {
  auto child = ChildProcess::start({"/bin/sleep", "1000"}, ChildOptions{.log_path = {}, .hears_terminal = false});
  ASSERT_TRUE(child);
  kill((*child)->pid(), SIGINT);
  EXPECT_FALSE((*child)->wait(50ms));
}

TEST(Process, TheSecondSignalEndsItAtOnceWithItsLastWords) {
  SINEW_SKIP_UNDER_QEMU_USER(kOwnThread);
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  auto child = ChildProcess::fork([&] {
    ::dup2(ends[1], STDERR_FILENO);
    static_cast<void>(stop_requested());
    end_at_second_signal("the end\n");
    raise(SIGINT);
    raise(SIGTERM);  // within a moment: the same one
    if (stop_signals() != 1) return 7;
    system_os().sleep_until(system_os().now() + kOneSignal + 50ms);
    raise(SIGINT);
    return 8;
  });
  ASSERT_TRUE(child);
  EXPECT_EQ((*child)->wait(20s), 1);
  char said[64] = {};
  EXPECT_EQ(::read(ends[0], said, sizeof said - 1), 8);
  EXPECT_STREQ(said, "the end\n");
  ::close(ends[0]), ::close(ends[1]);
}

TEST(Process, StopIsRequestedByASignalAndTheProcessLives) {
  EXPECT_FALSE(stop_requested());
  raise(SIGTERM);
  EXPECT_TRUE(stop_requested());
}

TEST(Process, AnEndOfAChildIsToldAlsoWhereOursWereIgnored) {
  ::signal(SIGCHLD, SIG_IGN);  // our parent may have left it so
  auto child = ChildProcess::start({"/bin/sh", "-c", "exit 7"});
  ASSERT_TRUE(child);
  EXPECT_EQ((*child)->wait(10s), 7);
}

/// The exit code of a child that does `body` while nobody reads its standard output.
int before_a_full_pipe(const std::function<int()>& body) {
  int ends[2];
  if (::pipe(ends) != 0) return -1;
  auto child = ChildProcess::fork([&] {
    ::dup2(ends[1], STDOUT_FILENO);
    return body();
  });
  if (!child) return -1;
  const auto code = (*child)->wait(20s);
  ::close(ends[0]), ::close(ends[1]);
  return code.value_or(-2);
}

TEST(PrintNow, AFullPipeHoldsUpNobody) {
  SINEW_SKIP_UNDER_QEMU_USER(kOwnThread);
  EXPECT_EQ(before_a_full_pipe([] {
              const std::string line(1000, 'x');
              for (int i = 0; i < 1000; ++i) print_now(line);
              return 7;
            }),
            7);
}

TEST(PrintNow, WhatIsTakenComesInOrder) {
  SINEW_SKIP_UNDER_QEMU_USER(kOwnThread);
  const auto file = std::filesystem::temp_directory_path() / ("sinew_print_" + std::to_string(::getpid()));
  auto child = ChildProcess::fork([&] {
    if (!std::freopen(file.c_str(), "w", stdout)) return 1;
    std::printf("one ");
    print_now("two ");
    std::printf("three\n");
    return 0;
  });
  ASSERT_TRUE(child);
  EXPECT_EQ((*child)->wait(20s), 0);
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  std::filesystem::remove(file);
  EXPECT_EQ(line, "one two three");
}

TEST(OutliveTerminal, ALostReaderAndAHangUpEndNothing) {
  SINEW_SKIP_UNDER_QEMU_USER(kOwnThread);
  auto child = ChildProcess::fork([] {
    outlive_terminal();
    ::raise(SIGHUP);
    int ends[2];
    if (::pipe(ends) != 0) return 1;
    ::close(ends[0]);
    return ::write(ends[1], "x", 1) < 0 && errno == EPIPE ? 7 : 2;
  });
  ASSERT_TRUE(child);
  EXPECT_EQ((*child)->wait(20s), 7);
}

TEST(Process, KnowsItsUse) {
  const ProcessUse use = process_use();
  EXPECT_GT(use.rss_bytes, 100'000u);
  EXPECT_GT(use.cpu.count(), 0);
  EXPECT_FALSE(program_path().empty());
  EXPECT_GE(usable_cpus(), 1u);
}

TEST(Process, IsAtLeastAsOldAsTheTimeItComputed) {
  const auto start = process_start();
  ASSERT_TRUE(start);
  EXPECT_GE(system_os().now() - *start + 10ms, process_use().cpu);
}

TEST(Process, ProgramBeganBeforeMainAndAfterItsProcess) {
  const auto process = process_start();
  ASSERT_TRUE(process);
  EXPECT_GE(program_start() + 20ms, *process);
  EXPECT_LE(program_start(), system_os().now());
}

// Like ./run, which becomes the program after it has built it.
TEST(Process, ProgramThatAScriptBecameIsYoungerThanItsProcess) {
  if (std::getenv("SINEW_TEST_PROGRAM_START")) {
    const auto process = process_start();
    ASSERT_TRUE(process);
    EXPECT_GE(program_start() - *process, 250ms);
    return;
  }
  SINEW_SKIP_UNDER_QEMU_USER(kOwnThread);
  const std::string again = "sleep 0.3; SINEW_TEST_PROGRAM_START=1 exec '" + program_path() +
                            "' --gtest_filter=Process.ProgramThatAScriptBecameIsYoungerThanItsProcess";
  auto script = ChildProcess::start({"/bin/sh", "-c", again}, "/dev/null");
  ASSERT_TRUE(script);
  EXPECT_EQ((*script)->wait(20s), 0);
}

// The thread sanitizer has its own thread, so a process there always has more than one.
#ifndef __SANITIZE_THREAD__
TEST(ChildProcess, CopyEndsWithWhatItsBodyAnswers) {
  SINEW_SKIP_UNDER_QEMU_USER(kOwnThread);
  auto child = ChildProcess::fork([] { return 5; });
  ASSERT_TRUE(child);
  EXPECT_EQ((*child)->wait(10s), 5);
}

TEST(ChildProcess, SignalThatEndedItIsNamed) {
  SINEW_SKIP_UNDER_QEMU_USER(kOwnThread);
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

TEST(Process, ACopyWasStartedWhenItWasMade) {
  SINEW_SKIP_UNDER_QEMU_USER(kOwnThread);
  const Time before = system_os().now();
  auto child = ChildProcess::fork([before] {
    const auto start = process_start();
    return start && *start + 20ms > before && *start <= system_os().now() ? 7 : 2;
  });
  ASSERT_TRUE(child);
  EXPECT_EQ((*child)->wait(10s), 7);
}

TEST(ChildProcess, ProcessWithMoreThreadsIsNotCopied) {
  WakeWord over{0};
  auto gates = system_os().start_thread({}, [&] {
    while (over == 0) system_os().wait(over, 0, kNever);
  });
  ASSERT_TRUE(gates);
  auto child = ChildProcess::fork([] { return 0; });
  over = 1;
  system_os().wake(over);
  ASSERT_FALSE(child);
  EXPECT_EQ(child.error().code, Errc::not_supported);
}

}  // namespace
}  // namespace sinew::hal::process_test
