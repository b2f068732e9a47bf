#pragma once
#include <algorithm>
#include <cstdlib>

#include "hal/clock.hpp"

namespace sinew::drivers {

/// Stamps samples that a chip takes evenly by its own clock and that we find some time later. A loop follows the chip's
/// rate (it may be off by some percent) and smooths the times at which we looked.
/// Thread:  owner.   RT: yes.
class SampleClock {
 public:
  explicit SampleClock(hal::Duration nominal) : nominal_(nominal), period_ns_(static_cast<double>(nominal.count())) {}
  struct Stamps {
    hal::Time first;
    hal::Duration step;
    hal::Time at(std::size_t i) const { return first + step * static_cast<std::int64_t>(i); }
  };
  /// `count` (> 0) samples were found at `now`; the newest was taken within the last period. Stamps rise, and none lies
  /// after `now`.
  Stamps found(std::size_t count, hal::Time now) noexcept {
    const double n = static_cast<double>(count), half = 0.5 * period_ns_;
    const double free_run = n * period_ns_;
    const double error = static_cast<double>((now - last_).count()) - half - free_run;
    if (!started_ || error > 8 * period_ns_ + free_run || error < -8 * period_ns_ - free_run) {
      // Just begun, or samples were lost: from here on anew, but never back.
      const hal::Time newest = now - hal::Duration{static_cast<std::int64_t>(half)};
      const auto room = started_ ? (newest - last_).count() / static_cast<std::int64_t>(count) : INT64_MAX;
      const auto step = std::max<std::int64_t>(1, std::min(static_cast<std::int64_t>(period_ns_), room));
      const hal::Duration before{step * static_cast<std::int64_t>(count - 1)};
      last_ = started_ ? std::max(newest, last_ + hal::Duration{step * static_cast<std::int64_t>(count)}) : newest;
      started_ = true;
      return {last_ - before, hal::Duration{step}};
    }
    const double nominal = static_cast<double>(nominal_.count());
    period_ns_ = std::clamp(period_ns_ + error / (128 * n), 0.95 * nominal, 1.05 * nominal);
    double ahead = free_run + std::max(error / 16, -0.5 * free_run);
    ahead = std::min(ahead, static_cast<double>((now - last_).count()));
    const auto step = std::max<std::int64_t>(1, static_cast<std::int64_t>(ahead / n));
    const Stamps out{last_ + hal::Duration{step}, hal::Duration{step}};
    last_ = out.at(count - 1);
    return out;
  }
  /// Samples are missing: the next ones are stamped anew.
  void restart() noexcept { started_ = false; }
  double period_s() const noexcept { return period_ns_ * 1e-9; }

 private:
  hal::Duration nominal_;
  double period_ns_;
  hal::Time last_;
  bool started_ = false;
};

}  // namespace sinew::drivers
