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
  out.rate = os.rate();
  return out;
}

void RealtimeStamps::begin(const ClockReading& clocks) noexcept {
  if (!begun_) first_ns_ = clocks.realtime_ns, rate_ = clocks.rate;
  now_ = clocks.before;
  const std::int64_t wall_ns = paced(clocks.realtime_ns), rounding_ns = rate_ == 1 ? 0 : 2;
  const Offset read{wall_ns - clocks.after.ns - rounding_ns, wall_ns - clocks.before.ns + rounding_ns};
  const Offset both{std::max(read.least, offset_.least), std::min(read.most, offset_.most)};
  if (begun_ && both.least <= both.most) {
    offset_ = both;
    return;
  }
  offset_before_ = begun_ ? offset_ : read;
  offset_ = read;
  begun_ = true;
}

std::int64_t RealtimeStamps::paced(std::int64_t realtime_ns) const noexcept {
  const std::int64_t since_ns = realtime_ns - first_ns_;
  return rate_ == 1 ? since_ns : static_cast<std::int64_t>(static_cast<double>(since_ns) * rate_);
}

bool RealtimeStamps::fits(std::int64_t paced_ns, const Offset& offset, Time& out) const noexcept {
  const Time earliest{paced_ns - offset.most}, latest{paced_ns - offset.least};
  if (latest < floor_ || earliest > now_) return false;
  out = std::clamp(Time{earliest.ns + (latest - earliest).count() / 2}, floor_, now_);
  return true;
}

Time RealtimeStamps::convert(std::int64_t realtime_ns) const noexcept {
  Time out;
  const std::int64_t paced_ns = paced(realtime_ns);
  return fits(paced_ns, offset_, out) || fits(paced_ns, offset_before_, out) ? out : now_;
}

}  // namespace sinew::hal
