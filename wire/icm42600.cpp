#include "wire/icm42600.hpp"

namespace sinew::wire::icm42600 {
namespace {

constexpr std::int16_t kNoValue = -32768;

/// 0 for the widest range, 3 for the narrowest: FS_SEL of both sensors.
std::optional<std::uint8_t> range_bits(int value, int widest) {
  for (std::uint8_t i = 0; i < 4; ++i)
    if (value == widest >> i) return i;
  return {};
}

std::optional<std::uint8_t> rate_bits(int rate_hz) {
  constexpr struct {
    int rate_hz;
    std::uint8_t bits;
  } kRates[] = {{8000, 3}, {4000, 4}, {2000, 5}, {1000, 6}, {500, 15}, {200, 7}, {100, 8}, {50, 9}, {25, 10}};
  for (const auto& r : kRates)
    if (r.rate_hz == rate_hz) return r.bits;
  return {};
}

msg::Vec3 scaled(const std::array<std::int16_t, 3>& raw, double per_count) {
  return {raw[0] * per_count, raw[1] * per_count, raw[2] * per_count};
}

std::array<std::int16_t, 3> three(const std::uint8_t* p) { return {be16s(p), be16s(p + 2), be16s(p + 4)}; }

}  // namespace

const char* name_of(std::uint8_t who_am_i) noexcept {
  switch (who_am_i) {
    case 0x40:
      return "ICM-42600";
    case 0x41:
      return "ICM-42602";
    case 0x42:
      return "ICM-42605";
    case 0x46:
      return "ICM-42622";
    case 0x47:
      return "ICM-42688";
    case 0x5C:
      return "ICM-42631";
    default:
      return nullptr;
  }
}

std::optional<std::array<RegisterWrite, 8>> setup_writes(const Setup& setup) noexcept {
  const auto accel = range_bits(setup.accel_g, 16), gyro = range_bits(setup.gyro_dps, 2000);
  const auto rate = rate_bits(setup.rate_hz);
  if (!accel || !gyro || !rate) return {};
  return {{{{kBank, 0},
            {kInterface0, 0x30},  // FIFO count in bytes; counts and samples big endian
            {kGyroConfig0, static_cast<std::uint8_t>(*gyro << 5 | *rate)},
            {kAccelConfig0, static_cast<std::uint8_t>(*accel << 5 | *rate)},
            {kFilter0, 0x11},                                                   // both: bandwidth max(400 Hz, rate) / 4
            {kFifoConfig1, setup.fifo ? std::uint8_t{0x07} : std::uint8_t{0}},  // accel, gyro, temperature
            {kFifoConfig, setup.fifo ? std::uint8_t{0x40} : std::uint8_t{0}},   // stream
            {kPower0, 0x0F}}}};                                                 // both in low-noise mode
}

bool is_valid(const Sample& s) noexcept {
  for (const auto& raw : {s.accel, s.gyro})
    if (raw[0] == kNoValue && raw[1] == kNoValue && raw[2] == kNoValue) return false;
  return true;
}

Sample decode_burst(std::span<const std::uint8_t, kBurst> bytes) noexcept {
  return {three(bytes.data() + 2), three(bytes.data() + 8)};
}

double temperature_c(std::span<const std::uint8_t, kBurst> bytes) noexcept {
  return be16s(bytes.data()) / 132.48 + 25.0;
}

std::optional<Sample> decode_packet(std::span<const std::uint8_t, kPacket> bytes) noexcept {
  // Bit 7: no data; 6 and 5: accel and gyro are in it; 4: the 20-byte form.
  if ((bytes[0] & 0xF0) != 0x60) return {};
  return Sample{three(bytes.data() + 1), three(bytes.data() + 7)};
}

msg::Vec3 accel_mps2(const Sample& sample, const Setup& setup) noexcept {
  return scaled(sample.accel, setup.accel_g * kStandardGravity / 32768.0);
}

msg::Vec3 gyro_radps(const Sample& sample, const Setup& setup) noexcept {
  // 16.4 counts per deg/s at 2000 deg/s, 131 at 250: DS-000347 section 3.1.
  return scaled(sample.gyro, setup.gyro_dps / 250.0 / 131.0 * kRadPerDeg);
}

}  // namespace sinew::wire::icm42600
