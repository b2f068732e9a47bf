// For any bytes: a datagram that is refused, or one whose parts are written and read again as the same.
#include "wire/text/navdata.hpp"

#include <cstdlib>

using namespace sinew;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  wire::Navdata got, again;
  if (wire::decode_navdata({data, size}, got) != wire::NavdataError::none) return 0;
  for (const auto message : {"state", "demo", "raw"})
    for (const auto key : {"flying", "bits", "sequence", "battery", "velocity", "voltage", ""})
      for (std::size_t i = 0; i < 4; ++i)
        if (wire::navdata_value(got, message, key, i) && !wire::is_navdata_value(message, key, i)) std::abort();
  std::array<std::uint8_t, 512> bytes{};
  const std::size_t n = wire::encode_navdata(got, bytes);
  if (n == 0 || wire::decode_navdata({bytes.data(), n}, again) != wire::NavdataError::none) std::abort();
  if (again.state != got.state || again.sequence != got.sequence || again.has_demo != got.has_demo) std::abort();
  if (again.has_demo && again.battery_percent != got.battery_percent) std::abort();
  return 0;
}
