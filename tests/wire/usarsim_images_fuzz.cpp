// For any bytes: pictures that are refused, or whose every row lies within the bytes.
#include "wire/text/usarsim_images.hpp"

#include <cstdlib>

using namespace sinew;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  if (size >= wire::kUsarImageHead) {
    wire::UsarImageHead head;
    if (wire::parse_usarsim_image_head(bytes.first<wire::kUsarImageHead>(), head) == wire::UsarImageError::none &&
        (head.size == 0 || head.size > wire::kUsarMostImage))
      std::abort();
  }
  wire::UsarRawImage raw;
  if (wire::parse_usarsim_raw_image(bytes, raw) != wire::UsarImageError::none) return 0;
  if (raw.width == 0 || raw.height == 0) std::abort();
  std::uint32_t sum = 0;
  for (std::uint32_t y = 0; y < raw.height; ++y) {
    const std::uint8_t* row = raw.row(y);
    if (row < data || row + std::size_t{3} * raw.width > data + size) std::abort();
    sum += row[0] + row[3 * raw.width - 1];
  }
  return sum == 0xFFFFFFFF ? 1 : 0;
}
