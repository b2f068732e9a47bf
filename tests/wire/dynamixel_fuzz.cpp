// For any bytes, in both protocols: what is found is inside of the bytes, and a packet that is built again is the same.
// The first byte chooses the protocol, and when the line is silent.
#include <cstdlib>
#include <vector>

#include "wire/servos/servo_models.hpp"

using namespace sinew::wire;

namespace {

void check(DxlVersion version, const DxlPacket& p) {
  if (version == DxlVersion::two && p.is(DxlInstruction::status) && p.id == kDxlBroadcast) {
    DxlFastParts parts(p);
    DxlFastPart part;
    std::size_t bytes = 0;
    while (parts.next(4, part)) bytes += part.data.size() + 1;
    if (bytes > p.parameters.size()) std::abort();
    return;
  }
  DxlBuilder again = version == DxlVersion::two && p.is(DxlInstruction::status)
                         ? DxlBuilder::status(version, p.id, p.error)
                         : DxlBuilder(version, p.id, p.code);
  again.bytes(p.parameters);
  const std::vector<std::uint8_t> parameters(p.parameters.begin(), p.parameters.end());
  const auto bytes = again.finish();
  if (bytes.empty()) return;  // needless stuffing was left out or put in: no longer fits
  DxlReader reader(version);
  int found = 0;
  for (const std::uint8_t b : bytes)
    reader.push(b, [&](const DxlPacket& q) {
      ++found;
      const bool short_status = version == DxlVersion::two && p.is(DxlInstruction::status) && p.parameters.empty();
      if (q.id != p.id || q.code != p.code || (!short_status && q.error != p.error)) std::abort();
      if (std::vector<std::uint8_t>(q.parameters.begin(), q.parameters.end()) != parameters) std::abort();
    });
  if (found != 1) std::abort();
  for (const ServoModel& m : servo_models())
    for (const ServoRegister& r : {m.present_position, m.present_effort, m.present_velocity})
      static_cast<void>(servo_number(m, r, m.cycle().address, p.parameters));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const DxlVersion version = (data[0] & 1) != 0 ? DxlVersion::two : DxlVersion::one;
  const std::size_t silence = data[0] >> 1;
  DxlReader reader(version);
  const auto on_packet = [&](const DxlPacket& p) { check(version, p); };
  for (std::size_t i = 1; i < size; ++i) {
    reader.push(data[i], on_packet);
    if (silence != 0 && i % silence == 0) reader.gap(on_packet);
  }
  reader.gap(on_packet);
  if (reader.stats().skipped_bytes > size) std::abort();
  return 0;
}
