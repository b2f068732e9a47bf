// The schedule against the brute-force oracle on random graphs: cores, priorities, ties, CPU sets, topic and device
// triggers, time-outs, overruns with both policies, periods that change.
#include <gtest/gtest.h>

#include <sstream>

#include "math/random.hpp"
#include "rt/exec/schedule.hpp"
#include "schedule_oracle.hpp"

namespace sinew::rt::schedule_oracle_test {
namespace {

constexpr int kHorizonUs = 400;
constexpr int kGraphs = 10'000;

struct Graph {
  std::vector<oracle::Thread> threads;
  int cores = 1;
  std::uint64_t seed = 0;

  int demand(unsigned thread, unsigned module, unsigned n) const {
    math::Random r(seed, thread * 16 + module, n);
    return 1 + static_cast<int>(r.next_u32() % (r.next_u32() % 4 == 0 ? 30 : 9));
  }
};

Graph random_graph(std::uint64_t seed) {
  math::Random r(seed, 0, 0);
  const auto below = [&](std::uint32_t n) { return r.next_u32() % n; };
  Graph g;
  g.seed = seed;
  g.cores = 1 + static_cast<int>(below(3));
  const unsigned count = 1 + below(6);
  for (unsigned i = 0; i < count; ++i) {
    oracle::Thread t;
    t.priority = 1 + static_cast<int>(below(4));
    t.modules = 1 + below(3);
    if (below(3) == 0)
      for (int k = 0; k < g.cores; ++k)
        if (below(2)) t.cpus.push_back(k);
    const unsigned kind = below(4);
    if (kind <= 1) {
      t.trigger = oracle::Thread::period;
      t.period_us = 5 + static_cast<int>(below(60));
      t.phase_us = static_cast<int>(below(30));
      t.catch_up = below(2);
      t.catch_up_max = 1 + below(3);
      if (below(3) == 0)
        for (int at = static_cast<int>(below(100)); at < kHorizonUs; at += 1 + static_cast<int>(below(150)))
          t.new_periods.push_back({at, 5 + static_cast<int>(below(60))});
    } else {
      t.trigger = kind == 2 ? oracle::Thread::topics : oracle::Thread::device;
      if (below(2)) t.timeout_us = 10 + static_cast<int>(below(60));
      if (kind == 3)
        for (int at = static_cast<int>(below(20)); at <= kHorizonUs; at += 1 + static_cast<int>(below(50)))
          t.ready_us.push_back(at);
    }
    g.threads.push_back(std::move(t));
  }
  for (unsigned i = 0; i < count; ++i) {
    g.threads[i].wakes.resize(g.threads[i].modules);
    for (auto& listeners : g.threads[i].wakes)
      for (unsigned k = 0; k < count; ++k)
        if (g.threads[k].trigger == oracle::Thread::topics && k != i && below(3) == 0) listeners.push_back(k);
  }
  return g;
}

/// Runs the production schedule on the same graph and writes the same kind of record.
class Player final : public ScheduleClient {
 public:
  explicit Player(const Graph& graph) : graph_(graph), state_(graph.threads.size()) {
    std::vector<ScheduleThread> threads;
    for (const auto& t : graph.threads) {
      ScheduleThread s;
      s.priority = t.priority;
      s.cpus = t.cpus;
      s.trigger = t.trigger == oracle::Thread::period   ? ThreadSpec::Trigger::period
                  : t.trigger == oracle::Thread::topics ? ThreadSpec::Trigger::topics
                                                        : ThreadSpec::Trigger::device;
      s.period = std::chrono::microseconds(t.period_us);
      s.phase = std::chrono::microseconds(t.phase_us);
      s.timeout = std::chrono::microseconds(t.timeout_us);
      s.overrun = t.catch_up ? ThreadSpec::Overrun::catch_up : ThreadSpec::Overrun::skip;
      s.catch_up_max = t.catch_up_max;
      s.modules = t.modules;
      threads.push_back(std::move(s));
    }
    for (std::size_t i = 0; i < state_.size(); ++i) state_[i].steps.assign(graph.threads[i].modules, 0);
    schedule_ = std::make_unique<Schedule>(std::move(threads), static_cast<std::uint32_t>(graph.cores), Time{0}, *this);
    for (unsigned i = 0; i < graph.threads.size(); ++i) announce(i);
  }

  oracle::Outcome run() {
    std::vector<int> posts;
    for (const auto& t : graph_.threads)
      for (const auto& post : t.new_periods) posts.push_back(post.at_us);
    std::sort(posts.begin(), posts.end());
    for (posted_to_us_ = -1; const int at : posts) {
      schedule_->run_until(Time{at * 1000});
      posted_to_us_ = at;
    }
    schedule_->run_until(Time{kHorizonUs * 1000});
    for (unsigned i = 0; i < graph_.threads.size(); ++i) {
      const ScheduleCounters& c = schedule_->counters(i);
      out_.counters.push_back({c.releases, c.completions, c.overruns, c.skips, c.coalesced, c.timeouts, c.preemptions});
    }
    return out_;
  }

