#pragma once
// A second, brute-force implementation of the schedule that rt/README.md defines. It is written from that text and
// shares no code with rt/exec/schedule.cpp: time advances in steps of 1 us, and each step looks at everything again.
#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

namespace sinew::oracle {

struct Thread {
  int priority = 0;
  std::vector<int> cpus;  // empty: all
  enum { period, topics, device } trigger = period;
  int period_us = 0, phase_us = 0, timeout_us = 0;
  bool catch_up = false;
  unsigned catch_up_max = 1;
  unsigned modules = 1;
  std::vector<int> ready_us;                 // device: when it has something
  std::vector<std::vector<unsigned>> wakes;  // per module: threads that listen to what it publishes
  struct Post {
    int at_us, period_us;
  };
  std::vector<Post> new_periods;  // period: what is posted after everything of that instant, in order of time
};

struct Event {  // one step of one module
  unsigned thread, module;
  int release, start, end;  // end < 0: not completed within the horizon
  bool timed_out;
  bool operator==(const Event&) const = default;
};

struct Counters {
  std::uint64_t releases = 0, completions = 0, overruns = 0, skips = 0, coalesced = 0, timeouts = 0, preemptions = 0;
  bool operator==(const Counters&) const = default;
};

/// Execution time in us of the n-th step (from 0) of a module.
using Demand = std::function<int(unsigned thread, unsigned module, unsigned n)>;

struct Outcome {
  std::vector<Event> events;  // in the order in which the steps started
  std::vector<Counters> counters;
};

class Simulator {
 public:
  Simulator(std::vector<Thread> threads, int cores, Demand demand)
      : spec_(std::move(threads)), cores_(cores), demand_(std::move(demand)), state_(spec_.size()) {
    for (std::size_t i = 0; i < spec_.size(); ++i) {
      state_[i].steps.assign(spec_[i].modules, 0);
      state_[i].grid_us = spec_[i].phase_us;
      state_[i].period_us = spec_[i].period_us;
    }
    out_.counters.resize(spec_.size());
  }

  Outcome run(int horizon_us) {
    for (int t = 0; t <= horizon_us; ++t) {
      for (unsigned i = 0; i < spec_.size(); ++i) finish_step(i, t);
      for (unsigned i = 0; i < spec_.size(); ++i) release(i, t);
      decide();
      for (unsigned i : order()) begin_step(i, t);
      for (auto& s : state_)
        if (s.core && s.step) --s.left;
    }
    return out_;
  }

 private:
  struct Cycle {
    int release;
    bool timed_out;
  };
  struct State {
    std::optional<Cycle> cycle;
    std::deque<Cycle> waiting;
    bool begun = false;
    std::int64_t begun_rank = 0;   // when it began, among all
    std::optional<unsigned> step;  // module in execution
    unsigned next = 0;             // module to execute next
    int left = 0;
    std::size_t event = 0;
    std::optional<int> core;
    int last_trigger = 0;  // of any kind; the time-out counts from here
    std::size_t device_at = 0;
    bool device_pending = false;
    int grid_us = 0, period_us = 0;  // releases at grid + k * period
    std::size_t posts_taken = 0;
    std::vector<unsigned> steps;
  };

  void make_cycle(State& s, Cycle c) {
    s.cycle = c;
    s.begun = false;
    s.next = 0;
  }

  void finish_step(unsigned i, int t) {
    State& s = state_[i];
    if (!s.step || s.left > 0) return;
    const unsigned module = *s.step;
    s.step.reset();
    out_.events[s.event].end = t;
    if (!spec_[i].wakes.empty())
      for (unsigned listener : spec_[i].wakes[module]) trigger(listener, t, false);
    if (++s.next < spec_[i].modules) return;
    ++out_.counters[i].completions;
    s.cycle.reset();
    s.core.reset();
    if (s.waiting.empty()) return;
    make_cycle(s, s.waiting.front());
    s.waiting.pop_front();
  }

  void trigger(unsigned i, int t, bool by_timeout) {
    State& s = state_[i];
    Counters& c = out_.counters[i];
    s.last_trigger = t;
    if (!s.cycle) {
      make_cycle(s, {t, by_timeout});
    } else if (s.begun && s.waiting.empty()) {
      s.waiting.push_back({t, by_timeout});
    } else {
      ++c.coalesced;
      return;
    }
    ++c.releases;
    if (by_timeout) ++c.timeouts;
  }

