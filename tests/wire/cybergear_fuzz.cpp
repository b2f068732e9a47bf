// Decoded values lie in their ranges, and encode to the same bytes.
#include "fuzz_frame.hpp"
#include "wire/cybergear.hpp"

using namespace sinew::wire;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  sinew::msg::CanFrame frame = fuzz_frame(data, size);
  frame.id &= 0x1FFFFFFF;
  const CyberGearId id = split_cybergear_id(frame.id);
  must(cybergear_id(static_cast<CyberGearKind>(id.kind), id.data, id.target) == frame.id);
  if (const auto motion = decode_cybergear_motion(frame)) {
    must(motion->kp >= 0 && motion->kp <= kCyberGearKp && motion->kd >= 0 && motion->kd <= kCyberGearKd);
    must(same_bytes(encode_cybergear_motion(id.target, *motion), frame));
  }
  if (const auto feedback = decode_cybergear_feedback(frame)) {
    must(feedback->position_rad >= -kCyberGearPosition_rad && feedback->position_rad <= kCyberGearPosition_rad);
    must(same_bytes(encode_cybergear_feedback(*feedback), frame));
  }
  if (const auto serial = decode_cybergear_identity(frame)) must(get_le<std::uint64_t>(frame, 0) == *serial);
  if (const auto p = decode_cybergear_parameter(frame)) {
    const auto kind = static_cast<CyberGearKind>(id.kind);
    const auto again = decode_cybergear_parameter(encode_cybergear_parameter(kind, id.data, id.target, *p));
    must(again && again->index == p->index && again->bits == p->bits);
  }
  if (const auto bits = decode_cybergear_fault(frame)) must((joint_faults_of_report(*bits) == 0) == (*bits == 0));
  return 0;
}
