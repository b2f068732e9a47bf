#pragma once
// The messages between a simulated camera (V4l2Source) and the process that opens it (V4l2TreePort): both ends are of
// one build, on one machine. The listening end sends CableHello, with the memory of its pictures; from then on
// CableMessage both ways.
#include <cstdint>

#include "msg/image.hpp"

namespace sinew::hal {

inline constexpr std::uint32_t kCableMagic = 0x31563453;  // "S4V1"
inline constexpr std::uint32_t kCableSlots = 6;           // pictures on their way; one more is drawn without a slot

struct CableHello {
  std::uint32_t magic = kCableMagic;
  std::uint32_t width = 0, height = 0;
  msg::PixelFormat format = msg::PixelFormat::none;
  std::uint32_t slot_bytes = 0;           // from one msg::Image, with its pixels behind it, to the next
  std::uint32_t rate_mhz = 0;             // thousandths of frames/s
  std::uint32_t busy = 0;                 // another opener has claimed it
  char card[32] = {}, bus_info[32] = {};  // each ends with 0
};

enum class CableWord : std::uint32_t {
  claim = 1,  // opener: wants buffers; the answer is granted or busy
  granted,
  busy,
  start,      // opener: starts the pictures
  stop,       // opener: stops them
  frame,      // source: `slot` holds picture `number`
  give_back,  // opener: `slot` is read
};

struct CableMessage {
  CableWord word{};
  std::uint32_t slot = 0;
  std::uint32_t number = 0;  // the sensor's count of all frames, also of those without a free slot
  std::uint32_t reserved = 0;
};

}  // namespace sinew::hal
