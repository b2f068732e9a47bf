#include "hal/linux/can/can_stamp.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t kJump = 1'000'000'000;

}  // namespace

ClockReading read_clocks(Os& os) noexcept {
  ClockReading out;
  timespec wall{};
  out.before = os.now();
  clock_gettime(CLOCK_REALTIME, &wall);
  out.after = os.now();
  out.realtime_ns = ns_of(wall);
  return out;
}

void RealtimeStamps::begin(const ClockReading& clocks) noexcept {
  now_ = clocks.before;
  const Offset read{clocks.realtime_ns - clocks.after.ns, clocks.realtime_ns - clocks.before.ns};
  const Offset both{std::max(read.least, offset_.least), std::min(read.most, offset_.most)};
  if (begun_ && both.least <= both.most) {
    offset_ = both;
    return;
  }
  offset_before_ = begun_ ? offset_ : read;
  offset_ = read;
  begun_ = true;
}

bool RealtimeStamps::fits(std::int64_t realtime_ns, const Offset& offset, Time& out) const noexcept {
  const Time earliest{realtime_ns - offset.most}, latest{realtime_ns - offset.least};
  if (latest < floor_ || earliest > now_) return false;
  out = std::clamp(Time{earliest.ns + (latest - earliest).count() / 2}, floor_, now_);
  return true;
}

Time RealtimeStamps::convert(std::int64_t realtime_ns) const noexcept {
  Time out;
  return fits(realtime_ns, offset_, out) || fits(realtime_ns, offset_before_, out) ? out : now_;
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
