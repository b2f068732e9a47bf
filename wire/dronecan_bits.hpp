#pragma once
// Fields of DSDL data types, one after the other without gaps: each field's lowest byte first, in each byte the highest
// bit first. The rest of the last byte thus has the high bits.
// Source:  DroneCAN specification, "Data serialization".
#include <cstdint>
#include <span>

namespace sinew::wire {

/// IEEE 754 half precision. Rounds to nearest, ties to even; finite values beyond are pulled in to 65504, as DSDL's
/// "saturated" says.   RT: yes.
std::uint16_t half_from_float(float value) noexcept;
float float_from_half(std::uint16_t half) noexcept;

class BitWriter {
 public:
  explicit BitWriter(std::span<std::uint8_t> out) : out_(out) {}
  /// The lowest `bits` (1..64) of the value.
  void put(std::uint64_t value, int bits) noexcept;
  /// Pulled in to what fits.
  void put_signed(std::int64_t value, int bits) noexcept;
  void put_unsigned(std::uint64_t value, int bits) noexcept;
  void put_half(double value) noexcept { put(half_from_float(static_cast<float>(value)), 16); }
  void put_bytes(std::span<const std::uint8_t> bytes) noexcept;
  /// Bytes begun; 0 when it did not fit.
  std::size_t size() const noexcept { return fits_ ? (bit_ + 7) / 8 : 0; }

 private:
  std::span<std::uint8_t> out_;
  std::size_t bit_ = 0;
  bool fits_ = true;
};

class BitReader {
 public:
  explicit BitReader(std::span<const std::uint8_t> in) : in_(in) {}
  /// 0 beyond the end, which ok() remembers.
  std::uint64_t take(int bits) noexcept;
  std::int64_t take_signed(int bits) noexcept;
  double take_half() noexcept { return float_from_half(static_cast<std::uint16_t>(take(16))); }
  std::size_t bits_left() const noexcept { return in_.size() * 8 - bit_; }
  bool ok() const noexcept { return ok_; }

 private:
  std::span<const std::uint8_t> in_;
  std::size_t bit_ = 0;
  bool ok_ = true;
};

}  // namespace sinew::wire
