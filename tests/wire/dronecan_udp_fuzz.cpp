// For any bytes: no frame, or a frame that is encoded to the same bytes again, except flags without a meaning.
#include "wire/dronecan_udp.hpp"

#include <array>
#include <cstdlib>
#include <cstring>

#include "wire/can_check.hpp"

using namespace sinew;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  msg::CanFrame frame;
  if (!wire::dronecan_udp_decode({data, size}, frame)) return 0;
  if (!wire::is_can_frame(frame)) std::abort();
  std::array<std::uint8_t, wire::kDronecanUdpMax> out{};
  if (wire::dronecan_udp_encode(frame, out) != size) std::abort();
  if (std::memcmp(out.data() + 6, data + 6, size - 6) != 0) std::abort();
  return 0;
}