  void release(unsigned i, int t) {
    const Thread& th = spec_[i];
    State& s = state_[i];
    Counters& c = out_.counters[i];
    if (th.trigger == Thread::period) {
      if (t < s.grid_us || (t - s.grid_us) % s.period_us != 0) return;
      if (!s.cycle) {
        make_cycle(s, {t, false});
        ++c.releases;
        return;
      }
      ++c.overruns;
      if (th.catch_up && s.waiting.size() < th.catch_up_max) {
        s.waiting.push_back({t, false});
        ++c.releases;
      } else {
        ++c.skips;
      }
      return;
    }
    if (th.trigger == Thread::device && !s.device_pending && s.device_at < th.ready_us.size() &&
        th.ready_us[s.device_at] <= t) {
      s.device_pending = true;  // until collect() has taken it
      trigger(i, t, false);
    }
    if (th.timeout_us > 0 && t - s.last_trigger >= th.timeout_us) trigger(i, t, true);
  }

  std::vector<unsigned> order() const {
    std::vector<unsigned> all;
    for (unsigned i = 0; i < state_.size(); ++i)
      if (state_[i].cycle) all.push_back(i);
    std::sort(all.begin(), all.end(), [&](unsigned a, unsigned b) {
      if (spec_[a].priority != spec_[b].priority) return spec_[a].priority > spec_[b].priority;
      if (state_[a].begun != state_[b].begun) return state_[a].begun;
      if (state_[a].begun && state_[a].begun_rank != state_[b].begun_rank)
        return state_[a].begun_rank < state_[b].begun_rank;
      return a < b;
    });
    return all;
  }

  bool allowed(unsigned i, int core) const {
    const auto& cpus = spec_[i].cpus;
    return cpus.empty() || std::find(cpus.begin(), cpus.end(), core) != cpus.end();
  }

  void decide() {
    const auto all = order();
    std::vector<int> runner(static_cast<std::size_t>(cores_), -1);  // the runner of each core until now
    std::vector<bool> taken(static_cast<std::size_t>(cores_), false);
    std::vector<std::optional<int>> now(state_.size());
    for (unsigned i : all)
      if (state_[i].core) runner[static_cast<std::size_t>(*state_[i].core)] = static_cast<int>(i);
    const auto place = [&](unsigned i) { return std::find(all.begin(), all.end(), i) - all.begin(); };
    for (unsigned i : all) {
      std::optional<int> pick;
      if (state_[i].core && !taken[static_cast<std::size_t>(*state_[i].core)]) pick = state_[i].core;
      for (int k = 0; !pick && k < cores_; ++k)
        if (allowed(i, k) && !taken[static_cast<std::size_t>(k)] && runner[static_cast<std::size_t>(k)] < 0) pick = k;
      if (!pick) {
        std::int64_t last = -1;
        for (int k = 0; k < cores_; ++k) {
          const auto at = static_cast<std::size_t>(k);
          if (!allowed(i, k) || taken[at] || runner[at] < 0) continue;
          const std::int64_t p = place(static_cast<unsigned>(runner[at]));
          if (p > last) last = p, pick = k;
        }
        if (pick && last < place(i)) pick.reset();  // only someone later in the order gives way
      }
      if (pick) taken[static_cast<std::size_t>(*pick)] = true;
      now[i] = pick;
    }
    for (unsigned i : all) {
      if (state_[i].core && !now[i]) ++out_.counters[i].preemptions;
      state_[i].core = now[i];
    }
  }

  void begin_step(unsigned i, int t) {
    State& s = state_[i];
    if (!s.core || s.step) return;
    if (!s.begun) {
      s.begun = true;
      s.begun_rank = ++begun_count_;
      if (s.device_pending || spec_[i].trigger == Thread::device) {
        while (s.device_at < spec_[i].ready_us.size() && spec_[i].ready_us[s.device_at] <= t) ++s.device_at;
        s.device_pending = false;
      }
      for (const auto& posts = spec_[i].new_periods; s.posts_taken < posts.size(); ++s.posts_taken) {
        if (posts[s.posts_taken].at_us >= t) break;
        s.period_us = posts[s.posts_taken].period_us;
        s.grid_us = t + s.period_us;
      }
    }
    s.step = s.next;
    s.left = demand_(i, s.next, s.steps[s.next]++);
    s.event = out_.events.size();
    out_.events.push_back({i, s.next, s.cycle->release, t, -1, s.cycle->timed_out});
  }

  std::vector<Thread> spec_;
  int cores_;
  Demand demand_;
  std::vector<State> state_;
  std::int64_t begun_count_ = 0;
  Outcome out_;
};

}  // namespace sinew::oracle
