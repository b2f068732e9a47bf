// Virtual time: grants, clocks, execution-time models, ends, and the same bytes every time.
#include "rt/exec/discrete_executor.hpp"

#include <gtest/gtest.h>

#include "executor_fixture.hpp"

namespace sinew::rt::discrete_executor_test {
namespace {

using End = DiscreteReport::End;
using hal::Errc;

struct ScriptedGrants final : hal::GrantSource {
  std::vector<hal::Result<Time>> script;
  std::vector<Time> done;
  std::function<void()> on_call;
  std::size_t next = 0;
  hal::Result<Time> next_grant(Time done_to) override {
    done.push_back(done_to);
    if (on_call) on_call();
    return script[next++];
  }
};

class InVirtualTime : public ::testing::Test {
 protected:
  InVirtualTime() {
    instants.reserve(1000);
    g.module("m", {}, {}, [this](Probe&, const Step& step) {
      instants.push_back(step.now.ns);
      EXPECT_EQ(g.clock.now(), step.now) << "devices see the instant of the event";
      return StepStatus::ok;
    });
    g.periodic("t", 1, 1ms, {"m"});
  }
  DiscreteReport run(ScriptedGrants& grants, DiscreteOptions options = {}) {
    EXPECT_EQ(g.build(), "");
    executor = std::make_unique<DiscreteExecutor>(*g.graph, g.clock, grants, options);
    grants.on_call = [this, stop = stop_at_call, n = 0]() mutable {
      if (++n == stop) executor->request_stop();
    };
    return *executor->run();
  }
  GraphRig g;
  std::vector<std::int64_t> instants;
  std::unique_ptr<DiscreteExecutor> executor;
  int stop_at_call = 0;
};

TEST_F(InVirtualTime, EverythingUpToAndIncludingTheGrantIsDone) {
  ScriptedGrants grants;
  grants.script = {Time{0}, Time{999'999}, Time{1'000'000}, Time{1'000'000}, hal::Error{Errc::closed, "over"}};
  const auto report = run(grants);
  EXPECT_EQ(report.end, End::source_closed);
  EXPECT_EQ(report.reached, Time{1'000'000});
  EXPECT_EQ(instants, (std::vector<std::int64_t>{0, 1'000'000}));
  EXPECT_EQ(grants.done, (std::vector<Time>{{0}, {0}, {999'999}, {1'000'000}, {1'000'000}}));
}

TEST_F(InVirtualTime, TheDurationCutsTheLastGrant) {
  ScriptedGrants grants;
  grants.script = {Time{10'000'000}};
  const auto report = run(grants, {.duration = 2ms});
  EXPECT_EQ(report.end, End::duration);
  EXPECT_EQ(report.reached, Time{2'000'000});
  EXPECT_EQ(instants.size(), 3u);
}

TEST_F(InVirtualTime, ARunMayStartAtAnyInstant) {
  ScriptedGrants grants;
  grants.script = {Time{77'500'000}};
  const auto report = run(grants, {.start = Time{75'000'000}, .duration = 2ms});
  EXPECT_EQ(report.reached, Time{77'000'000});
  EXPECT_EQ(instants, (std::vector<std::int64_t>{75'000'000, 76'000'000, 77'000'000}));
}

TEST_F(InVirtualTime, AGrantThatGoesBackEndsTheRun) {
  ScriptedGrants grants;
  grants.script = {Time{2'000'000}, Time{1'000'000}};
  const auto report = run(grants);
  EXPECT_EQ(report.end, End::source_failed);
  EXPECT_EQ(report.error.code, Errc::bad_data);
}

TEST_F(InVirtualTime, AFailingSourceIsToldFromAClosedOne) {
  ScriptedGrants grants;
  grants.script = {hal::Error{Errc::timeout, "plant"}};
  const auto report = run(grants);
  EXPECT_EQ(report.end, End::source_failed);
  EXPECT_EQ(report.error.code, Errc::timeout);
}

TEST_F(InVirtualTime, AStopIsObeyedAtTheNextGrant) {
  ScriptedGrants grants;
  grants.script = {Time{1'000'000}, Time{2'000'000}, Time{3'000'000}};
  stop_at_call = 2;
  const auto report = run(grants);
  EXPECT_EQ(report.end, End::stop_requested);
  EXPECT_EQ(report.reached, Time{2'000'000});
}

/// Has only CPU time; every question for it takes 7 us.
struct CountingOs final : hal::Os {
  Duration cpu{};
  Time now() const noexcept override { return {}; }
  void sleep_until(Time) noexcept override {}
  void wait(hal::WakeWord&, std::uint32_t, Time) noexcept override {}
  void wake(hal::WakeWord&) noexcept override {}
  Duration thread_cpu_time() noexcept override { return cpu += 7us; }
  hal::Result<std::unique_ptr<hal::Thread>> start_thread(const hal::ThreadOptions&, std::function<void()>) override {
    return none();
  }
  hal::Result<std::unique_ptr<hal::SharedMemory>> shared_memory(std::string_view, std::size_t) override {
    return none();
  }
  hal::Status lock_memory() override { return none(); }
  static hal::Error none() { return {Errc::not_supported, "test"}; }
};

TEST_F(InVirtualTime, AMeasuredExecutionTimeIsTheStepsCpuTimeTimesItsFactor) {
  g.spec.modules[0].exec = {ExecModel::Kind::measured, {}, {}, 3.0};
  CountingOs os;
  ScriptedGrants grants;
  grants.script = {Time{10'000'000}};
  run(grants, {.duration = 4500us, .os = &os});
  const Histogram& exec = executor->runner().module_stats(0).exec;
  EXPECT_EQ(exec.count(), 5u);
  EXPECT_EQ(exec.min(), 21us);
  EXPECT_EQ(exec.max(), 21us);
}

/// The execution times of a run, of module 0.
struct ExecLog final : RunObserver {
  std::vector<Duration> exec;
  void completed(const StepRecord& record) noexcept override { exec.push_back(record.exec); }
};

const std::vector<ExecModel::Quantile> kHalfTenTailHundred = {{0.5, 10us}, {0.9, 20us}, {1.0, 100us}};

std::vector<Duration> drawn(std::uint64_t seed, double factor, int steps) {
  GraphRig g;
  g.spec.seed = seed;
  g.module("m", {}, {}).exec = {ExecModel::Kind::quantiles, {}, {}, factor, kHalfTenTailHundred};
  g.periodic("t", 1, 1ms, {"m"});
  EXPECT_EQ(g.build(), "");
  ExecLog log;
  log.exec.reserve(static_cast<std::size_t>(steps) + 1);
  g.options.observer = &log;
  g.run(Duration{1ms} * steps);
  return log.exec;
}

TEST(DrawnExecutionTimes, FollowTheirDistribution) {
  const auto all = drawn(1, 1.0, 4000);
  ASSERT_EQ(all.size(), 4000u);
  std::size_t ten = 0, to_20 = 0, to_60 = 0;
  for (const Duration d : all) {
    EXPECT_GE(d, 10us);
    EXPECT_LE(d, 100us);
    ten += d == 10us;
    to_20 += d <= 20us;
    to_60 += d <= 60us;
  }
  // Five sigma of a binomial count either way; straight lines between the points, so half of the tail is below 60 us.
  EXPECT_NEAR(static_cast<double>(ten), 2000, 160);
  EXPECT_NEAR(static_cast<double>(to_20), 3600, 95);
  EXPECT_NEAR(static_cast<double>(to_60), 3800, 70);
}

TEST(DrawnExecutionTimes, AreAFunctionOfTheSeedAndTheStep) {
  const auto once = drawn(7, 1.0, 300);
  EXPECT_EQ(drawn(7, 1.0, 300), once);
  EXPECT_NE(drawn(8, 1.0, 300), once);
  const auto longer = drawn(7, 1.0, 600);
  EXPECT_TRUE(std::equal(once.begin(), once.end(), longer.begin()));
}

TEST(DrawnExecutionTimes, AreStretchedByTheFactor) {
  const auto once = drawn(7, 1.0, 300), thrice = drawn(7, 3.0, 300);
  for (std::size_t i = 0; i < once.size(); ++i) EXPECT_EQ(thrice[i], once[i] * 3);
}

TEST_F(InVirtualTime, AMeasuredExecutionTimeWithoutAnOsIsRefused) {
  g.spec.modules[0].exec = {ExecModel::Kind::measured, {}, {}, 3.0};
  ASSERT_EQ(g.build(), "");
  ScriptedGrants grants;
  DiscreteExecutor refused(*g.graph, g.clock, grants);
  const auto report = refused.run();
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, Errc::not_supported);
}

TEST_F(InVirtualTime, TheReportedCountersAreThoseOfTheSchedule) {
  g.spec.modules[0].exec.constant = 2300us;
  ScriptedGrants grants;
  grants.script = {Time{10'000'000}};
  run(grants, {.duration = 6ms});
  const ThreadStats& s = executor->runner().thread_stats(0);
  EXPECT_EQ(s.releases.value(), 3u);  // 0, 3, 6 ms
  EXPECT_EQ(s.overruns.value(), 4u);
  EXPECT_EQ(s.skips.value(), 4u);
  EXPECT_EQ(s.exec.max(), 2300us);
}

// ---- the same bytes every time

/// A graph of modules that mix all that a step may use, chosen by a seed.
class Mixed {
 public:
  explicit Mixed(std::uint64_t seed) : random_(seed, 1) {
    rig.spec.seed = seed;
    rig.spec.virtual_cores = 1 + random_.below(3);
    const std::uint32_t threads = 2 + random_.below(4);
    std::vector<std::string> written;
    for (std::uint32_t t = 0; t < threads; ++t) {
      std::vector<std::string> order;
      const std::size_t before = written.size();
      for (std::uint32_t m = 1 + random_.below(3); m > 0; --m) order.push_back(add_module(t, m, written));
      const std::string name = "t" + std::to_string(t);
      const int priority = 1 + static_cast<int>(random_.below(5));
      if (before > 0 && random_.below(3) == 0) {
        const std::string& trigger = written[random_.below(static_cast<std::uint32_t>(before))];
        ThreadSpec& on_topic = rig.on_topic(name, priority, trigger, order);
        if (random_.below(2)) on_topic.timeout = 3ms;
      } else {
        ThreadSpec& periodic = rig.periodic(name, priority, Duration{(200 + random_.below(3000)) * 1000}, order);
        periodic.phase = Duration{random_.below(1000) * 1000};
      }
    }
  }
  /// The hash of every topic.
  std::vector<std::uint64_t> run() {
    rig.options.hash_topics = true;
    EXPECT_EQ(rig.build(), "");
    EXPECT_TRUE(rig.graph->set_param(rig.spec.modules[0].name, "gain", 0.25));
    rig.run(300ms);
    std::vector<std::uint64_t> hashes;
    for (std::uint32_t t = 0; t < rig.graph->topics().size(); ++t) hashes.push_back(rig.runner().topic_hash(t));
    return hashes;
  }
  GraphRig rig;

 private:
  std::string add_module(std::uint32_t thread, std::uint32_t m, std::vector<std::string>& written) {
    const std::string name = "m" + std::to_string(thread) + "_" + std::to_string(m);
    GraphRig::Bindings in;
    for (const char* port : {"in", "queue"})
      if (!written.empty() && random_.below(3) > 0)
        in[port] = written[random_.below(static_cast<std::uint32_t>(written.size()))];
    const auto overflow = random_.below(2) ? Overflow::drop_oldest : Overflow::drop_newest;
    const auto declares = [overflow](Declaration& d, Probe& p) {
      d.in("in", p.in, {.max_age = 2ms, .optional = true});
      d.in("queue", p.queue, {.depth = 3, .overflow = overflow, .optional = true});
      d.out("out", p.out);
      d.param("gain", p.gain, {.min = 0.0, .max = 2.0});
    };
    rig.module(name, declares, in, mixes, Duration{(10 + random_.below(400)) * 1000});
    written.push_back(name + ".out");
    return name;
  }
  static StepStatus mixes(Probe& p, const Step& step) {
    Pair& out = p.out.loan();
    out.stamp = step.now;
    out.number = step.number;
    out.value[0] = p.gain * step.random.normal();
    out.value[1] = msg::seconds(step.dt);
    if (const Pair* in = p.in.fresh(step.now)) out.value[2] = in->value[0] - in->value[2] + p.in.updated();
    for (const Pair& event : p.queue) out.value[3] = 0.5 * out.value[3] + event.value[0] + p.queue.dropped();
    if (step.random.below(10) == 0) return StepStatus::stale;
    return step.random.below(50) == 0 ? StepStatus::fault : StepStatus::ok;
  }
  math::Random random_;
};

TEST(SameBytes, TwoRunsOfTheSameGraphGiveTheSameHashOnEveryTopic) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) EXPECT_EQ(Mixed(seed).run(), Mixed(seed).run()) << "seed " << seed;
}

TEST(SameBytes, AnotherSeedOfTheRunGivesOtherBytes) {
  Mixed a(3), b(3);
  b.rig.spec.seed = 4;
  EXPECT_NE(a.run(), b.run());
}

TEST(SameBytes, ThePiecesInWhichTimeIsGrantedDoNotMatter) {
  Mixed whole(5), pieces(5);
  const auto expected = whole.run();
  pieces.rig.options.hash_topics = true;
  ASSERT_EQ(pieces.rig.build(), "");
  ASSERT_TRUE(pieces.rig.graph->set_param(pieces.rig.spec.modules[0].name, "gain", 0.25));
  struct Pieces final : hal::GrantSource {
    hal::Result<Time> next_grant(Time done) override { return done + 333us; }
  } grants;
  DiscreteExecutor executor(*pieces.rig.graph, pieces.rig.clock, grants, {.duration = 300ms, .hash_topics = true});
  ASSERT_TRUE(executor.run());
  for (std::uint32_t t = 0; t < expected.size(); ++t) EXPECT_EQ(executor.runner().topic_hash(t), expected[t]);
}

/// One number over many graphs, the same for every compiler, preset and processor.
TEST(SameBytes, EveryBuildGivesTheSameHash) {
  math::Hash64 all;
  for (std::uint64_t seed = 100; seed < 120; ++seed)
    for (const std::uint64_t hash : Mixed(seed).run()) all.add(&hash, sizeof hash);
  EXPECT_EQ(all.value(), 17124470235699842852u);
}

}  // namespace
}  // namespace sinew::rt::discrete_executor_test
