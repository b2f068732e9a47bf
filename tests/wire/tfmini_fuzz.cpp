// For any bytes: found frames are frames, and their range is a distance or nothing.
#include <cmath>
#include <cstdlib>

#include "wire/tfmini.hpp"

using namespace sinew::wire;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  TfMiniScanner scanner;
  for (std::size_t i = 0; i < size; ++i)
    scanner.push(data[i], [](std::span<const std::uint8_t> frame) {
      if (frame.size() != TfMiniFormat::kMaxFrame) std::abort();
      const double range_m = decode_tfmini(frame).range_m;
      if (!std::isnan(range_m) && (range_m <= 0 || range_m > 655.32)) std::abort();
    });
  const ScanStats& s = scanner.stats();
  if (s.frames * 9 + s.skipped_bytes > size) std::abort();
  return 0;
}
