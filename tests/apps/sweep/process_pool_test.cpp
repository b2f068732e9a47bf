#include "apps/sweep/process_pool.hpp"

#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "hal/linux/process.hpp"

namespace sinew::sweep::process_pool_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr hal::Duration kLong = 100s;

Job shell(const std::string& script) { return {.argv = {"/bin/sh", "-c", script}}; }

ProcessPool::Next each(std::vector<Job> jobs) {
  return [jobs = std::move(jobs), next = std::size_t{0}]() mutable -> std::optional<Job> {
    if (next == jobs.size()) return std::nullopt;
    return jobs[next++];
  };
}

/// The results of all jobs by their number.
std::map<std::uint64_t, JobResult> results_of(ProcessPool& pool, std::vector<Job> jobs) {
  std::map<std::uint64_t, JobResult> results;
  EXPECT_TRUE(pool.run(each(std::move(jobs)), [&](std::uint64_t number, const JobResult& result) {
    EXPECT_TRUE(results.emplace(number, result).second) << number;
    return true;
  }));
  return results;
}

/// A folder that goes with the test.
class Folder {
 public:
  Folder() {
    std::string path = (fs::temp_directory_path() / "sinew_pool_test_XXXXXX").string();
    path_ = ::mkdtemp(path.data());
  }
  ~Folder() { fs::remove_all(path_); }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
};

/// The text of a file that a job wrote; empty: it did not.
std::string text_of(const std::string& path) {
  std::ifstream in(path);
  std::string text;
  std::getline(in, text);
  return text;
}

/// Whether the process still executes. One that was killed may wait for long to be reaped by the machine's first
/// process.
bool executes(const std::string& pid) {
  std::ifstream stat("/proc/" + pid + "/stat");
  std::string number, name, state;
  return bool(stat >> number >> name >> state) && state != "Z" && state != "X";
}

/// Whether it ends soon: the kernel kills a group one after another.
bool ends(const std::string& pid) {
  for (int i = 0; i < 2000 && executes(pid); ++i) ::usleep(5000);
  return !pid.empty() && !executes(pid);
}

/// A script that starts a process, and writes the number of that process to `file` at once.
std::string with_a_child(const std::string& file) {
  return "sleep 1000 & echo $! > " + file + ".new; mv " + file + ".new " + file + "; ";
}

TEST(ProcessPool, ACrashIsAResultAndTheOthersGoOn) {
  ProcessPool pool(2, kLong);
  const auto results = results_of(pool, {shell("exit 3"), shell("kill -SEGV $$"), shell("echo fine")});
  ASSERT_EQ(results.size(), 3u);
  EXPECT_EQ(describe_end(results.at(0)), "exit code 3");
  EXPECT_EQ(results.at(1).code, 128 + 11);
  EXPECT_FALSE(results.at(1).hung);
  EXPECT_EQ(describe_end(results.at(1)), "crashed: signal 11 (Segmentation fault)");
  EXPECT_EQ(results.at(2).code, 0);
  EXPECT_EQ(results.at(2).output, "fine\n");
}

TEST(ProcessPool, AHangIsAResultAfterThePatienceAndTheOthersGoOn) {
  ProcessPool pool(1, 300ms);
  const auto results = results_of(pool, {shell("echo before; exec sleep 1000"), shell("echo fine")});
  ASSERT_EQ(results.size(), 2u);
  EXPECT_TRUE(results.at(0).hung);
  EXPECT_EQ(results.at(0).code, 128 + 9);
  EXPECT_EQ(results.at(0).output, "before\n");
  EXPECT_EQ(describe_end(results.at(0)), "hung");
  EXPECT_FALSE(results.at(1).hung);
  EXPECT_EQ(results.at(1).output, "fine\n");
}

TEST(ProcessPool, OneThatHeedsNoSignalIsKilled) {
  ProcessPool pool(1, 100ms);
  const auto results = results_of(pool, {shell("trap '' TERM; while :; do sleep 1; done")});
  EXPECT_TRUE(results.at(0).hung);
  EXPECT_EQ(results.at(0).code, 128 + 9);
}

TEST(ProcessPool, AProgramThatIsNotThereIsToldAndTheOthersGoOn) {
  ProcessPool pool(1, kLong);
  const auto results = results_of(pool, {{.argv = {"/no/such/program"}}, shell("echo fine")});
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results.at(0).not_started, "cannot start /no/such/program: not found");
  EXPECT_NE(results.at(0).code, 0);
  EXPECT_EQ(results.at(1).not_started, "");
  EXPECT_EQ(results.at(1).output, "fine\n");
  EXPECT_EQ(pool.started(), 2u);
}

TEST(ProcessPool, OfMuchOutputTheEndIsKeptOfBothPipes) {
  ProcessPool pool(2, kLong);
  const auto results = results_of(pool, {shell("head -c 3000000 /dev/zero | tr '\\0' o; echo end of output; "
                                               "head -c 3000000 /dev/zero | tr '\\0' e >&2; echo end of errors >&2")});
  const JobResult& r = results.at(0);
  EXPECT_EQ(r.output.size(), ProcessPool::kMostOutput);
  EXPECT_EQ(r.errors.size(), ProcessPool::kMostOutput);
  EXPECT_TRUE(r.output.ends_with("oooend of output\n"));
  EXPECT_TRUE(r.errors.ends_with("eeeend of errors\n"));
}

