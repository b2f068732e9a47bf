#include "wire/rc_channels.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::wire {

RcCounts unpack_rc(std::span<const std::uint8_t, kRcBytes> bytes) noexcept {
  RcCounts out{};
  for (std::size_t bit = 0; bit < kRcBytes * 8; ++bit)
    if (bytes[bit / 8] >> (bit % 8) & 1) out[bit / 11] = static_cast<std::uint16_t>(out[bit / 11] | 1u << (bit % 11));
  return out;
}

void pack_rc(const RcCounts& counts, std::span<std::uint8_t, kRcBytes> out) noexcept {
  std::fill(out.begin(), out.end(), std::uint8_t{0});
  for (std::size_t bit = 0; bit < kRcBytes * 8; ++bit)
    if (counts[bit / 11] >> (bit % 11) & 1) out[bit / 8] = static_cast<std::uint8_t>(out[bit / 8] | 1u << (bit % 8));
}

double rc_stick(std::uint16_t count) noexcept {
  const double off = static_cast<double>(count) - kRcMiddle;
  return std::clamp(off / (off < 0 ? kRcMiddle - kRcLow : kRcHigh - kRcMiddle), -1.25, 1.25);
}

std::uint16_t rc_count(double stick) noexcept {
  const double way = stick < 0 ? kRcMiddle - kRcLow : kRcHigh - kRcMiddle;
  return static_cast<std::uint16_t>(std::clamp(std::lround(kRcMiddle + stick * way), 0L, 2047L));
}

}  // namespace sinew::wire
