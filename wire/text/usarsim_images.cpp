#include "wire/text/usarsim_images.hpp"

namespace sinew::wire {
namespace {

constexpr std::uint8_t kWorstUsarJpeg = 5;
constexpr std::size_t kUsarShape = 4, kUsarPixel = 3;

std::uint32_t big32(const std::uint8_t* p) {
  return std::uint32_t{p[0]} << 24 | std::uint32_t{p[1]} << 16 | std::uint32_t{p[2]} << 8 | p[3];
}
std::uint32_t big16(const std::uint8_t* p) { return std::uint32_t{p[0]} << 8 | p[1]; }

}  // namespace

UsarImageError parse_usarsim_image_head(std::span<const std::uint8_t, kUsarImageHead> bytes,
                                        UsarImageHead& out) noexcept {
  out = {bytes[0] != 0, big32(bytes.data() + 1)};
  if (bytes[0] > kWorstUsarJpeg) return UsarImageError::type;
  return out.size == 0 || out.size > kUsarMostImage ? UsarImageError::size : UsarImageError::none;
}

UsarImageError parse_usarsim_raw_image(std::span<const std::uint8_t> bytes, UsarRawImage& out) noexcept {
  out = {};
  if (bytes.size() < kUsarShape) return UsarImageError::shape;
  const std::uint32_t width = big16(bytes.data()), height = big16(bytes.data() + 2);
  if (width == 0 || height == 0) return UsarImageError::shape;
  const std::size_t row = kUsarPixel * width, padded = (row + 3) / 4 * 4;
  const std::size_t rest = bytes.size() - kUsarShape;
  if (rest != padded * height && rest != row * height) return UsarImageError::shape;
  out = {width, height, rest == padded * height ? padded : row, bytes.subspan(kUsarShape)};
  return UsarImageError::none;
}

std::size_t write_usarsim_image_request(const UsarImageRegion& region,
                                        std::span<std::uint8_t, kUsarImageRequest> out) noexcept {
  if (region.width == 0) {
    out[0] = 'O', out[1] = 'K';
    return 2;
  }
  std::size_t used = 0;
  out[used++] = 'U';
  for (const std::uint32_t number : {region.x, region.y, region.width, region.height})
    for (const int shift : {24, 16, 8, 0}) out[used++] = static_cast<std::uint8_t>(number >> shift);
  return used;
}

}  // namespace sinew::wire