TEST(ProcessPool, AJobHasNoInput) {
  ProcessPool pool(1, kLong);
  EXPECT_EQ(results_of(pool, {shell("cat; echo end")}).at(0).output, "end\n");
}

TEST(ProcessPool, ResultsComeAsTheyEnd) {
  const Folder folder;
  const std::string gate = folder / "gate";
  std::vector<std::uint64_t> order;
  ProcessPool pool(2, kLong);
  EXPECT_TRUE(pool.run(each({shell("until [ -e " + gate + " ]; do sleep 0.01; done"), shell("")}),
                       [&](std::uint64_t number, const JobResult&) {
                         order.push_back(number);
                         std::ofstream(gate) << "open";  // the first cannot end before this
                         return true;
                       }));
  EXPECT_EQ(order, (std::vector<std::uint64_t>{1, 0}));
}

TEST(ProcessPool, ResultsComeAsTheyBeganWhenAskedForWhateverEndsFirst) {
  const Folder folder;
  const std::string gate = folder / "gate";
  std::vector<std::uint64_t> order;
  ProcessPool pool(2, kLong);
  EXPECT_TRUE(pool.run(
      each({shell("until [ -e " + gate + " ]; do sleep 0.01; done"), shell(""), shell("touch " + gate)}),
      [&](std::uint64_t number, const JobResult&) {
        order.push_back(number);
        return true;
      },
      ProcessPool::Order::as_they_began));
  EXPECT_EQ(order, (std::vector<std::uint64_t>{0, 1, 2}));
}

TEST(ProcessPool, SoManyAreUnderWayAtATimeAndNoMore) {
  const Folder folder;
  const std::string now = folder / "now", begun = folder / "begun";
  fs::create_directory(now), fs::create_directory(begun);
  // Each prints how many there are. The first three wait for each other: there are three at a time.
  const std::string script = "touch " + now + "/$$ " + begun + "/$$; ls " + now + " | wc -l; while [ $(ls " + begun +
                             " | wc -l) -lt 3 ]; do sleep 0.01; done; ls " + now + " | wc -l; rm " + now + "/$$";
  ProcessPool pool(3, kLong);
  int most = 0;
  for (const auto& [number, result] : results_of(pool, std::vector<Job>(12, shell(script)))) {
    int first = 0, second = 0;
    ASSERT_EQ(std::sscanf(result.output.c_str(), "%d %d", &first, &second), 2) << result.output << result.errors;
    most = std::max({most, first, second});
  }
  EXPECT_EQ(most, 3);
}

TEST(ProcessPool, DoneThatAnswersFalseEndsTheRest) {
  const Folder folder;
  const std::string child = folder / "child";
  ProcessPool pool(2, kLong);
  int told = 0;
  EXPECT_FALSE(pool.run(
      each({shell(with_a_child(child) + "wait"), shell("until [ -e " + child + " ]; do sleep 0.01; done"), shell("")}),
      [&](std::uint64_t, const JobResult&) {
        ++told;
        return false;
      }));
  EXPECT_EQ(told, 1);
  EXPECT_EQ(pool.started(), 2u);
  EXPECT_TRUE(ends(text_of(child)));
}

TEST(ProcessPool, ACrashTakesTheProcessesThatTheJobStartedWithIt) {
  const Folder folder;
  const std::string child = folder / "child";
  ProcessPool pool(1, kLong);
  EXPECT_EQ(results_of(pool, {shell(with_a_child(child) + "kill -SEGV $$")}).at(0).code, 128 + 11);
  EXPECT_TRUE(ends(text_of(child)));
}

TEST(ProcessPool, AHangTakesTheProcessesThatTheJobStartedWithIt) {
  const Folder folder;
  const std::string child = folder / "child";
  ProcessPool pool(1, 500ms);
  EXPECT_TRUE(results_of(pool, {shell(with_a_child(child) + "wait")}).at(0).hung);
  EXPECT_TRUE(ends(text_of(child)));
}

// In a process of its own: what requests the stop cannot be undone.
bool stops_from_the_second_job(const std::string& one, const std::string& two) {
  ProcessPool pool(2, kLong);
  bool told = false;
  const std::string press = "until [ -e " + one + " ]; do sleep 0.01; done; kill -INT $PPID; wait";
  const bool through = pool.run(each({shell(with_a_child(one) + "wait"), shell(with_a_child(two) + press), shell("")}),
                                [&](std::uint64_t, const JobResult&) { return told = true; });
  return !through && !told && pool.started() == 2;
}

