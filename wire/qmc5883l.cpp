#include "wire/qmc5883l.hpp"

namespace sinew::wire::qmc5883l {

std::optional<std::array<RegisterWrite, 3>> setup_writes(const Setup& setup) noexcept {
  constexpr int kRates[] = {10, 50, 100, 200};
  for (std::uint8_t i = 0; i < 4; ++i) {
    if (kRates[i] != setup.rate_hz || (setup.range_gauss != 2 && setup.range_gauss != 8)) continue;
    const std::uint8_t range = setup.range_gauss == 8 ? 0x10 : 0;
    return {{{{kSetReset, 0x01},                                                 // the period that the maker asks for
              {kControl2, 0x01},                                                 // no interrupt pin
              {kControl1, static_cast<std::uint8_t>(0x01 | i << 2 | range)}}}};  // 512 x oversampled, continuous
  }
  return {};
}

Sample decode_burst(std::span<const std::uint8_t, kBurst> b) noexcept {
  return {{le16s(&b[0]), le16s(&b[2]), le16s(&b[4])}, (b[6] & kReady) != 0, (b[6] & kOverflow) != 0};
}

msg::Vec3 field_t(const Sample& s, const Setup& setup) noexcept {
  const double per_count = 1e-4 / (setup.range_gauss == 8 ? 3000.0 : 12000.0);  // 1 gauss = 1e-4 T
  return {s.field[0] * per_count, s.field[1] * per_count, s.field[2] * per_count};
}

}  // namespace sinew::wire::qmc5883l
