// The parent beside a runtime: what it does when the runtime dies, hangs, or ends as it should.
#include "apps/parent/parent.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "hal/platform.hpp"
#include "msg/actuators.hpp"
#include "qemu_user.hpp"
#include "rt/commit.hpp"
#include "rt/segment.hpp"

namespace sinew::app::parent_test {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class CountedStop final : public hal::StopLine {
 public:
  explicit CountedStop(int& stops, int failures = 0) : stops_(stops), failures_(failures) {}
  hal::Status stop() noexcept override {
    if (failures_-- > 0) return hal::Error{hal::Errc::closed, "not now"};
    ++stops_;
    return {};
  }

 private:
  int &stops_, failures_;
};

// A runtime with nothing but a guardian that commits now and then.
class SmallRuntime {
 public:
  explicit SmallRuntime(ParentLine& line) : line_(line) {
    rt::SegmentPlan plan;
    const auto writer = plan.add_writer("guardian");
    plan.add_topic(writer, {.name = "guardian.motors", .type = &msg::type_info<msg::GuardianState>(), .history = 64});
    auto memory = hal::system_os().shared_memory("sinew", plan.bytes());
    memory_ = std::move(*memory);
    segment_ = std::make_unique<rt::Segment>(plan, *memory_);
    commit_ = std::make_unique<rt::Commit>(*segment_, writer);
    commit_->bind(state_, 0);
  }
  bool supervised() { return line_.supervise(*memory_).has_value(); }
  void commit(int times) {
    for (int i = 0; i < times; ++i) {
      state_.loan().fault_events = ++events_;
      static_cast<void>(commit_->commit({hal::system_os().now()}));
      hal::system_os().sleep_until(hal::system_os().now() + 5ms);
    }
  }

