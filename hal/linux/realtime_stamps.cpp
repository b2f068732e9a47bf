#include "hal/linux/realtime_stamps.hpp"

#include <algorithm>

namespace sinew::hal {

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

}  // namespace sinew::hal
