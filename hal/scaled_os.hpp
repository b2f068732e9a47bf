#pragma once
#include <cmath>

#include "hal/os.hpp"

namespace sinew::hal {

/// Another Os whose clock runs at `rate`: everything that waits and measures on it lives at that pace. For a simulator
/// that is slower (or faster) than life. Threads and memory are the other's own.
/// Thread:  any.   RT: as the other.
class ScaledOs final : public Os {
 public:
  /// At `start` of the other's clock this one shows `shows`; from then on it advances at `rate`, > 0.
  ScaledOs(Os& other, double rate, Time start, Time shows) : other_(other), rate_(rate), start_(start), shows_(shows) {}
  ScaledOs(Os& other, double rate, Time start) : ScaledOs(other, rate, start, start) {}
  ScaledOs(Os& other, double rate) : ScaledOs(other, rate, other.now()) {}

  double rate() const { return rate_; }
  Time now() const noexcept override { return scaled(other_.now()); }
  void sleep_until(Time t) noexcept override { other_.sleep_until(unscaled(t)); }
  void wait(WakeWord& word, std::uint32_t expected, Time deadline) noexcept override {
    other_.wait(word, expected, deadline == kNever ? kNever : unscaled(deadline));
  }
  void wake(WakeWord& word) noexcept override { other_.wake(word); }
  Duration thread_cpu_time() noexcept override {  // at this pace, too: used up plus waited is what now() has gone on
    return Duration{static_cast<std::int64_t>(static_cast<double>(other_.thread_cpu_time().count()) * rate_)};
  }
  Result<std::unique_ptr<Thread>> start_thread(const ThreadOptions& options, std::function<void()> body) override {
    return other_.start_thread(options, std::move(body));
  }
  Result<std::unique_ptr<SharedMemory>> shared_memory(std::string_view name, std::size_t bytes) override {
    return other_.shared_memory(name, bytes);
  }
  Status lock_memory() override { return other_.lock_memory(); }
  Result<std::shared_ptr<void>> keep_awake() override { return other_.keep_awake(); }

  Time scaled(Time t) const noexcept {
    return shows_ + Duration{static_cast<std::int64_t>(std::floor(static_cast<double>((t - start_).count()) * rate_))};
  }
  /// The first instant of the other clock at which this one shows `t`: nobody wakes too early.
  Time unscaled(Time t) const noexcept {
    const double ns = std::ceil(static_cast<double>((t - shows_).count()) / rate_);
    if (ns >= 9e18 - static_cast<double>(start_.ns)) return kNever;  // slower clocks reach far: further than we count
    Time other = start_ + Duration{static_cast<std::int64_t>(ns)};
    while (scaled(other) < t) other = other + Duration{1};  // what rounding has taken
    return other;
  }

 private:
  Os& other_;
  double rate_;
  Time start_, shows_;
};

}  // namespace sinew::hal
