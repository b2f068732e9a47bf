// For every motor type: decoded values lie in their ranges, and encode to the same bytes.
#include "fuzz_frame.hpp"
#include "wire/mit_motor.hpp"

using namespace sinew::wire;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const sinew::msg::CanFrame frame = fuzz_frame(data, size);
  (void)decode_mit_switch(frame);
  for (const MitMotorType& type : mit_motor_types()) {
    if (const auto c = decode_mit_command(frame, type)) {
      must(c->position_rad >= -type.position_rad && c->position_rad <= type.position_rad);
      must(c->velocity_radps >= -type.velocity_radps && c->velocity_radps <= type.velocity_radps);
      must(c->kp >= 0 && c->kp <= type.kp && c->kd >= 0 && c->kd <= type.kd);
      must(c->effort_nm >= -type.effort_nm && c->effort_nm <= type.effort_nm);
      const sinew::msg::CanFrame again = encode_mit(frame.id, *c, type);
      must(!decode_mit_switch(again).has_value());
      if (frame.data[7] < 0xF0) must(same_bytes(again, frame));
    }
    if (const auto f = decode_mit_reply(frame, type)) {
      must(f->position_rad >= -type.position_rad && f->position_rad <= type.position_rad);
      must(f->velocity_radps >= -type.velocity_radps && f->velocity_radps <= type.velocity_radps);
      must(f->effort_nm >= -type.effort_nm && f->effort_nm <= type.effort_nm);
      if (type.reply != MitReply::status) must(same_bytes(encode_mit_reply(frame.id, *f, type), frame));
    }
  }
  return 0;
}
