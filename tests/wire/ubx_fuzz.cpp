// For any bytes: a frame that was found encodes to the same bytes again.
#include <algorithm>
#include <cstdlib>

#include "wire/ubx.hpp"

using namespace sinew::wire;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  UbxScanner scanner;
  for (std::size_t i = 0; i < size; ++i)
    scanner.push(data[i], [](std::span<const std::uint8_t> frame) {
      std::array<std::uint8_t, UbxFormat::kMaxFrame> again{};
      const std::size_t n = encode_ubx(ubx_class(frame), ubx_id(frame), ubx_payload(frame), again);
      if (n != frame.size() || !std::equal(frame.begin(), frame.end(), again.begin())) std::abort();
      if (const auto pvt = decode_nav_pvt(frame); pvt && static_cast<unsigned>(pvt->sample.fix) > 5) std::abort();
    });
  return 0;
}
