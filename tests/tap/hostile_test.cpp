// Robots beside hostile programs: the same bytes in virtual time, nothing lost in real time, and an honest client still
// gets its answers.
#include <signal.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "hal/linux/process.hpp"
#include "qemu_user.hpp"
#include "tap_rig.hpp"

namespace sinew::tap::hostile_test {
namespace {

OwnRunDir g_run_dir;

/// The hostile program, which is built beside this one.
std::string hostile_program() {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "tap_hostile").string();
}

/// One run of the hostile program.
class Hostile {
 public:
  Hostile(const Robot& robot, const std::string& what, const std::string& amount)
      : log_(g_run_dir.path() + "/" + what + ".log") {
    auto started = hal::ChildProcess::start(test::command(hostile_program(), {what, robot.name->path(), amount}), log_);
    if (started)
      process_ = std::move(*started);
    else
      ADD_FAILURE() << hostile_program() << ": " << started.error().where;
  }
  bool done() { return !process_ || process_->poll().has_value(); }
  void expect_well() {
    if (!process_) return;
    const auto code = process_->wait(100s);
    std::ifstream in(log_);
    const std::string said((std::istreambuf_iterator<char>(in)), {});
    EXPECT_EQ(code.value_or(-1), 0) << said;
    std::printf("[ hostile  ] %s", said.c_str());
  }

 private:
  std::string log_;
  std::unique_ptr<hal::ChildProcess> process_;
};

/// Effects that a robot must not show after any visit.
void expect_unhurt(Robot& robot) {
  rt::Runner& runner = robot.real->runner();
  for (std::uint32_t m = 0; m < robot.graph.modules().size(); ++m) {
    EXPECT_EQ(runner.module_stats(m).fault.value(), 0U) << robot.graph.modules()[m].spec.name;
    EXPECT_EQ(runner.module_stats(m).stopped.value(), 0U) << robot.graph.modules()[m].spec.name;
  }
  for (std::uint32_t t = 0; t < robot.graph.topics().size(); ++t)
    EXPECT_EQ(runner.topic_drops(t), 0U) << robot.graph.topics()[t].name;
  auto client = robot.client();
  ASSERT_TRUE(client);
  const Json status = ask(*client, "status");
  ASSERT_EQ(status["ok"], true) << status;
  const Json set = ask(*client, "param.set", {{"module", "counter"}, {"param", "gain"}, {"value", 2}});
  EXPECT_EQ(set["ok"], true) << set;
}

class Beside : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(Beside, RobotIsUnhurtInRealTime) {
  RobotOptions options;
  options.server.limits.patience = 500ms;
  options.server.limits.may_be_replaced_after = 100ms;
  const auto [what, amount] = GetParam();
  if (what == std::string("spin")) options.graph.eye_period = 300us, options.graph.image_history = 1;  // hard to catch
  Robot robot(options);
  robot.start();
  Hostile hostile(robot, what, amount);
  hostile.expect_well();
  const auto counter = robot.graph.find_module("counter");
  const auto before = robot.real->runner().module_stats(counter).steps.value();
  while (robot.real->runner().module_stats(counter).steps.value() < before + 10) std::this_thread::sleep_for(1ms);
  expect_unhurt(robot);
}
INSTANTIATE_TEST_SUITE_P(Hostile, Beside,
                         testing::Values(std::pair{"write", "0"}, std::pair{"spin", "1"}, std::pair{"wake", "1"},
                                         std::pair{"garbage", "60"}, std::pair{"half", "1"}, std::pair{"flood", "1"},
                                         std::pair{"sit", "1"}, std::pair{"killed", "1000"}),
                         [](const auto& p) { return std::string(p.param.first); });

TEST(Hostile, HalfRequestsAndUnreadRepliesAreNotWaitedForLong) {
  RobotOptions options;
  options.server.limits.patience = 200ms;
  Robot robot(options);
  robot.start();
  Hostile half(robot, "half", "2"), flood(robot, "flood", "2");
  half.expect_well(), flood.expect_well();
  EXPECT_GE(robot.server->stats().closed_slow.value(), 4U) << "four half requests, and who floods";
}

TEST(Hostile, WhoTakesAllPlacesGivesWay) {
  RobotOptions options;
  options.server.limits.may_be_replaced_after = 100ms;
  Robot robot(options);
  robot.start();
  Hostile sits(robot, "sit", "3");
  while (robot.server->stats().accepted.value() < 16 && !sits.done()) std::this_thread::sleep_for(1ms);
  std::unique_ptr<Client> client;
  std::string why;
  while (!client && !sits.done()) {
    if (auto c = Client::connect("robot", why)) client = std::move(*c);
  }
  ASSERT_TRUE(client) << why;
  EXPECT_EQ(ask(*client, "status")["ok"], true);
  EXPECT_GE(robot.server->stats().made_room.value(), 1U);
  sits.expect_well();
  EXPECT_GE(robot.server->stats().refused_full.value(), 8U) << "two above four of each process";
}

TEST(Hostile, AnotherUserIsNotAnsweredEvenWhenLetIntoTheFolder) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  Robot robot;
  robot.start();
  ::chmod(g_run_dir.path().c_str(), 0711);
  ::chmod(robot.name->path().c_str(), 0666);
  Hostile stranger(robot, "stranger", "0");
  stranger.expect_well();
  EXPECT_EQ(robot.server->stats().refused_peers.value(), 1U);
  ::chmod(g_run_dir.path().c_str(), 0700);
}

