// A stream of frames, any bytes: results are within their bounds, and decoded values are encoded again without loss.
#include "wire/dronecan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "wire/dronecan_types.hpp"

using namespace sinew;

namespace {

/// Decoded values encode to bytes that decode to the same bytes.
template <class T>
void again(std::span<const std::uint8_t> payload) {
  T first, second;
  if (!decode(payload, first)) return;
  std::array<std::uint8_t, wire::kDronecanMaxPayload> a{}, b{};
  const std::size_t size = encode(first, a);
  if (!decode(wire::Payload(a).first(size), second)) std::abort();
  if (encode(second, b) != size || a != b) std::abort();
}

}  // namespace

/// 14 bytes a frame: size and time step, four of identifier, eight of data.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static constexpr wire::DronecanWanted kAll[] = {wire::kDronecanNodeStatus,      wire::kDronecanGetNodeInfo,
                                                  wire::kDronecanAllocation,      wire::kDronecanEscRawCommand,
                                                  wire::kDronecanActuatorCommand, wire::kDronecanActuatorStatus,
                                                  wire::kDronecanEscStatus,       wire::kDronecanArmingStatus};
  wire::DronecanAssembler assembler(kAll, 3);
  msg::Time now;
  for (; size >= 14; data += 14, size -= 14) {
    msg::CanFrame frame;
    frame.size = data[0] % 10;
    now.ns += std::int64_t{data[1]} * 10'000'000;
    frame.id = data[2] | data[3] << 8 | data[4] << 16 | static_cast<std::uint32_t>(data[5]) << 24;
    frame.flags = (frame.id >> 31) != 0 ? 0u : msg::kCanExtended;
    frame.id &= 0x3FFFFFFF;
    std::copy_n(data + 6, 8, frame.data.begin());
    wire::DronecanTransfer transfer;
    if (assembler.push(frame, now, 42, transfer) != wire::DronecanAssembler::Heard::complete) continue;
    if (transfer.payload.size() > wire::kDronecanMaxPayload) std::abort();
    again<wire::DronecanNodeStatus>(transfer.payload);
    again<wire::DronecanNodeInfo>(transfer.payload);
    again<wire::DronecanAllocation>(transfer.payload);
    again<wire::DronecanEscRawCommand>(transfer.payload);
    again<wire::DronecanActuatorCommand>(transfer.payload);
    again<wire::DronecanEscStatus>(transfer.payload);
    again<wire::DronecanActuatorStatus>(transfer.payload);
    again<wire::DronecanArmingStatus>(transfer.payload);
  }
  return 0;
}
