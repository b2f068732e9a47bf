// The same graph gives the same bytes: twice, and with every compiler (the constants below).
#include <gtest/gtest.h>

#include "graph_fixture.hpp"
#include "math/hash.hpp"

namespace sinew::rt::determinism_test {
namespace {

/// Mixes all that a step may depend on into its output.
class Mixer final : public Module {
 public:
  explicit Mixer(QueueOptions queue) : queue_options_(queue) {}
  void declare(Declaration& d) override {
    d.in("state", state_, {.optional = true});
    d.in("events", events_, queue_options_);
    d.out("out", out_, {.burst = 2});
    d.param("gain", gain_, {.min = -10.0, .max = 10.0});
  }
  void reset() override { sum_ = 0; }
  StepStatus step(const Step& step) noexcept override {
    for (const Pair& p : events_) sum_ = sum_ * 0.75 + p.value[0] * gain_;
    if (const Pair* p = state_.get()) sum_ += p->value[1] / 3.0;
    const std::uint32_t dice = step.random.below(10);
    if (dice == 0) return StepStatus::stale;
    if (dice == 1 && step.number > 20) return StepStatus::fault;
    for (std::uint32_t i = 0; i < 1 + dice % 2; ++i) {
      Pair& out = out_.loan();
      out.stamp = step.now;
      out.number = step.number + events_.dropped();
      out.value = {sum_, step.random.normal(), static_cast<double>(step.dt.count()), step.random.uniform(-1, 1)};
    }
    return StepStatus::ok;
  }

 private:
  const QueueOptions queue_options_;
  In<Pair> state_;
  InQueue<Pair> events_;
  Out<Pair> out_;
  double gain_ = 0.5, sum_ = 0;
};

std::string name_of(std::uint32_t i) { return "m" + std::to_string(i); }

/// A random robot: modules read random others, threads are periodic or wait for topics, and parameters change.
void make(Robot& robot, std::uint64_t seed, std::uint32_t cores) {
  math::Random random(seed);
  constexpr std::uint32_t kThreads = 5, kModules = 9;
  robot.spec.seed = seed;
  robot.spec.virtual_cores = cores;
  robot.fault_limit = 2;
  std::vector<std::vector<std::string>> orders(kThreads);
  const auto thread_of = [](std::uint32_t module) { return module % kThreads; };
  const auto reads = [&](std::uint32_t module) {  // of another thread, or earlier in the own one
    for (;;) {
      const std::uint32_t other = random.below(kModules);
      if (thread_of(other) != thread_of(module) || other < module) return name_of(other) + ".out";
    }
  };
  for (std::uint32_t m = 0; m < kModules; ++m) {
    const QueueOptions queue{.depth = 1 + random.below(4),
                             .overflow = random.below(2) ? Overflow::drop_newest : Overflow::drop_oldest};
    robot.add<Mixer>(name_of(m), {{"state", reads(m)}, {"events", reads(m)}}, queue);
    robot.module(name_of(m)).params["gain"] = {ParamValue(random.uniform(-1, 1)), 0};
    robot.module(name_of(m)).exec.constant = Duration{20'000 + random.below(150'000)};
    orders[thread_of(m)].push_back(name_of(m));
  }
  for (std::uint32_t t = 0; t < kThreads; ++t) {
    const std::string name = "t" + std::to_string(t);
    const int priority = 1 + static_cast<int>(random.below(4));
    if (t < 3) {
      ThreadSpec& spec = robot.periodic(name, priority, Duration{500'000 + 1000 * random.below(900)}, orders[t]);
      spec.overrun = random.below(2) ? ThreadSpec::Overrun::catch_up : ThreadSpec::Overrun::skip;
    } else {
      const std::string trigger = name_of(random.below(3)) + ".out";  // arguments have no order
      robot.on_topics(name, priority, {trigger}, orders[t], Duration{700'000 + random.below(900'000)});
    }
  }
  for (std::uint32_t i = 1; i < 20; ++i)
    robot.grants.at(Time{std::int64_t{i} * 10'000'000}, [&robot, i] {
      const std::string module = name_of(i % kModules);
      EXPECT_TRUE(robot.graph().set_param(module, "gain", ParamValue(0.1 * i)));
      EXPECT_TRUE(robot.graph().set_enabled(name_of((i + 3) % kModules), i % 3 != 0));
    });
}

/// One hash of all topics of a run of 200 ms.
std::uint64_t hash_of_run(std::uint64_t seed, std::uint32_t cores) {
  Robot robot;
  make(robot, seed, cores);
  robot.run(200ms);
  math::Hash64 all;
  for (std::uint32_t t = 0; t < robot.graph().topics().size(); ++t) {
    const std::uint64_t h = robot.runner().topic_hash(t);
    EXPECT_GT(robot.runner().topic_stats(t).messages.value(), 0u) << robot.graph().topics()[t].name;
    all.add(&h, sizeof h);
  }
  return all.value();
}

TEST(Determinism, TheSameGraphGivesTheSameBytesTwice) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    for (const std::uint32_t cores : {1u, 2u})
      EXPECT_EQ(hash_of_run(seed, cores), hash_of_run(seed, cores)) << seed << " on " << cores;
}

TEST(Determinism, ASeedOrACoreMoreGivesOtherBytes) {
  EXPECT_NE(hash_of_run(1, 1), hash_of_run(2, 1));
  EXPECT_NE(hash_of_run(1, 1), hash_of_run(1, 2)) << "preemption has its true effect";
}

TEST(Determinism, EveryCompilerGivesTheSameBytes) {
  EXPECT_EQ(hash_of_run(1, 1), 4251707286487766552u);
  EXPECT_EQ(hash_of_run(2, 2), 4104707941716590462u);
  EXPECT_EQ(hash_of_run(3, 1), 17744797112646194301u);
  EXPECT_EQ(hash_of_run(4, 2), 300281567315597938u);
}

}  // namespace
}  // namespace sinew::rt::determinism_test