TEST(Hostile, WhatAKilledRobotLeftBehindIsTakenOver) {
  auto process = hal::ChildProcess::start(test::command(hostile_program(), {"hold", "robot"}), "/dev/null");
  ASSERT_TRUE(process);
  const int pid = (*process)->pid();
  const std::string socket = g_run_dir.path() + "/robot.sock";
  std::string why;
  while (!std::filesystem::exists(socket)) ASSERT_FALSE((*process)->poll());
  ASSERT_EQ(running(why)->size(), 1U);
  EXPECT_EQ((*running(why))[0].pid, pid);
  const auto second = Name::take("robot", why);
  ASSERT_FALSE(second);
  EXPECT_EQ(why, "robot \"robot\" runs already, as process " + std::to_string(pid));
  ::kill(pid, SIGKILL);
  ASSERT_TRUE((*process)->wait(10s));
  EXPECT_TRUE(running(why)->empty());
  ASSERT_TRUE(std::filesystem::exists(socket)) << "left behind";
  Robot robot;
  robot.start();
  EXPECT_EQ(ask(*robot.client(), "hello")["pid"], ::getpid());
}

/// Grants a millisecond at a time, slowly; the last one only when no hostile program runs any more.
class SlowGrants final : public hal::GrantSource {
 public:
  SlowGrants(hal::Time end, std::function<bool()> may_end) : end_(end), may_end_(std::move(may_end)) {}
  hal::Result<hal::Time> next_grant(hal::Time done) override {
    std::this_thread::sleep_for(200us);
    while (done + 10ms >= end_ && !may_end_()) std::this_thread::sleep_for(1ms);
    return std::min(end_, done + 1ms);
  }

 private:
  hal::Time end_;
  std::function<bool()> may_end_;
};

std::vector<std::uint64_t> hashes_of_a_run(bool beside_hostiles) {
  Robot robot;
  std::vector<std::unique_ptr<Hostile>> hostiles;
  const auto all_done = [&] {
    return std::all_of(hostiles.begin(), hostiles.end(), [](const auto& h) { return h->done(); });
  };
  robot.prepare(4s, std::make_unique<SlowGrants>(hal::Time{} + 4s, all_done));
  if (beside_hostiles)
    for (const auto& [what, amount] : {std::pair{"write", "0"},
                                       {"spin", "2"},
                                       {"wake", "2"},
                                       {"garbage", "50"},
                                       {"flood", "1"},
                                       {"half", "1"},
                                       {"killed", "300"}})
      hostiles.push_back(std::make_unique<Hostile>(robot, what, amount));
  const auto report = robot.discrete->run();
  EXPECT_TRUE(report);
  for (auto& h : hostiles) h->expect_well();
  std::vector<std::uint64_t> hashes;
  for (std::uint32_t t = 0; t < robot.graph.topics().size(); ++t) {
    hashes.push_back(robot.discrete->runner().topic_hash(t));
    if (robot.graph.topics()[t].name == "operator.range") continue;
    EXPECT_GT(robot.discrete->runner().topic_stats(t).messages.value(), 0U) << robot.graph.topics()[t].name;
  }
  return hashes;
}

TEST(Hostile, ChangesNoByteInVirtualTime) { EXPECT_EQ(hashes_of_a_run(true), hashes_of_a_run(false)); }

}  // namespace
}  // namespace sinew::tap::hostile_test
