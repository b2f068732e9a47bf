// For any bytes: channels pack to the same frame again, and link figures stay in their ranges.
#include <algorithm>
#include <cstdlib>

#include "wire/crsf.hpp"

using namespace sinew::wire;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  CrsfScanner scanner;
  for (std::size_t i = 0; i < size; ++i)
    scanner.push(data[i], [](std::span<const std::uint8_t> frame) {
      if (const auto counts = decode_crsf_channels(frame)) {
        const auto again = encode_crsf_channels(*counts);
        if (!std::equal(again.begin() + 1, again.end(), frame.begin() + 1)) std::abort();
      }
      const auto link = decode_crsf_link(frame);
      if (link && !(link->link_quality >= 0 && link->link_quality <= 1 && link->rssi_dbm <= 0)) std::abort();
    });
  return 0;
}
