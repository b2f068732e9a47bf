#include "rt/exec/real_time_executor.hpp"

#include <algorithm>
#include <utility>

#include "rt/exec/fp_mode.hpp"
#include "rt/exec/gap_watch.hpp"
#include "rt/exec/trigger.hpp"
#include "rt/guardian.hpp"

namespace sinew::rt {
namespace {

constexpr Duration kLongSleep = std::chrono::milliseconds(50);

// Releases of a periodic thread that met an unfinished cycle and may still run, oldest first.
class Backlog {
 public:
  explicit Backlog(std::uint32_t capacity) : releases_(capacity) {}
  bool push(Time t) noexcept {
    if (count_ == releases_.size()) return false;
    releases_[(first_ + count_++) % releases_.size()] = t;
    return true;
  }
  bool empty() const noexcept { return count_ == 0; }
  Time pop() noexcept {
    const Time t = releases_[first_];
    first_ = (first_ + 1) % releases_.size();
    --count_;
    return t;
  }

 private:
  std::vector<Time> releases_;
  std::size_t first_ = 0, count_ = 0;
};

// How long before a release the precise wake-up begins to look at the clock: follows the kernel's own lateness, so that
// nearly every sleep ends in time and little is spent looking.
class Tail {
 public:
  explicit Tail(Duration max) : max_ns_(static_cast<double>(max.count())), tail_ns_(max_ns_ / 2) {}
  Duration value() const noexcept { return Duration{static_cast<std::int64_t>(tail_ns_)}; }
  void observe(Duration oversleep) noexcept {
    const double late = static_cast<double>(oversleep.count());
    // Rises fast towards the lateness seen, falls slowly: about the 98th percentile.
    tail_ns_ += late * 1.2 > tail_ns_ ? (late * 1.2 - tail_ns_) * 0.25 : -tail_ns_ * 0.005;
    tail_ns_ = std::clamp(tail_ns_, 5e3, max_ns_);
  }

 private:
  double max_ns_, tail_ns_;
};

}  // namespace

class RealTimeExecutor::Worker {
 public:
  Worker(RealTimeExecutor& executor, std::uint32_t index)
      : executor_(executor),
        index_(index),
        spec_(executor.graph_.threads()[index].spec),
        trigger_(executor.os_),
        backlog_(spec_.catch_up_max),
        tail_(executor.options_.precise_tail_max),
        gaps_(executor.os_, executor.options_.throttle) {
    const std::uint32_t device = executor.graph_.threads()[index].device_module;
    if (spec_.trigger != ThreadSpec::Trigger::device || device == kNone) return;
    device_ = executor.graph_.modules()[device].driver->device();
    if (!device_) return;
    device_position_ = executor.graph_.modules()[device].position;
    device_->set_wake(&trigger_);
  }
  ~Worker() {
    if (device_) device_->set_wake(nullptr);
  }

  hal::Status start(std::vector<std::string>& shortfalls) {
    runner_ = &executor_.runner_->thread(index_);
    hal::ThreadOptions options;
    options.name = spec_.name;
    options.fifo_priority = executor_.options_.fixed_priority ? spec_.priority : 0;
    options.cpus = spec_.cpus;
    options.stack_bytes = std::size_t{spec_.stack_kib} * 1024;
    has_fifo_ = options.fifo_priority > 0;
    auto thread = executor_.os_.start_thread(options, [this] { run(); });
    if (!thread) return thread.error();
    thread_ = std::move(*thread);
    if (thread_->shortfall().find("SCHED_FIFO") != std::string::npos) has_fifo_ = false;
    if (!thread_->shortfall().empty()) shortfalls.push_back("thread " + spec_.name + ": " + thread_->shortfall());
    return {};
  }
  void ask_to_stop() {
    stop_.store(true, std::memory_order_relaxed);
    trigger_.wake();
  }
  void join() { thread_.reset(); }
  void fire(Time now) noexcept { trigger_.fire(now); }
  /// True if the thread uses up what the kernel gives to fixed priorities.
  bool busy(Time now) const noexcept { return has_fifo_ && gaps_.busy(now); }

 private:
  bool stopping() const noexcept { return stop_.load(std::memory_order_relaxed); }

