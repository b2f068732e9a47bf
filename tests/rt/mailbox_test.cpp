// Requests from outside: every kind, between two cycles, with the step from which it takes effect.
#include "rt/mailbox.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "graph_fixture.hpp"
#include "hal/platform.hpp"
#include "msg/operator.hpp"
#include "rt/exec/real_time_executor.hpp"
#include "rt/external_source.hpp"
#include "rt/trap.hpp"
#include "test_modules.hpp"
#include "trap.hpp"
#include "until.hpp"

namespace sinew::rt::mailbox_test {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;

template <class M>
std::span<const std::byte> bytes_of(const M& message) {
  return std::as_bytes(std::span(&message, 1));
}

hal::Result<Ticket> say(Graph& graph, std::uint32_t sequence, std::string* why = nullptr) {
  msg::OperatorLink link;
  link.stamp = Time{-5};  // of another clock: nobody sees it
  link.sequence = sequence;
  link.quality = 0.5f;
  return graph.publish("operator.link", bytes_of(link), why);
}

/// Keeps the operator's messages, and when they came in.
class Listener final : public Module {
 public:
  explicit Listener(std::uint32_t depth = 64) : depth_(depth) { seen.reserve(100'000), stamps.reserve(100'000); }
  void declare(Declaration& d) override { d.in("link", in_, {.depth = depth_}); }
  StepStatus step(const Step&) noexcept override {
    for (const msg::OperatorLink& link : in_) {
      seen.push_back(link.sequence);
      stamps.push_back(link.stamp);
    }
    count.store(seen.size(), std::memory_order_release);
    return in_.dropped() == 0 ? StepStatus::ok : StepStatus::fault;
  }
  std::vector<std::uint32_t> seen;
  std::vector<Time> stamps;
  std::atomic<std::size_t> count{0};

