#include "hal/udp_address.hpp"

#include <charconv>

namespace sinew::hal {
namespace {

/// Takes a number of at most `most`, and the character behind it, off the front; '\0': the text ends with the number.
bool take_number(std::string_view& text, std::uint32_t most, char then, std::uint32_t& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (error != std::errc() || out > most) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (then == '\0') return text.empty();
  if (!text.starts_with(then)) return false;
  text.remove_prefix(1);
  return true;
}

}  // namespace

std::optional<UdpAddress> udp_address(std::string_view text) noexcept {
  UdpAddress out;
  std::uint32_t number = 0;
  for (const char then : {'.', '.', '.', ':'}) {
    if (!take_number(text, 255, then, number)) return std::nullopt;
    out.ipv4 = out.ipv4 << 8 | number;
  }
  if (!take_number(text, 65535, '\0', number) || number == 0) return std::nullopt;
  out.port = static_cast<std::uint16_t>(number);
  return out;
}

std::string to_text(const UdpAddress& address) {
  std::string out;
  for (const unsigned shift : {24u, 16u, 8u, 0u})
    out += std::to_string(address.ipv4 >> shift & 255) + (shift == 0 ? ':' : '.');
  return out + std::to_string(address.port);
}

}  // namespace sinew::hal
