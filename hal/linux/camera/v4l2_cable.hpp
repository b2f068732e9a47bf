#pragma once
// What passes between a simulated camera (V4l2Source) and who opens it (V4l2TreePort): both ends are of one build, on
// one machine. The listening end says CableHello, with the memory of its pictures; from then on CableMessage both ways.
#include <cstdint>

#include "msg/image.hpp"

namespace sinew::hal {

inline constexpr std::uint32_t kCableMagic = 0x31563453;  // "S4V1"
inline constexpr std::uint32_t kCableSlots = 6;           // pictures on their way; one more is drawn that has no place

struct CableHello {
  std::uint32_t magic = kCableMagic;
  std::uint32_t width = 0, height = 0;
  msg::PixelFormat format = msg::PixelFormat::none;
  std::uint32_t slot_bytes = 0;           // from one msg::Image, with its pixels behind it, to the next
  std::uint32_t rate_mhz = 0;             // thousandths of frames/s
  std::uint32_t busy = 0;                 // somebody else has claimed it
  char card[32] = {}, bus_info[32] = {};  // with their zero
};

enum class CableWord : std::uint32_t {
  claim = 1,  // opener: it wants buffers; answered by granted or busy
  granted,
  busy,
  start,      // opener: pictures, please
  stop,       // opener
  frame,      // source: `slot` holds picture `number`
  give_back,  // opener: `slot` is read
};

struct CableMessage {
  CableWord word{};
  std::uint32_t slot = 0;
  std::uint32_t number = 0;  // counted by the sensor: all that it took, also those that no slot was left for
  std::uint32_t reserved = 0;
};

}  // namespace sinew::hal
