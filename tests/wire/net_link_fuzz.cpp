// For any bytes: no packet, or one that is written to the same bytes again.
#include <cstdlib>
#include <cstring>
#include <vector>

#include "wire/net_link.hpp"

using namespace sinew;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto packet = wire::read_net_link({data, size});
  if (!packet) return 0;
  std::vector<std::uint8_t> out(size);
  if (wire::write_net_link(*packet, out) != size || std::memcmp(out.data(), data, size) != 0) std::abort();
  return 0;
}
