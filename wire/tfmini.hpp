#pragma once
// Frames of the TFmini, TFmini-S, TFmini Plus and TF-Luna range finders in their standard output format.
// Source:  Benewake SJ-PM-TFmini-S A00 product manual, section 5.2 "Data communication format" (115200 8N1).
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "wire/frame_scanner.hpp"

namespace sinew::wire {

/// 0x59 0x59, distance (cm), strength, temperature or mode, reserved, sum of the first 8 bytes; little endian.
struct TfMiniFormat {
  static constexpr std::size_t kMaxFrame = 9;
  static FrameVerdict check(std::span<const std::uint8_t> bytes) noexcept;
};
using TfMiniScanner = FrameScanner<TfMiniFormat>;

struct TfMiniReading {
  double range_m = 0;  // NaN: no echo, too much light, or too weak to be trusted
  std::uint16_t strength = 0;
};
/// Of a whole frame. `weakest`: strength below which the maker calls the distance unreliable (100; TFmini of 2017: 20).
TfMiniReading decode_tfmini(std::span<const std::uint8_t> frame, std::uint16_t weakest = 100) noexcept;
/// For simulated devices.
std::array<std::uint8_t, 9> encode_tfmini(std::uint16_t distance_cm, std::uint16_t strength) noexcept;

}  // namespace sinew::wire
