// For any bytes: sticks stay within their way, and decoded channels pack to the same channels.
#include <cstdlib>

#include "wire/sbus.hpp"

using namespace sinew::wire;

/// The first byte says after how many bytes the line pauses.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  SbusScanner scanner;
  for (std::size_t i = 1; i < size; ++i) {
    if (data[0] != 0 && i % data[0] == 0) scanner.gap();
    scanner.push(data[i], [](const SbusFrame& f) {
      RcCounts again = unpack_rc(std::span<const std::uint8_t, 25>(encode_sbus(f)).subspan<1, kRcBytes>());
      if (again != f.channel) std::abort();
      for (const std::uint16_t c : f.channel)
        if (!(rc_stick(c) >= -1.25 && rc_stick(c) <= 1.25)) std::abort();
    });
  }
  return 0;
}
