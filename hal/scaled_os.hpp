#pragma once
#include <cmath>

#include "hal/os.hpp"

namespace sinew::hal {

/// An Os whose clock runs at `rate` times another's: all waits and measurements on it follow. For a simulator that is
/// slower (or faster) than real time. Threads and memory are those of the other Os.
/// Thread:  any.   RT: as the other.
class ScaledOs final : public Os {
 public:
  /// At `start` of the other clock this clock shows `shows`; from then on it advances at `rate`, > 0.
  ScaledOs(Os& other, double rate, Time start, Time shows) : other_(other), rate_(rate), start_(start), shows_(shows) {}
  ScaledOs(Os& other, double rate, Time start) : ScaledOs(other, rate, start, start) {}
  ScaledOs(Os& other, double rate) : ScaledOs(other, rate, other.now()) {}

  double rate() const noexcept override { return rate_ * other_.rate(); }
  Time now() const noexcept override { return scaled(other_.now()); }
  void sleep_until(Time t) noexcept override { other_.sleep_until(unscaled(t)); }
  void wait(WakeWord& word, std::uint32_t expected, Time deadline) noexcept override {
    other_.wait(word, expected, deadline == kNever ? kNever : unscaled(deadline));
  }
  void wake(WakeWord& word) noexcept override { other_.wake(word); }
  Duration thread_cpu_time() noexcept override {  // scaled, too: used plus waited time is the advance of now()
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
  /// The first instant of the other clock at which this clock shows `t`, so that no sleeper wakes too early.
  Time unscaled(Time t) const noexcept {
    const double ns = std::ceil(static_cast<double>((t - shows_).count()) / rate_);
    if (ns >= 9e18 - static_cast<double>(start_.ns)) return kNever;  // on slow clocks the result may exceed the range
    Time other = start_ + Duration{static_cast<std::int64_t>(ns)};
    while (scaled(other) < t) other = other + Duration{1};  // corrects rounding
    return other;
  }

 private:
  Os& other_;
  double rate_;
  Time start_, shows_;
};

}  // namespace sinew::hal