  Duration start(std::uint32_t thread, std::uint32_t module, const CycleInfo& cycle, Time now) noexcept override {
    State& s = state_[thread];
    if (module == 0 && graph_.threads[thread].trigger == oracle::Thread::device) {
      const auto& ready = graph_.threads[thread].ready_us;
      while (s.device_at < ready.size() && ready[s.device_at] * 1000 <= now.ns) ++s.device_at;
      announce(thread);
    }
    const auto& posts = graph_.threads[thread].new_periods;
    for (; module == 0 && s.posts_taken < posts.size() && posts[s.posts_taken].at_us <= posted_to_us_;
         ++s.posts_taken) {
      schedule_->restart_period(thread, std::chrono::microseconds(posts[s.posts_taken].period_us));
      ++restarts;
    }
    s.event = out_.events.size();
    out_.events.push_back({thread, module, us(cycle.release), us(now), -1, cycle.timed_out});
    return std::chrono::microseconds(graph_.demand(thread, module, s.steps[module]++));
  }

  void complete(std::uint32_t thread, std::uint32_t module, Time now) noexcept override {
    out_.events[state_[thread].event].end = us(now);
    for (unsigned listener : graph_.threads[thread].wakes[module]) schedule_->trigger(listener);
  }

  std::uint64_t restarts = 0;

 private:
  struct State {
    std::size_t device_at = 0, event = 0, posts_taken = 0;
    std::vector<unsigned> steps;
  };
  static int us(Time t) { return t.ns % 1000 == 0 ? static_cast<int>(t.ns / 1000) : -1; }

  void announce(unsigned thread) {
    if (graph_.threads[thread].trigger != oracle::Thread::device) return;
    const auto& ready = graph_.threads[thread].ready_us;
    const std::size_t at = state_[thread].device_at;
    schedule_->announce(thread, at < ready.size() ? Time{ready[at] * 1000} : hal::kNever);
  }

  const Graph& graph_;
  std::vector<State> state_;
  oracle::Outcome out_;
  int posted_to_us_ = -1;
  std::unique_ptr<Schedule> schedule_;
};

std::string describe(const Graph& g) {
  std::ostringstream s;
  s << g.cores << " cores\n";
  for (std::size_t i = 0; i < g.threads.size(); ++i) {
    const auto& t = g.threads[i];
    s << "thread " << i << " priority " << t.priority << " modules " << t.modules << " trigger " << int(t.trigger)
      << " period " << t.period_us << " phase " << t.phase_us << " timeout " << t.timeout_us << " catch_up "
      << (t.catch_up ? t.catch_up_max : 0) << " cpus";
    for (int c : t.cpus) s << ' ' << c;
    for (const auto& post : t.new_periods) s << " at " << post.at_us << " period " << post.period_us;
    s << '\n';
  }
  return s.str();
}

std::string text(const oracle::Event& e) {
  std::ostringstream s;
  s << "thread " << e.thread << " module " << e.module << " release " << e.release << " start " << e.start << " end "
    << e.end << (e.timed_out ? " timed out" : "");
  return s.str();
}

TEST(ScheduleOracle, AgreesOnStartCompletionAndPreemptionsForTenThousandRandomGraphs) {
  std::uint64_t steps = 0, restarts = 0;
  oracle::Counters sum;
  for (int seed = 1; seed <= kGraphs; ++seed) {
    const Graph g = random_graph(static_cast<std::uint64_t>(seed));
    oracle::Simulator simulator(
        g.threads, g.cores, [&](unsigned thread, unsigned module, unsigned n) { return g.demand(thread, module, n); });
    const oracle::Outcome expected = simulator.run(kHorizonUs);
    Player player(g);
    const oracle::Outcome actual = player.run();
    restarts += player.restarts;
    for (std::size_t i = 0; i < std::min(expected.events.size(), actual.events.size()); ++i)
      ASSERT_EQ(text(actual.events[i]), text(expected.events[i])) << "seed " << seed << "\n" << describe(g);
    ASSERT_EQ(actual.events.size(), expected.events.size()) << "seed " << seed << "\n" << describe(g);
    for (std::size_t i = 0; i < g.threads.size(); ++i) {
      const auto &a = actual.counters[i], &e = expected.counters[i];
      ASSERT_EQ(a.releases, e.releases) << "seed " << seed << " thread " << i << "\n" << describe(g);
      ASSERT_EQ(a.completions, e.completions) << "seed " << seed << " thread " << i << "\n" << describe(g);
      ASSERT_EQ(a.overruns, e.overruns) << "seed " << seed << " thread " << i << "\n" << describe(g);
      ASSERT_EQ(a.skips, e.skips) << "seed " << seed << " thread " << i << "\n" << describe(g);
      ASSERT_EQ(a.coalesced, e.coalesced) << "seed " << seed << " thread " << i << "\n" << describe(g);
      ASSERT_EQ(a.timeouts, e.timeouts) << "seed " << seed << " thread " << i << "\n" << describe(g);
      ASSERT_EQ(a.preemptions, e.preemptions) << "seed " << seed << " thread " << i << "\n" << describe(g);
      sum.overruns += e.overruns, sum.skips += e.skips, sum.coalesced += e.coalesced;
      sum.timeouts += e.timeouts, sum.preemptions += e.preemptions;
    }
    steps += expected.events.size();
  }
  // The graphs must have exercised everything, or agreement would mean little.
  EXPECT_GT(steps, 100'000u);
  EXPECT_GT(restarts, 10'000u);
  for (std::uint64_t n : {sum.overruns, sum.skips, sum.coalesced, sum.timeouts, sum.preemptions}) EXPECT_GT(n, 10'000u);
  RecordProperty("steps", std::to_string(steps));
  RecordProperty("restarts", std::to_string(restarts));
  RecordProperty("preemptions", std::to_string(sum.preemptions));
}

}  // namespace
}  // namespace sinew::rt::schedule_oracle_test