 private:
  ParentLine& line_;
  std::unique_ptr<hal::SharedMemory> memory_;
  std::unique_ptr<rt::Segment> segment_;
  std::unique_ptr<rt::Commit> commit_;
  rt::Out<msg::GuardianState> state_;
  std::uint32_t events_ = 0;
};

class ParentTest : public testing::Test {
 protected:
  void SetUp() override {
#ifdef __SANITIZE_THREAD__
    GTEST_SKIP() << "the thread sanitizer's own thread forbids the fork";
#endif
    SINEW_SKIP_UNDER_QEMU_USER("one thread: it has one of its own, which forbids the fork");
    folder_ = (fs::temp_directory_path() / "sinew_parent_XXXXXX").string();
    ASSERT_NE(::mkdtemp(folder_.data()), nullptr);
    options_.save_to = folder_ + "/faults";
    options_.hang = 10s;  // where nothing is to hang, a busy machine may hold things up
    options_.watchdog = folder_ + "/watchdog";
    ASSERT_EQ(::mkfifo(options_.watchdog.c_str(), 0600), 0);
    watchdog_ = ::open(options_.watchdog.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    ASSERT_GE(watchdog_, 0);
    options_.watchdog_timeout = 1s;
  }
  void TearDown() override {
    ::close(watchdog_);
    if (!folder_.empty()) fs::remove_all(folder_);
  }

  // Of the first line, told when the runtime has begun.
  std::string warning_;

  int run(std::function<int(ParentLine&)> body, int stop_failures = 0, bool another_line = false) {
    testing::internal::CaptureStderr();
    Supervised supervised{.robot = "robot", .body = std::move(body)};
    supervised.stops.push_back({.line = std::make_unique<CountedStop>(stops_, stop_failures)});
    supervised.stops[0].warning->text = warning_;
    if (another_line) supervised.stops[0].open = [this] { return std::make_unique<CountedStop>(other_stops_); };
    const int code = run_with_parent(options_, std::move(supervised));
    said_ = testing::internal::GetCapturedStderr();
    char buffer[4096];
    const auto n = ::read(watchdog_, buffer, sizeof(buffer));
    if (n > 0) fed_.assign(buffer, static_cast<std::size_t>(n));
    return code;
  }
  std::string saved(const std::string& file) {
    std::error_code ignored;  // nothing has been saved yet
    for (const auto& entry : fs::directory_iterator(options_.save_to, ignored)) {
      std::ifstream in(entry.path() / file);
      std::stringstream text;
      text << in.rdbuf();
      return text.str();
    }
    return {};
  }

  std::string folder_, said_, fed_;
  ParentOptions options_;
  int watchdog_ = -1, stops_ = 0, other_stops_ = 0;
};

TEST_F(ParentTest, OrderlyEndStopsNothingAndDisarmsTheWatchdog) {
  const int code = run([](ParentLine& line) {
    SmallRuntime runtime(line);
    if (!runtime.supervised()) return 9;
    runtime.commit(5);
    line.ending();
    return 7;
  });
  EXPECT_EQ(code, 7);
  EXPECT_EQ(stops_, 0);
  ASSERT_GE(fed_.size(), 2u);
  EXPECT_EQ(fed_.back(), 'V');
  EXPECT_FALSE(fs::exists(options_.save_to));
  EXPECT_EQ(said_, "");
}

TEST_F(ParentTest, DeathBySignalStopsTheActuatorsStarvesTheWatchdogAndSavesTheLastMessages) {
  for (const int signal : {SIGKILL, SIGSEGV}) {
    stops_ = 0;
    fed_.clear();
    fs::remove_all(options_.save_to);
    const int code = run([signal](ParentLine& line) {
      SmallRuntime runtime(line);
      if (!runtime.supervised()) return 9;
      runtime.commit(20);
      ::signal(SIGSEGV, SIG_DFL);  // a sanitizer's handler would make an exit of it
      ::raise(signal);
      return 0;
    });
    EXPECT_EQ(code, 1);
    EXPECT_EQ(stops_, 1);
    EXPECT_THAT(fed_, Not(HasSubstr("V")));
    EXPECT_GE(fed_.size(), 1u);
    EXPECT_THAT(said_, HasSubstr("the runtime died: signal " + std::to_string(signal)));
    EXPECT_THAT(saved("fault.json"), HasSubstr("the runtime died: signal " + std::to_string(signal)));
    EXPECT_THAT(saved("messages.jsonl"), HasSubstr("\"fault_events\":1}"));
    EXPECT_THAT(saved("messages.jsonl"), HasSubstr("\"fault_events\":20"));
  }
}

TEST_F(ParentTest, RuntimeThatHangsIsStoppedKilledAndSaved) {
  options_.hang = 300ms;
  const int code = run([](ParentLine& line) {
    SmallRuntime runtime(line);
    if (!runtime.supervised()) return 9;
    runtime.commit(3);
    ::raise(SIGSTOP);
    return 0;
  });
  EXPECT_EQ(code, 1);
  EXPECT_EQ(stops_, 1);
  EXPECT_THAT(fed_, Not(HasSubstr("V")));
  EXPECT_THAT(said_, HasSubstr("the runtime hangs: no commit of the guardian for "));
  EXPECT_THAT(saved("messages.jsonl"), HasSubstr("\"fault_events\":3"));
}

TEST_F(ParentTest, ATerminalThatTakesNoTextDelaysNoStopAndNoSaving) {
  options_.hang = 300ms;
  int terminal[2], stopped[2];
  ASSERT_EQ(::pipe(terminal), 0);
  ASSERT_EQ(::pipe(stopped), 0);
  ASSERT_EQ(::fcntl(terminal[1], F_SETFL, O_NONBLOCK), 0);
  const std::string block(4096, '.');
  while (::write(terminal[1], block.data(), block.size()) > 0) {
  }
  ASSERT_EQ(::fcntl(terminal[1], F_SETFL, 0), 0);  // full: the next text waits until the test reads
  const pid_t parent = ::fork();
  ASSERT_GE(parent, 0);
  if (parent == 0) {
    ::dup2(terminal[1], STDERR_FILENO);
    ::close(terminal[0]);
    class Told final : public hal::StopLine {
     public:
      explicit Told(int pipe) : pipe_(pipe) {}
      hal::Status stop() noexcept override {
        if (::write(pipe_, "s", 1) != 1) return hal::Error{hal::Errc::io, "pipe"};
        return {};
      }

     private:
      int pipe_;
    };
    Supervised supervised{.robot = "robot", .body = [](ParentLine& line) {
                            SmallRuntime runtime(line);
                            if (!runtime.supervised()) return 9;
                            runtime.commit(3);
                            ::raise(SIGSTOP);
                            return 0;
                          }};
    supervised.stops.push_back({.line = std::make_unique<Told>(stopped[1])});
    supervised.stops[0].warning->text = "something that the terminal does not take";
    ::_exit(run_with_parent(options_, std::move(supervised)));
  }
  ::close(stopped[1]);
  pollfd pipe{.fd = stopped[0], .events = POLLIN, .revents = 0};
  EXPECT_EQ(::poll(&pipe, 1, 20'000), 1) << "no stop while the terminal stood still";
  const auto end = hal::system_os().now() + 20s;
  while (saved("fault.json").empty() && hal::system_os().now() < end)
    hal::system_os().sleep_until(hal::system_os().now() + 10ms);
  EXPECT_THAT(saved("fault.json"), HasSubstr("the runtime hangs"));
  std::string said;
  std::array<char, 4096> text{};
  int status = 0;
  ::close(terminal[1]);
  for (ssize_t n = 0; (n = ::read(terminal[0], text.data(), text.size())) > 0;)
    said.append(text.data(), static_cast<std::size_t>(n));
  ASSERT_EQ(::waitpid(parent, &status, 0), parent);
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_THAT(said, HasSubstr("warning: something that the terminal does not take"));
  EXPECT_THAT(said, HasSubstr("the last seconds are in"));
  ::close(terminal[0]);
  ::close(stopped[0]);
}

TEST_F(ParentTest, RuntimeThatCommitsIsNotTakenForHanging) {
  options_.hang = 1500ms;
  const int code = run([](ParentLine& line) {
    SmallRuntime runtime(line);
    if (!runtime.supervised()) return 9;
    runtime.commit(500);
    line.ending();
    return 0;
  });
  EXPECT_EQ(code, 0) << said_;
  EXPECT_EQ(stops_, 0);
}

TEST_F(ParentTest, WhatAStopLineLacksIsToldOnceTheRuntimeHasBegun) {
  warning_ = "no stop line to bus 'can0'";
  EXPECT_EQ(run([](ParentLine&) { return 2; }), 2);
  EXPECT_EQ(said_, "") << "what did not begin has said why";
  EXPECT_EQ(run([](ParentLine& line) {
              SmallRuntime runtime(line);
              if (!runtime.supervised()) return 9;
              runtime.commit(5);
              line.ending();
              return 0;
            }),
            0);
  EXPECT_EQ(said_, "warning: no stop line to bus 'can0'\n");
}

TEST_F(ParentTest, DeathBeforeTheTopicsExistStopsTheActuatorsToo) {
  const int code = run([](ParentLine&) {
    ::raise(SIGKILL);
    return 0;
  });
  EXPECT_EQ(code, 1);
  EXPECT_EQ(stops_, 1);
  EXPECT_FALSE(fs::exists(options_.save_to));
}

TEST_F(ParentTest, StopLineThatFailsIsTriedAgain) {
  const int code = run(
      [](ParentLine&) {
        ::raise(SIGKILL);
        return 0;
      },
      2);
  EXPECT_EQ(code, 1);
  EXPECT_EQ(stops_, 1);
  EXPECT_THAT(said_, HasSubstr("stop of the actuators: sent"));
}

TEST_F(ParentTest, StopLineThatIsBrokenIsReplaced) {
  const int code = run(
      [](ParentLine&) {
        ::raise(SIGKILL);
        return 0;
      },
      1'000'000, true);
  EXPECT_EQ(code, 1);
  EXPECT_EQ(stops_, 0);
  EXPECT_EQ(other_stops_, 1);
  EXPECT_THAT(said_, HasSubstr("stop of the actuators: sent"));
}

TEST_F(ParentTest, ExitInTheMiddleOfARunIsADeath) {
  const int code = run([](ParentLine& line) {
    SmallRuntime runtime(line);
    if (!runtime.supervised()) return 9;
    runtime.commit(3);
    ::_exit(3);  // some library has had enough
  });
  EXPECT_EQ(code, 1);
  EXPECT_EQ(stops_, 1);
  EXPECT_THAT(fed_, Not(HasSubstr("V")));
  EXPECT_THAT(said_, HasSubstr("the runtime died: exit code 3"));
  EXPECT_THAT(saved("messages.jsonl"), HasSubstr("\"fault_events\":3"));
}

TEST_F(ParentTest, StartThatFailsDisarmsTheWatchdog) {
  const int code = run([](ParentLine&) { return 2; });
  EXPECT_EQ(code, 2);
  EXPECT_EQ(stops_, 0);
  ASSERT_FALSE(fed_.empty());
  EXPECT_EQ(fed_.back(), 'V');
}

rt::GraphSpec with_leases(std::initializer_list<hal::Duration> leases) {
  rt::GraphSpec graph;
  for (const hal::Duration lease : leases) graph.actuators.emplace_back().lease = lease;
  return graph;
}

TEST(HangOf, IsHalfASecondOrTwoOfTheSmallestLease) {
  EXPECT_EQ(hang_of({}, with_leases({20ms, 100ms}), 1), 500ms);
  EXPECT_EQ(hang_of({}, with_leases({3s, 2s}), 1), 4s);
  EXPECT_EQ(hang_of({.hang = 60ms}, with_leases({20ms}), 1), 60ms);
}

TEST(HangOf, GrowsForARobotWhoseClockIsSlowAndNeverShrinks) {
  EXPECT_EQ(hang_of({}, with_leases({20ms}), 0.01), 50s);
  EXPECT_EQ(hang_of({}, with_leases({20ms}), 10), 500ms);
}

TEST_F(ParentTest, WatchdogThatCannotBeOpenedRefusesTheStart) {
  options_.watchdog = folder_ + "/nothing";
  EXPECT_EQ(run([](ParentLine&) { return 0; }), 2);
  EXPECT_THAT(said_, HasSubstr("parent.watchdog"));
  EXPECT_THAT(said_, HasSubstr("not found"));
}

}  // namespace
}  // namespace sinew::app::parent_test
