#include "wire/tfmini.hpp"

#include <limits>

#include "wire/sensor_bytes.hpp"

namespace sinew::wire {
namespace {

constexpr std::uint8_t kTfMiniHead = 0x59;

std::uint8_t sum_of(std::span<const std::uint8_t> bytes) {
  std::uint8_t sum = 0;
  for (const std::uint8_t b : bytes) sum = static_cast<std::uint8_t>(sum + b);
  return sum;
}

}  // namespace

FrameVerdict TfMiniFormat::check(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes[0] != kTfMiniHead || (bytes.size() > 1 && bytes[1] != kTfMiniHead)) return {FrameVerdict::foreign};
  if (bytes.size() < kMaxFrame) return {FrameVerdict::more};
  return {sum_of(bytes.first(8)) == bytes[8] ? FrameVerdict::good : FrameVerdict::broken, kMaxFrame};
}

TfMiniReading decode_tfmini(std::span<const std::uint8_t> frame, std::uint16_t weakest) noexcept {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  if (frame.size() < TfMiniFormat::kMaxFrame) return {kNothing, 0};
  const std::uint16_t cm = le16(&frame[2]), strength = le16(&frame[4]);
  // 65535, 65534, 65532: strength too low, saturated, ambient light (manual, table of distances).
  const bool usable = cm > 0 && cm < 65532 && strength >= weakest && strength != 65535;
  return {usable ? cm * 0.01 : kNothing, strength};
}

std::array<std::uint8_t, 9> encode_tfmini(std::uint16_t cm, std::uint16_t strength) noexcept {
  std::array<std::uint8_t, 9> f{kTfMiniHead,
                                kTfMiniHead,
                                static_cast<std::uint8_t>(cm),
                                static_cast<std::uint8_t>(cm >> 8),
                                static_cast<std::uint8_t>(strength),
                                static_cast<std::uint8_t>(strength >> 8),
                                0,
                                0,
                                0};
  f[8] = sum_of({f.data(), 8});
  return f;
}

}  // namespace sinew::wire
