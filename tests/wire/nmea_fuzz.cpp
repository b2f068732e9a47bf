// For any bytes: positions are on the earth, and fields lie in their frame.
#include <cmath>
#include <cstdlib>

#include "wire/nmea.hpp"

using namespace sinew::wire;

namespace {
bool outside(double v, double most) { return !std::isnan(v) && !(v >= -most && v <= most); }
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  NmeaScanner scanner;
  for (std::size_t i = 0; i < size; ++i)
    scanner.push(data[i], [](std::span<const std::uint8_t> frame) {
      const auto s = split_nmea(frame);
      if (!s) return;
      if (s->count > NmeaSentence::kMaxFields) std::abort();
      if (const auto g = decode_gga(*s); g && (outside(g->latitude_deg, 90) || outside(g->longitude_deg, 180)))
        std::abort();
      if (const auto r = decode_rmc(*s); r && (outside(r->latitude_deg, 90) || outside(r->time_s, 86461))) std::abort();
      if (const auto v = decode_vtg(*s); v && std::isinf(v->speed_mps)) std::abort();
      if (const auto g = decode_gsa(*s); g && g->fix < 0) std::abort();
    });
  return 0;
}