  void run() noexcept {
    const FpModeScope fp_mode;
    executor_.await_release();
    if (stopping()) return;
    now_ = executor_.os_.now();
    gaps_.begin(now_);
    if (spec_.trigger == ThreadSpec::Trigger::period)
      run_periodic();
    else
      run_triggered();
  }

  void run_periodic() noexcept {
    period_ = spec_.period;
    next_ = executor_.start_ + spec_.phase;
    while (!stopping()) {
      const Time now = wait_until(next_);
      if (stopping()) return;
      const Time release = next_;
      next_ = next_ + period_;  // unless the cycle restarts it
      cycle(release, false, now);
      meet_releases();
      while (!backlog_.empty() && !stopping()) {
        cycle(backlog_.pop(), false, now_);
        meet_releases();
      }
    }
  }

  // Releases that came while a cycle ran. A release at the instant of the cycle's end does not meet it.
  void meet_releases() noexcept {
    ThreadStats& stats = runner_->stats();
    for (; next_ < now_; next_ = next_ + period_) {
      stats.overruns.add();
      const bool waits = spec_.overrun == ThreadSpec::Overrun::catch_up && backlog_.push(next_);
      if (!waits) stats.skips.add();
      runner_->timeline().add(waits ? TimelineEvent::Kind::overrun : TimelineEvent::Kind::skip, next_);
    }
  }

  // Answers the time. The precise wake-up does not read the clock again after its last look: what the loads of other
  // programs have pushed out of the caches would come first.
  Time wait_until(Time t) noexcept {
    hal::Os& os = executor_.os_;
    if (t - now_ > kLongSleep) trigger_.wait(t - kLongSleep / 2);  // so that stop() can end a long sleep
    if (stopping()) return now_;
    if (!spec_.precise) {
      os.sleep_until(t);
      return os.now();
    }
    const Time early = t - tail_.value();
    Time now = os.now();
    if (now < early) {
      os.sleep_until(early);
      now = os.now();
      tail_.observe(now - early);
    }
    while (now < t && !stopping()) now = os.now();
    return now;
  }

  void run_triggered() noexcept {
    const bool has_timeout = spec_.timeout.count() > 0;
    Time last = executor_.start_;  // trigger or time-out
    executor_.os_.sleep_until(executor_.start_);
    ThreadStats& stats = runner_->stats();
    while (!stopping()) {
      const Time deadline = has_timeout ? last + spec_.timeout : hal::kNever;
      trigger_.wait(deadline);
      if (stopping()) return;
      const Trigger::Taken taken = trigger_.take();
      const Time now = executor_.os_.now();
      const bool timed_out = taken.count == 0 || taken.first > deadline;  // the time-out came first
      const Time release = timed_out ? deadline : std::max(taken.first, last);
      stats.coalesced.add(timed_out ? taken.count : taken.count - 1);
      if (timed_out) stats.timeouts.add();
      last = taken.count == 0 ? release : std::max(release, taken.latest);
      if (has_timeout && now - last >= spec_.timeout) {  // further time-outs came meanwhile: this cycle absorbs them
        const std::int64_t absorbed = (now - last) / spec_.timeout;
        stats.coalesced.add(static_cast<std::uint64_t>(absorbed));
        last = last + spec_.timeout * absorbed;
      }
      cycle(release, timed_out, now);
    }
  }

  void cycle(Time release, bool timed_out, Time now) noexcept {
    hal::Os& os = executor_.os_;
    note(gaps_.woke(release, now), now);
    ThreadStats& stats = runner_->stats();
    stats.releases.add();
    if (const auto period = runner_->begin(release, timed_out, now)) {
      period_ = *period;
      next_ = now + period_;
    }
    for (std::uint32_t i = 0; i < runner_->size(); ++i) {
      const auto filled = runner_->start(i, now);
      executor_.fire(filled, now);
      // What a bounded collect() left behind causes no new wake-up.
      if (i == device_position_ && !filled.empty() && device_->ready_at() <= now) trigger_.fire(now);
      const Time done = os.now();  // the one clock read of a step
      executor_.fire(runner_->complete(i, done, done - now), done);
      now = done;
    }
    runner_->end(now);
    stats.completions.add();
    note(gaps_.ran(now), now);
    now_ = now;
  }

