// Each frame that decodes also encodes, and then decodes to the same.
#include "fuzz_frame.hpp"
#include "wire/cia402.hpp"

using namespace sinew::wire;

namespace {
bool same(const Sdo& a, const Sdo& b) {
  return a.kind == b.kind && a.object == b.object && a.size == b.size && a.toggle == b.toggle && a.last == b.last &&
         a.data == b.data && a.total == b.total && a.abort_code == b.abort_code;
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const sinew::msg::CanFrame frame = fuzz_frame(data, size);
  const CanopenId id = canopen_id(frame.id);
  must(id.node <= kMaxCanopenNode && id.number <= 4);
  if (const auto nmt = decode_nmt(frame)) must(same_bytes(encode_nmt(nmt->command, nmt->node), frame));
  if (const auto state = decode_heartbeat(frame)) must(decode_heartbeat(encode_heartbeat(id.node, *state)) == state);
  if (const auto emergency = decode_emergency(frame)) {
    must(same_bytes(encode_emergency(id.node, *emergency), frame));
    (void)joint_faults(emergency->code);
  }
  if (const auto sdo = decode_sdo_request(frame)) {
    const auto again = decode_sdo_request(encode_sdo_request(5, *sdo));
    must(again && same(*again, *sdo));
  }
  if (const auto sdo = decode_sdo_reply(frame)) {
    must(sdo->size <= 7);
    const auto again = decode_sdo_reply(encode_sdo_reply(5, *sdo));
    must(again && same(*again, *sdo));
    (void)to_string(static_cast<SdoAbort>(sdo->abort_code));
  }
  const auto word = get_le<std::uint16_t>(frame, 0), before = get_le<std::uint16_t>(frame, 2);
  if (const auto state = drive_state(word)) {
    must(drive_state(state_bits(*state)) == state);
    for (const DriveGoal goal : {DriveGoal::off, DriveGoal::enabled, DriveGoal::quick_stop}) {
      (void)next_state(*state, next_controlword(*state, goal), before);
    }
  }
  return 0;
}
