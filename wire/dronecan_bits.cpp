#include "wire/dronecan_bits.hpp"

#include <algorithm>
#include <bit>

namespace sinew::wire {

std::uint16_t half_from_float(float value) noexcept {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = bits >> 16 & 0x8000, magnitude = bits & 0x7FFFFFFF;
  if (magnitude > 0x7F800000) return static_cast<std::uint16_t>(sign | 0x7E00);  // not a number
  if (magnitude == 0x7F800000) return static_cast<std::uint16_t>(sign | 0x7C00);
  if (magnitude >= 0x477FE000) return static_cast<std::uint16_t>(sign | 0x7BFF);  // 65504 and beyond
  // A half's exponent is 112 less than a float's; below 2^-14 it stays, and the mantissa shifts out to the right.
  const std::uint32_t exponent = magnitude >> 23;
  std::uint32_t mantissa = magnitude, shift = 13;
  std::uint32_t base = 112u << 23;
  if (exponent < 113) {
    if (exponent < 102) return static_cast<std::uint16_t>(sign);  // less than half of the smallest one
    mantissa = (magnitude & 0x7FFFFF) | 0x800000;
    shift = 126 - exponent;
    base = 0;
  }
  const std::uint32_t from = mantissa - base, half = from >> shift, rest = from & ((1u << shift) - 1);
  const std::uint32_t middle = 1u << (shift - 1);
  const std::uint32_t up = rest > middle || (rest == middle && (half & 1) != 0) ? 1 : 0;
  return static_cast<std::uint16_t>(sign | (half + up));
}

float float_from_half(std::uint16_t half) noexcept {
  const std::uint32_t sign = (half & 0x8000u) << 16, exponent = half >> 10 & 0x1F, mantissa = half & 0x3FF;
  if (exponent == 0) {  // a multiple of 2^-24, exact in a float
    const float value = static_cast<float>(mantissa) * 0x1p-24f;
    return sign != 0 ? -value : value;
  }
  const std::uint32_t wide = exponent == 31 ? 255 : exponent + 112;
  return std::bit_cast<float>(sign | wide << 23 | mantissa << 13);
}

void BitWriter::put(std::uint64_t value, int bits) noexcept {
  if (!fits_ || bit_ + static_cast<std::size_t>(bits) > out_.size() * 8) {
    fits_ = false;
    return;
  }
  while (bits > 0) {
    const int chunk = bits < 8 ? bits : 8;
    for (int i = chunk - 1; i >= 0; --i, ++bit_) {
      std::uint8_t& byte = out_[bit_ / 8];
      if (bit_ % 8 == 0) byte = 0;
      if ((value >> i & 1) != 0) byte = static_cast<std::uint8_t>(byte | 0x80u >> bit_ % 8);
    }
    value >>= 8;
    bits -= chunk;
  }
}

void BitWriter::put_signed(std::int64_t value, int bits) noexcept {
  const std::int64_t top = (std::int64_t{1} << (bits - 1)) - 1;
  put(static_cast<std::uint64_t>(std::clamp(value, -top - 1, top)), bits);
}

void BitWriter::put_unsigned(std::uint64_t value, int bits) noexcept {
  const std::uint64_t top = bits < 64 ? (std::uint64_t{1} << bits) - 1 : ~std::uint64_t{0};
  put(value > top ? top : value, bits);
}

void BitWriter::put_bytes(std::span<const std::uint8_t> bytes) noexcept {
  for (const std::uint8_t byte : bytes) put(byte, 8);
}

std::uint64_t BitReader::take(int bits) noexcept {
  if (bits_left() < static_cast<std::size_t>(bits)) {
    ok_ = false;
    bit_ = in_.size() * 8;
    return 0;
  }
  std::uint64_t value = 0;
  for (int done = 0; done < bits; done += 8) {
    const int chunk = bits - done < 8 ? bits - done : 8;
    std::uint64_t part = 0;
    for (int i = 0; i < chunk; ++i, ++bit_) part = part << 1 | (in_[bit_ / 8] >> (7 - bit_ % 8) & 1u);
    value |= part << done;
  }
  return value;
}

std::int64_t BitReader::take_signed(int bits) noexcept {
  const std::uint64_t value = take(bits), sign = std::uint64_t{1} << (bits - 1);
  return static_cast<std::int64_t>((value ^ sign) - sign);
}

}  // namespace sinew::wire
