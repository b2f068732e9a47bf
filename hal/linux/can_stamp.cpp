#include "hal/linux/can_stamp.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr Duration kClockReading = 1ms;  // between reading two clocks, on a machine that is busy
constexpr std::int64_t kJump = 1'000'000'000;

}  // namespace

bool RealtimeStamps::possible(Time t) const noexcept { return t.ns >= (floor_ - kClockReading).ns && t <= now_; }

void RealtimeStamps::begin(Time now, std::int64_t realtime_ns) noexcept {
  const std::int64_t offset = realtime_ns - now.ns;
  offset_before_ns_ = begun_ ? offset_ns_ : offset;
  offset_ns_ = offset;
  now_ = now;
  begun_ = true;
}

Time RealtimeStamps::convert(std::int64_t realtime_ns) const noexcept {
  const Time t{realtime_ns - offset_ns_};
  if (possible(t)) return t;
  if (t > now_ && t.ns - now_.ns < Duration(kClockReading).count()) return now_;
  const Time before{realtime_ns - offset_before_ns_};
  return possible(before) ? before : now_;
}

Time HardwareStamps::convert(std::int64_t hardware_ns, Time kernel) noexcept {
  const std::int64_t difference = kernel.ns - hardware_ns;
  if (!begun_ || std::abs(difference - now_min_) > kJump) {  // the first one, or a clock that was set
    begun_ = true;
    now_min_ = last_min_ = difference;
    window_ = kernel;
  } else if (kernel - window_ > 1s) {
    last_min_ = now_min_;
    now_min_ = difference;
    window_ = kernel;
  }
  now_min_ = std::min(now_min_, difference);
  return {hardware_ns + std::min(now_min_, last_min_)};
}

}  // namespace sinew::hal