  void note(const std::optional<GapWatch::Gap>& gap, Time now) noexcept {
    if (!gap) [[likely]]
      return;
    ThreadStats& stats = runner_->stats();
    (gap->throttle_like && executor_.any_busy(executor_.os_.now()) ? stats.throttled : stats.taken)
        .add(gap->length, gap->count);
    runner_->timeline().add(TimelineEvent::Kind::off_processor, now - gap->length, gap->length);
  }

  RealTimeExecutor& executor_;
  const std::uint32_t index_;
  const ThreadSpec& spec_;
  ThreadRunner* runner_ = nullptr;
  hal::Device* device_ = nullptr;          // of a device trigger
  std::uint32_t device_position_ = kNone;  // of its module in the cycle
  Trigger trigger_;
  Time now_{};         // end of the last cycle
  Time next_{};        // release of a periodic thread
  Duration period_{};  // now in force
  Backlog backlog_;
  Tail tail_;
  GapWatch gaps_;
  std::atomic<bool> has_fifo_{false};
  std::atomic<bool> stop_{false};
  std::unique_ptr<hal::Thread> thread_;
};

RealTimeExecutor::RealTimeExecutor(Graph& graph, hal::Os& os, const RealTimeOptions& options)
    : graph_(graph), os_(os), options_(options) {
  for (std::uint32_t t = 0; t < graph.threads().size(); ++t) workers_.push_back(std::make_unique<Worker>(*this, t));
}

RealTimeExecutor::~RealTimeExecutor() { stop(); }

hal::Status RealTimeExecutor::start() {
  if (const FpModeScope fp_mode; !FpMode::computes_right())
    return hal::Error{hal::Errc::not_supported, "rounding to nearest with subnormals"};
  RunnerOptions runner = options_.runner;
  runner.start = os_.now();  // for the time line; the cycles' start is set later
  runner.clock = &os_;
  runner_ = std::make_unique<Runner>(graph_, runner);
  if (options_.lock_memory)
    if (const auto locked = os_.lock_memory(); !locked)
      shortfalls_.push_back(std::string("memory is not locked: ") + hal::to_string(locked.error().code));
  if (options_.keep_awake) {
    auto awake = os_.keep_awake();
    if (awake)
      awake_ = std::move(*awake);
    else if (awake.error().code != hal::Errc::not_found)
      shortfalls_.push_back(std::string("processors may sleep deeply and wake late: ") + awake.error().where + ": " +
                            hal::to_string(awake.error().code));
  }
  started_ = true;
  for (auto& worker : workers_) {
    if (auto started = worker->start(shortfalls_); !started) {
      stop();
      return started;
    }
  }
  if (options_.strict && !shortfalls_.empty()) {
    stop();
    return hal::Error{hal::Errc::denied, "strict: something is missing", static_cast<std::int64_t>(shortfalls_.size())};
  }
  start_ = os_.now() + options_.start_delay;
  runner_->set_start(start_);
  release();
  return {};
}

void RealTimeExecutor::stop() {
  for (auto& worker : workers_) worker->ask_to_stop();
  release();
  for (auto& worker : workers_) worker->join();
  awake_.reset();
  if (std::exchange(started_, false))
    for (const GraphModule& m : graph_.modules())
      if (m.guardian) m.guardian->shut_down();
}

// release and acquire: a released thread sees start_, or that it is to stop.
void RealTimeExecutor::release() noexcept {
  released_.store(1, std::memory_order_release);
  for (std::size_t i = 0; i < workers_.size(); ++i) os_.wake(released_);  // one sleeper each
}

void RealTimeExecutor::await_release() noexcept {
  while (released_.load(std::memory_order_acquire) == 0) os_.wait(released_, 0, hal::kNever);
}

bool RealTimeExecutor::any_busy(Time now) const noexcept {
  return std::any_of(workers_.begin(), workers_.end(), [now](const auto& w) { return w->busy(now); });
}

void RealTimeExecutor::fire(std::span<const std::uint32_t> topics, Time now) noexcept {
  for (const std::uint32_t topic : topics)
    for (const std::uint32_t thread : graph_.topics()[topic].triggers) workers_[thread]->fire(now);
}

}  // namespace sinew::rt
