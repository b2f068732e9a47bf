#include "sim_hil/board/clock_keeper.hpp"

#include <algorithm>

namespace sinew::sim_hil {
namespace {

using namespace std::chrono_literals;

constexpr int kBurst = 16;
constexpr Duration kBurstTime = 1s;    // a plant far away gets fewer
constexpr Duration kPeriod = 200ms;    // of the exchanges afterwards
constexpr Duration kPatience = 500ms;  // for one answer
constexpr Duration kReopenAfter = 1s;  // when the side line broke

Duration scaled_by(Duration d, double rate) {
  return Duration(static_cast<std::int64_t>(static_cast<double>(d.count()) * rate));
}

}  // namespace

void ClockKeeper::begin() {
  stop();
  {
    const std::lock_guard lock(mutex_);
    filter_ = hal::ClockFilter();
    line_.reset();
    refused_ = false;
  }
  const Time give_up = os_.now() + kBurstTime;
  if (!open_line()) return;
  for (int i = 0; i < kBurst && os_.now() < give_up && exchange(); ++i) {
  }
}

bool ClockKeeper::open_line() {
  if (!connect_ || refused_) return false;
  auto stream = connect_();
  if (!stream) return false;
  std::string why;
  auto line = SideLine::open(std::move(*stream), "clock", kPatience, why);
  const std::lock_guard lock(mutex_);
  if (!line) refused_ = why.starts_with("plant refused");
  if (line) line_ = std::move(*line);
  return line_ != nullptr;
}

bool ClockKeeper::exchange() {
  auto e = line_->compare_clocks(os_);  // only this thread replaces the line
  const std::lock_guard lock(mutex_);
  if (!e) {
    line_.reset();
    return false;
  }
  ++stats_.exchanges;
  filter_.add(e->asked, e->received, e->answered, e->arrived);
  return true;
}

void ClockKeeper::add(Time asked, Time received, Time answered, Time arrived) {
  const std::lock_guard lock(mutex_);
  filter_.add(asked, received, answered, arrived);
}

Duration ClockKeeper::host_offset() const {
  const std::lock_guard lock(mutex_);
  return filter_.any() ? filter_.at(os_.now()).offset : Duration{0};
}

void ClockKeeper::follow(Duration offset, Duration host_offset, double rate) {
  base_offset_ = offset, base_host_offset_ = host_offset, rate_ = rate;
  stop_.store(0, std::memory_order_relaxed);
  steer();
  auto thread = os_.start_thread(thread_options_, [this] { run(); });
  if (thread) thread_ = std::move(*thread);  // without it the bound grows, and the statistics show it
}

void ClockKeeper::stop() {
  stop_.store(1, std::memory_order_release);
  os_.wake(stop_);
  {
    const std::lock_guard lock(mutex_);
    if (line_) line_->hang_up();
  }
  thread_.reset();
}

void ClockKeeper::run() {
  Time next = os_.now(), reopen{};
  for (;;) {
    next = std::max(next + kPeriod, os_.now());
    while (stop_.load(std::memory_order_acquire) == 0 && os_.now() < next) os_.wait(stop_, 0, next);
    if (stop_.load(std::memory_order_acquire) != 0) return;
    steer();  // first with the old exchanges: the bound is worst just before a new one
    if (!line_ && os_.now() >= reopen) {
      reopen = os_.now() + kReopenAfter;
      open_line();
    }
    if (line_ && exchange()) steer();
  }
}

void ClockKeeper::steer() {
  const std::lock_guard lock(mutex_);
  if (!filter_.any()) return;
  const hal::ClockFilter::Estimate e = filter_.at(os_.now());
  plant_clock_.steer(base_offset_ + scaled_by(e.offset - base_host_offset_, rate_));
  stats_.offset = e.offset, stats_.drift = e.drift;
  stats_.bound = scaled_by(e.bound, rate_) + plant_clock_.lag();
  stats_.worst_bound = std::max(stats_.worst_bound, stats_.bound);
  stats_.followed = line_ != nullptr || stats_.followed;
  stats_.rejected = filter_.rejected(), stats_.restarts = filter_.restarts();
}

ClockStats ClockKeeper::stats() const {
  const std::lock_guard lock(mutex_);
  return stats_;
}

}  // namespace sinew::sim_hil
