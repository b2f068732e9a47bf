#include "hal/can_bus.hpp"

namespace sinew::hal {

const char* to_string(CanState state) {
  switch (state) {
    case CanState::active:
      return "active";
    case CanState::warning:
      return "warning";
    case CanState::passive:
      return "passive";
    case CanState::bus_off:
      return "bus off";
    case CanState::stopped:
      return "stopped";
  }
  return "?";
}

std::uint32_t can_frame_bits(const msg::CanFrame& frame, double data_rate_ratio) noexcept {
  const std::uint32_t size = frame.remote() || frame.size > msg::kMaxCanBytes ? 0 : frame.size;
  constexpr std::uint32_t kTail = 13;  // CRC delimiter, acknowledge, end of frame, interframe space; not stuffed
  if (!frame.fd()) {
    // From start of frame to the end of the CRC, where five equal bits are followed by another: at most one in four.
    const std::uint32_t stuffed = (frame.extended() ? 54u : 34u) + 8 * size;
    return stuffed + (stuffed - 1) / 4 + kTail;
  }
  const std::uint32_t arbitration = frame.extended() ? 36 : 17;  // to BRS
  const std::uint32_t crc = size > 16 ? 21 : 17;
  const std::uint32_t data = 5 + 8 * size;                  // ESI, DLC, data: stuffed as before
  const std::uint32_t fixed = 4 + crc + (4 + crc) / 4 + 1;  // stuff count, CRC, with fixed stuff bits
  const std::uint32_t slow = arbitration + (arbitration - 1) / 4 + kTail, fast = data + data / 4 + fixed;
  const double ratio = (frame.flags & msg::kCanBitRateSwitch) != 0 && data_rate_ratio > 1 ? data_rate_ratio : 1.0;
  return slow + static_cast<std::uint32_t>(static_cast<double>(fast) / ratio + 0.5);
}

}  // namespace sinew::hal