TEST(ProcessPool, CtrlCEndsThoseUnderWayAndTheirChildren) {
  const Folder folder;
  const std::string one = folder / "one", two = folder / "two";
  EXPECT_EXIT(std::exit(stops_from_the_second_job(one, two) ? 0 : 1), testing::ExitedWithCode(0), "");
  EXPECT_TRUE(ends(text_of(one)));
  EXPECT_TRUE(ends(text_of(two)));
}

// A kernel before 5.3, or a container that forbids the call.
bool runs_without_pidfd() {
  sock_filter code[] = {BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
                        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_pidfd_open, 0, 1),
                        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS),
                        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)};
  const sock_fprog filter{std::size(code), code};
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 || ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) != 0)
    return true;  // this system has no filters
  if (::syscall(SYS_pidfd_open, ::getpid(), 0) >= 0) return false;
  ProcessPool pool(2, kLong);
  const auto results = results_of(pool, {shell("exec >&- 2>&-; exit 3"), shell("kill -SEGV $$"), shell("echo fine")});
  return results.at(0).code == 3 && results.at(1).code == 128 + 11 && results.at(2).output == "fine\n";
}

TEST(ProcessPool, EndsAreSeenWithoutPidfd) {
  EXPECT_EXIT(std::exit(runs_without_pidfd() ? 0 : 1), testing::ExitedWithCode(0), "");
}

TEST(ProcessPool, WhatJobsLeaveInTheTemporaryFolderGoesWithThePool) {
  const std::string before = fs::temp_directory_path().string();
  std::string during;
  {
    ProcessPool pool(1, kLong);
    during = fs::temp_directory_path().string();
    results_of(pool, {shell("mktemp -d && kill -KILL $$")});
    EXPECT_FALSE(fs::is_empty(during));
  }
  EXPECT_NE(during, before);
  EXPECT_FALSE(fs::exists(during));
  EXPECT_EQ(fs::temp_directory_path().string(), before);
}

TEST(ProcessPool, WhatAKilledPoolLeavesGoesWithTheNextPool) {
  const Folder folder;
  const std::string told = folder / "told";
  EXPECT_EXIT(
      {
        ProcessPool pool(1, kLong);
        std::ofstream(told) << fs::temp_directory_path().string();
        results_of(pool, {shell("mktemp -d; kill -KILL $PPID")});
      },
      testing::KilledBySignal(9), "");
  const std::string left = text_of(told);
  ASSERT_TRUE(fs::exists(left)) << left;
  ProcessPool next(1, kLong);
  EXPECT_FALSE(fs::exists(left));
  EXPECT_FALSE(fs::exists(left + ".lock"));
}

/// Whether this process can be copied: the thread sanitizer and qemu-user have threads of their own.
bool can_copy() {
  const auto copy = hal::ChildProcess::fork([] { return 0; });
  return copy || copy.error().code != hal::Errc::not_supported;
}

TEST(ProcessPool, ABodyRunsInACopyThatSeesOurMemoryAndChangesNoneOfIt) {
  if (!can_copy()) GTEST_SKIP() << "this process has other threads";
  std::vector<int> memory(1000, 7);
  std::vector<Job> jobs;
  for (int i = 0; i < 20; ++i)
    jobs.push_back({.body = [&memory, i] {
      std::printf("{\"i\":%d,\"sum\":%d}\n", i, i + memory[999]);
      memory[999] = -1;
      return i;
    }});
  ProcessPool pool(4, kLong);
  const auto results = results_of(pool, jobs);
  ASSERT_EQ(results.size(), 20u);
  for (int i = 0; i < 20; ++i) {
    const JobResult& r = results.at(static_cast<std::uint64_t>(i));
    EXPECT_EQ(r.code, i);
    EXPECT_EQ(r.output, "{\"i\":" + std::to_string(i) + ",\"sum\":" + std::to_string(i + 7) + "}\n");
  }
  EXPECT_EQ(memory[999], 7);
}

TEST(ProcessPool, ABodyThatCrashesOrHangsIsAResult) {
  if (!can_copy()) GTEST_SKIP() << "this process has other threads";
  static_cast<void>(hal::stop_requested());  // as in a command: the copy inherits that signals do not end it
  const Folder folder;
  const std::string mark = folder / "mark";
  std::vector<Job> jobs{{.body = [] { return ::raise(SIGABRT); }},
                        {.body =
                             [] {
                               for (;;) ::pause();
                               return 0;
                             }},
                        {.body = [&mark] { return (std::ofstream(mark) << "done") ? 0 : 1; }}};
  ProcessPool pool(3, 500ms);
  const auto results = results_of(pool, jobs);
  EXPECT_EQ(describe_end(results.at(0)), "crashed: signal 6 (Aborted)");
  EXPECT_TRUE(results.at(1).hung);
  EXPECT_EQ(results.at(2).code, 0);
  EXPECT_EQ(text_of(mark), "done");
}

TEST(ProcessPool, NothingToDoIsDone) {
  ProcessPool pool(0, kLong);
  EXPECT_GE(pool.jobs(), 1u);
  EXPECT_TRUE(results_of(pool, {}).empty());
}

}  // namespace
}  // namespace sinew::sweep::process_pool_test