 private:
  const std::uint32_t depth_;
  InQueue<msg::OperatorLink> in_;
};

/// One module at 1 kHz that hears what comes from outside.
struct OperatedRobot : Robot {
  OperatedRobot() {
    listener = &add<Listener>("listener", {{"link", "operator.link"}});
    periodic("main", 10, 1ms, {"listener"});
    spec.topics.push_back({"operator.link", 0, 0, 0, ExternalSpec{"OperatorLink", "main"}});
  }
  Listener* listener;
};

std::vector<Time> releases(const Robot& robot, std::string_view module) {
  std::vector<Time> all;
  for (const StepRecord& r : robot.steps(module)) all.push_back(r.release);
  return all;
}

Time ms(std::int64_t n) { return Time{n * 1'000'000}; }

// ---- the mailbox itself

TEST(Mailbox, TellsOfEachRequestWhetherItWasRefused) {
  Mailbox mailbox(2);
  for (std::uint32_t round = 0; round < 5; ++round) {
    const auto a = mailbox.post({}), b = mailbox.post({});
    ASSERT_TRUE(a && b);
    EXPECT_EQ(mailbox.post({}).error().code, hal::Errc::busy);
    EXPECT_EQ(mailbox.effect(*a), std::nullopt);
    ASSERT_TRUE(mailbox.take());
    mailbox.done({round, true});
    EXPECT_EQ(mailbox.effect(*b), std::nullopt);
    ASSERT_TRUE(mailbox.take());
    mailbox.done({0xFFFFFFFF, false});
    EXPECT_EQ(mailbox.effect(*a), (Effect{round, true}));
    EXPECT_EQ(mailbox.effect(*b), (Effect{0xFFFFFFFF, false}));
    if (round > 0) {
      EXPECT_EQ(mailbox.effect(*a - 2), std::nullopt) << "too long ago";
    }
  }
}

// ---- thread period

TEST(ThreadPeriod, RestartsThePhaseWhereItIsTaken) {
  Robot robot;
  robot.add<Numbers>("numbers");
  robot.periodic("main", 10, 1ms, {"numbers"});
  Graph& graph = robot.build();
  hal::Result<Ticket> slow = hal::Error{}, fast = hal::Error{};
  robot.grants.at(Time{2'500'000}, [&] { slow = graph.set_period("main", 4ms); });
  robot.grants.at(ms(8), [&] { fast = graph.set_period("main", 500us); });
  robot.run(12200us);
  EXPECT_THAT(releases(robot, "numbers"),
              ElementsAre(ms(0), ms(1), ms(2), ms(3), ms(7), ms(11), Time{11'500'000}, ms(12)));
  std::vector<Duration> dt;
  for (const StepRecord& r : robot.steps("numbers")) dt.push_back(r.dt);
  EXPECT_THAT(dt, ElementsAre(1ms, 1ms, 1ms, 1ms, 4ms, 4ms, 500us, 500us));
  EXPECT_EQ(graph.effect(*slow), Effect{3}) << "the thread's cycles count from 0";
  EXPECT_EQ(graph.effect(*fast), Effect{5});
  EXPECT_EQ(robot.thread_stats("main").period_ns.value(), 500'000);
}

TEST(ThreadPeriod, CountsFromTheInstantAtWhichALateCycleBegins) {
  Robot robot;
  robot.add<Numbers>("urgent");
  robot.add<Numbers>("numbers");
  robot.module("urgent").exec.constant = 300us;
  robot.periodic("urgent", 20, 10ms, {"urgent"});
  robot.periodic("main", 10, 2ms, {"numbers"});
  Graph& graph = robot.build();
  ASSERT_TRUE(graph.set_period("main", 5ms));
  robot.run(12ms);
  EXPECT_THAT(releases(robot, "numbers"), ElementsAre(ms(0), Time{5'300'000}, Time{10'300'000}));
}

TEST(ThreadPeriod, IsRefusedWithTheReason) {
  Robot robot;
  robot.add<Numbers>("numbers");
  robot.add<Relay>("relay", {{"in", "numbers.out"}});
  robot.periodic("main", 10, 1ms, {"numbers"});
  robot.on_topics("reader", 5, {"numbers.out"}, {"relay"});
  Graph& graph = robot.build();
  const auto refused = [&graph](const char* thread, Duration period) {
    std::string why;
    const auto ticket = graph.set_period(thread, period, &why);
    EXPECT_FALSE(ticket) << why;
    return why;
  };
  EXPECT_EQ(refused("mian", 1ms), "no thread mian");
  EXPECT_EQ(refused("reader", 1ms), "reader is not released by a period");
  EXPECT_EQ(refused("main", Duration{9'999}), "9.999 us: a number from 10 to 3600000000");
  EXPECT_EQ(refused("main", Duration{3600s} + 1ns), "3600000000.001 us: a number from 10 to 3600000000");
  EXPECT_TRUE(graph.set_period("main", 10us));
  EXPECT_TRUE(graph.set_period("main", 3600s));
}

// ---- switches and arming

TEST(WayIn, WhatBelongsToTheRuntimeStaysOn) {
  OperatedRobot robot;
  robot.add<Numbers>("numbers");
  robot.board.add("motors", robot.clock);
  class Commander final : public Module {
   public:
    void declare(Declaration& d) override { d.out("out", out_); }
    StepStatus step(const Step&) noexcept override { return StepStatus::stale; }

   private:
    Out<msg::ActuatorCommand> out_;
  };
  robot.add<Commander>("commander");
  robot.periodic("control", 20, 1ms, {"commander", "numbers"});
  robot.spec.actuators.push_back({"motors", {"commander.out", 0}, 1, 0, 1, 0, 20ms, ActuatorSpec::Safe::stop, 0});
  Graph& graph = robot.build();
  std::string why;
  EXPECT_EQ(graph.set_enabled("guardian", false, &why).error().code, hal::Errc::not_supported);
  EXPECT_EQ(why, "guardian belongs to the runtime; it stays on");
  EXPECT_EQ(graph.set_enabled("operator", false, &why).error().code, hal::Errc::not_supported);
  EXPECT_EQ(graph.set_enabled("numbres", false, &why).error().code, hal::Errc::not_found);
  EXPECT_EQ(why, "no module numbres; there are: guardian listener numbers commander operator");
}

TEST(WayIn, ArmingGoesToTheGuardianWhichMayRefuse) {
  Robot robot;
  robot.board.add("motors", robot.clock);
  class Commander final : public Module {
   public:
    void declare(Declaration& d) override { d.out("out", out_); }
    StepStatus step(const Step&) noexcept override { return StepStatus::stale; }

   private:
    Out<msg::ActuatorCommand> out_;
  };
  robot.add<Commander>("commander");
  robot.periodic("control", 20, 1ms, {"commander"});
  robot.spec.actuators.push_back({"motors", {"commander.out", 0}, 1, 0, 1, 0, 20ms, ActuatorSpec::Safe::stop, 0});
  Graph& graph = robot.build();
  hal::Result<Ticket> arm = hal::Error{}, disarm = hal::Error{};
  robot.grants.at(ms(15), [&] { arm = graph.arm(); });
  robot.grants.at(ms(25), [&] { disarm = graph.disarm(); });
  robot.run(35ms);
  ASSERT_TRUE(arm && disarm);
  ASSERT_TRUE(graph.effect(*arm) && graph.effect(*disarm));
  EXPECT_EQ(graph.effect(*arm), (Effect{1, true})) << "the guardian looks every 10 ms; there is no command yet";
  EXPECT_EQ(graph.effect(*disarm), Effect{2});
}

TEST(WayIn, ARobotWithoutActuatorsHasNothingToArm) {
  Robot robot;
  robot.add<Numbers>("numbers");
  robot.periodic("main", 10, 1ms, {"numbers"});
  std::string why;
  EXPECT_EQ(robot.build().arm(&why).error().code, hal::Errc::not_supported);
  EXPECT_EQ(why, "this robot has no actuators and so no guardian");
}

TEST(WayIn, IsClosedBeforeTheGraphIsConfigured) {
  OperatedRobot robot;
  Graph graph(robot.spec, robot.types);
  std::string why;
  EXPECT_FALSE(graph.set_enabled("listener", false, &why));
  EXPECT_EQ(why, "the graph is not configured yet");
  EXPECT_FALSE(say(graph, 1, &why));
  EXPECT_EQ(why, "the graph is not configured yet");
  EXPECT_EQ(graph.effect(Ticket{0, 0}), std::nullopt);
}

// ---- external topics

TEST(ExternalTopic, IsPublishedInTheNextCycleInOrderAndStampedWithItsNow) {
  OperatedRobot robot;
  Graph& graph = robot.build();
  std::vector<hal::Result<Ticket>> tickets;
  robot.grants.at(Time{1'500'000}, [&] {
    for (const std::uint32_t n : {7u, 8u, 9u}) tickets.push_back(say(graph, n));
  });
  robot.grants.at(ms(4), [&] { tickets.push_back(say(graph, 10)); });
  robot.run(6500us);
  EXPECT_THAT(robot.listener->seen, ElementsAre(7, 8, 9, 10));
  EXPECT_THAT(robot.listener->stamps, ElementsAre(ms(2), ms(2), ms(2), ms(5))) << "4 ms had begun when it was posted";
  EXPECT_EQ(graph.effect(*tickets[0]), Effect{2});
  EXPECT_EQ(graph.effect(*tickets[2]), Effect{2});
  EXPECT_EQ(graph.effect(*tickets[3]), Effect{5});
  EXPECT_EQ(robot.runner().topic_stats(graph.find_topic("operator.link")).messages.value(), 4u);
}

TEST(ExternalTopic, ReleasesThreadsAndBeginsChainsAsAnyOther) {
  OperatedRobot robot;
  Listener& other = robot.add<Listener>("other", {{"link", "operator.link"}});
  robot.on_topics("other", 5, {"operator.link"}, {"other"});
  robot.spec.chains.push_back({"link", {"operator.link", 0}, {"operator.link", 0}, {}, 0});
  Graph& graph = robot.build();
  robot.grants.at(Time{1'500'000}, [&] { EXPECT_TRUE(say(graph, 3)); });
  robot.run(4ms);
  EXPECT_THAT(other.seen, ElementsAre(3));
  ASSERT_EQ(robot.steps("other").size(), 1u);
  EXPECT_EQ(robot.steps("other")[0].release, Time{2'001'000}) << "the source takes 1 us";
  EXPECT_EQ(robot.runner().chain_stats(0).age.count(), 1u);
}

TEST(ExternalTopic, TakesTypesThatOnlyTheRobotsModulesKnow) {
  OperatedRobot robot;
  Relay& relay = robot.add<Relay>("relay", {{"in", "operator.pair"}});
  robot.spec.threads[0].order.push_back({"relay", 0});
  robot.spec.topics.push_back({"operator.pair", 0, 0, 0, ExternalSpec{"Pair", "main"}});
  Graph& graph = robot.build();
  Pair pair;
  pair.number = 77;
  ASSERT_TRUE(graph.publish("operator.pair", bytes_of(pair)));
  ASSERT_TRUE(say(graph, 1));
  robot.run(500us);
  EXPECT_THAT(relay.seen, ElementsAre(77));
  EXPECT_THAT(robot.listener->seen, ElementsAre(1));
}

TEST(ExternalTopic, RefusesWhatIsNoMessageOfItWithTheReason) {
  OperatedRobot robot;
  robot.add<Numbers>("numbers");
  robot.spec.threads[0].order.push_back({"numbers", 0});
  Graph& graph = robot.build();
  msg::OperatorLink link;
  const auto refused = [&](const char* topic, std::span<const std::byte> bytes) {
    std::string why;
    EXPECT_FALSE(graph.publish(topic, bytes, &why)) << why;
    return why;
  };
  EXPECT_EQ(refused("operator.lnik", bytes_of(link)), "no topic operator.lnik");
  EXPECT_EQ(refused("numbers.out", bytes_of(Pair{})),
            "numbers.out is written by module numbers; only topics with writer = \"external\" take messages");
  EXPECT_EQ(refused("operator.link", bytes_of(link).first(15)), "15 bytes: OperatorLink has 16");
  EXPECT_EQ(refused("operator.link", {}), "0 bytes: OperatorLink has 16");
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    link.quality = bad;
    EXPECT_EQ(refused("operator.link", bytes_of(link)), "not finite: finite numbers in every field");
  }
  robot.run(1500us);
  EXPECT_TRUE(robot.listener->seen.empty());
}

TEST(ExternalTopic, TooManyAreRefusedAndCountedAndNoneIsLost) {
  OperatedRobot robot;
  Graph& graph = robot.build();
  std::vector<std::uint32_t> expected;
  std::uint64_t refused = 0;
  std::string why;
  for (int cycle = 0; cycle < 5; ++cycle)
    robot.grants.at(Time{500'000} + cycle * 1ms, [&] {
      for (std::uint32_t i = 0; i < 20; ++i) {
        const auto n = static_cast<std::uint32_t>(expected.size());
        if (say(graph, n, &why))
          expected.push_back(n);
        else
          ++refused;
      }
    });
  robot.run(6500us);
  EXPECT_EQ(expected.size(), 5u * ExternalSource::kRoom);
  EXPECT_THAT(robot.listener->seen, ElementsAreArray(expected));
  EXPECT_EQ(refused, 5u * 4u);
  EXPECT_EQ(graph.busy_posts(), refused);
  EXPECT_EQ(why, "16 messages of operator wait already");
}

TEST(ExternalTopic, AFullMailboxGivesTheMessagesPlaceBack) {
  OperatedRobot robot;
  Graph& graph = robot.build();
  while (graph.set_enabled("listener", true)) {
  }
  std::string why;
  for (std::uint32_t i = 0; i < 3 * ExternalSource::kRoom; ++i) EXPECT_FALSE(say(graph, i, &why));
  EXPECT_EQ(why, "the mailbox of thread main is full");
  robot.grants.at(Time{500'000}, [&] {
    for (std::uint32_t i = 0; i < ExternalSource::kRoom; ++i) EXPECT_TRUE(say(graph, i)) << i;
  });
  robot.run(1500us);
  EXPECT_EQ(robot.listener->seen.size(), ExternalSource::kRoom);
}

// ---- all together

class Heard final : public RunObserver {
 public:
  Heard() { all.reserve(1000); }
  struct Entry {
    Request::Kind kind;
    Effect effect;
    Time now;
    bool operator==(const Entry&) const = default;
  };
  void completed(const StepRecord&) noexcept override {}
  void taken(const Request& request, const Effect& effect, Time now) noexcept override {
    if (all.size() < all.capacity()) all.push_back({request.kind, effect, now});
  }
  std::vector<Entry> all;
};

TEST(WayIn, AnObserverHearsEveryRequestInOrderWithItsEffect) {
  OperatedRobot robot;
  Graph& graph = robot.build();
  Heard heard;
  robot.grants.at(Time{1'500'000}, [&] {
    EXPECT_TRUE(say(graph, 1));
    EXPECT_TRUE(graph.set_enabled("listener", false));
    EXPECT_TRUE(graph.set_period("main", 2ms));
    EXPECT_TRUE(graph.set_enabled("listener", true));
  });
  robot.grants.end = ms(5);
  DiscreteExecutor executor(graph, robot.clock, robot.grants, {.observer = &heard});
  ASSERT_TRUE(executor.run());
  using K = Request::Kind;
  EXPECT_THAT(heard.all, ElementsAre(Heard::Entry{K::message, {2}, ms(2)}, Heard::Entry{K::disable, {2}, ms(2)},
                                     Heard::Entry{K::set_period, {2}, ms(2)}, Heard::Entry{K::enable, {0}, ms(2)}));
}

/// What the robot did when the same things were asked of it between the same grants.
std::uint64_t hash_of_an_operated_run(Duration posted_at) {
  OperatedRobot robot;
  robot.add<Relay>("relay", {{"in", "numbers.out"}});
  robot.add<Numbers>("numbers");
  robot.periodic("fast", 20, 370us, {"numbers", "relay"});
  Graph& graph = robot.build();
  robot.grants.at(Time{} + posted_at, [&] {
    EXPECT_TRUE(graph.set_period("fast", 410us));
    EXPECT_TRUE(say(graph, 5));
    EXPECT_TRUE(graph.set_enabled("numbers", false));
    EXPECT_TRUE(graph.set_enabled("numbers", true));
  });
  robot.run(20ms);
  return robot.hash("relay.out") ^ robot.hash("operator.link") * 3;
}

TEST(WayIn, TheSameRequestsBetweenTheSameGrantsGiveTheSameBytes) {
  const std::uint64_t a = hash_of_an_operated_run(7300us), b = hash_of_an_operated_run(7300us),
                      other = hash_of_an_operated_run(9300us);
  EXPECT_EQ(a, b);
  EXPECT_NE(a, other);
}

TEST(WayIn, TakingRequestsAllocatesLocksAndCallsTheKernelNotOnce) {
  if (!sinew::trap::is_set()) GTEST_SKIP() << "no trap in this build";
  OperatedRobot robot;
  Graph& graph = robot.build();
  std::uint32_t calls = 0;
  class Trapped final : public hal::GrantSource {
   public:
    explicit Trapped(std::uint32_t& calls, Graph& graph) : calls_(calls), graph_(graph) {}
    hal::Result<Time> next_grant(Time done) override {
      trap::state = {};
      if (done >= ms(200)) return hal::Error{hal::Errc::closed, "end"};
      const auto n = static_cast<std::uint32_t>(done.ns / 1'000'000);
      EXPECT_TRUE(say(graph_, n));
      EXPECT_TRUE(graph_.set_enabled("listener", n % 5 != 3));
      EXPECT_TRUE(graph_.set_period("main", n % 2 ? 1100us : 900us));
      trap::state = {"the executor's loop", &calls_};
      return done + 2ms;
    }

   private:
    std::uint32_t& calls_;
    Graph& graph_;
  } grants(calls, graph);
  DiscreteExecutor executor(graph, robot.clock, grants, {.observer = &robot.records});
  ASSERT_TRUE(executor.run());
  trap::state = {};
  EXPECT_EQ(calls, 0u);
  EXPECT_GT(robot.listener->seen.size(), 50u);
}

// ---- real threads

RealTimeOptions without_privileges() {
  RealTimeOptions options;
  options.start_delay = 1ms;
  options.lock_memory = false;
  return options;
}

TEST(RealTimeWayIn, EveryAcceptedMessageOfManyPostersComesInOnceAndInItsOrder) {
  constexpr std::uint32_t kPosters = 4, kEach = 500;
  OperatedRobot robot;
  robot.virtual_time = false;
  RealTimeExecutor executor(robot.build(), hal::system_os(), without_privileges());
  ASSERT_TRUE(executor.start());
  std::vector<std::thread> posters;
  std::array<std::vector<Ticket>, kPosters> tickets;
  for (std::uint32_t p = 0; p < kPosters; ++p)
    posters.emplace_back([&, p] {
      for (std::uint32_t i = 0; i < kEach;) {
        if (const auto ticket = say(robot.graph(), p << 16 | i)) {
          tickets[p].push_back(*ticket);
          ++i;
        } else {
          std::this_thread::yield();
        }
      }
    });
  for (auto& t : posters) t.join();
  EXPECT_TRUE(until([&] { return robot.listener->count.load() >= kPosters * kEach; }));
  executor.stop();
  EXPECT_EQ(robot.listener->seen.size(), kPosters * kEach);
  std::array<std::uint32_t, kPosters> next{};
  for (const std::uint32_t n : robot.listener->seen) EXPECT_EQ(n & 0xFFFF, next[n >> 16]++);
  EXPECT_TRUE(robot.graph().effect(tickets[0].back()) || robot.graph().effect(tickets[1].back()) ||
              robot.graph().effect(tickets[2].back()) || robot.graph().effect(tickets[3].back()));
}

TEST(RealTimeWayIn, APeriodChangesAndItsPhaseRestarts) {
  OperatedRobot robot;
  robot.virtual_time = false;
  RealTimeOptions options = without_privileges();
  Records records;
  options.runner.observer = &records;
  RealTimeExecutor executor(robot.build(), hal::system_os(), options);
  ASSERT_TRUE(executor.start());
  const ThreadStats& stats = executor.runner().thread_stats(0);
  ASSERT_TRUE(until([&] { return stats.completions.value() >= 5; }));
  const auto ticket = robot.graph().set_period("main", 3ms);
  ASSERT_TRUE(ticket);
  ASSERT_TRUE(until([&] { return robot.graph().effect(*ticket).has_value(); }));
  const std::uint32_t at = robot.graph().effect(*ticket)->step;
  const std::uint64_t begun = stats.completions.value();
  ASSERT_TRUE(until([&] { return stats.completions.value() >= begun + 10; }));
  executor.stop();
  EXPECT_EQ(stats.period_ns.value(), 3'000'000);
  const auto steps = records.of(robot.graph().find_module("operator"));  // the first of the thread's cycle
  ASSERT_GT(steps.size(), at + 1);
  for (std::uint32_t k = 0; k <= at; ++k) EXPECT_EQ((steps[k].release - executor.started_at()) % 1ms, Duration{0}) << k;
  const Time restart = steps[at].now;
  for (std::uint32_t k = at + 1; k < steps.size(); ++k) {
    EXPECT_GT(steps[k].release, restart);
    EXPECT_EQ((steps[k].release - restart) % 3ms, Duration{0}) << k << ": counted from where it was taken";
  }
}

}  // namespace
}  // namespace sinew::rt::mailbox_test
