#include "wire/mpu6050.hpp"

namespace sinew::wire::mpu6050 {
namespace {

/// 0..3 for first, 2 first, 4 first, 8 first: the FS_SEL bits of both sensors.
std::optional<std::uint8_t> range_bits(int value, int first) {
  for (std::uint8_t i = 0; i < 4; ++i)
    if (value == first << i) return i;
  return {};
}

msg::Vec3 scaled(const std::array<std::int16_t, 3>& raw, double per_count) {
  return {raw[0] * per_count, raw[1] * per_count, raw[2] * per_count};
}

std::array<std::int16_t, 3> three(const std::uint8_t* p) { return {be16s(p), be16s(p + 2), be16s(p + 4)}; }

}  // namespace

std::optional<Chip> chip_of(std::uint8_t who_am_i) noexcept {
  switch (who_am_i) {
    case 0x68:
      return Chip::mpu6050;
    case 0x70:
      return Chip::mpu6500;
    case 0x71:
      return Chip::mpu9250;
    case 0x73:
      return Chip::mpu9255;
    default:
      return {};
  }
}

const char* to_string(Chip chip) noexcept {
  constexpr const char* kNames[] = {"MPU-6050", "MPU-6500", "MPU-9250", "MPU-9255"};
  return kNames[static_cast<std::size_t>(chip)];
}

std::optional<std::array<RegisterWrite, 9>> setup_writes(const Setup& setup, Chip chip) noexcept {
  const auto accel = range_bits(setup.accel_g, 2), gyro = range_bits(setup.gyro_dps, 250);
  if (!accel || !gyro || setup.filter < 1 || setup.filter > 6) return {};
  if (setup.rate_hz < 4 || setup.rate_hz > 1000 || 1000 % setup.rate_hz != 0) return {};
  const auto filter = static_cast<std::uint8_t>(setup.filter);
  const auto user = static_cast<std::uint8_t>((setup.fifo ? kFifoOn : 0) | (setup.spi ? kI2cOff : 0));
  return {{{{kPower1, kClockGyro},
            {kPower2, 0},
            {kConfig, filter},
            {kSampleRateDivider, static_cast<std::uint8_t>(1000 / setup.rate_hz - 1)},
            {kGyroConfig, static_cast<std::uint8_t>(*gyro << 3)},
            {kAccelConfig, static_cast<std::uint8_t>(*accel << 3)},
            // The older chip has no second filter; its register there is reserved: kPower2 once more does nothing.
            chip == Chip::mpu6050 ? RegisterWrite{kPower2, 0} : RegisterWrite{kAccelConfig2, filter},
            {kFifoEnable, setup.fifo ? kFifoAccelGyro : std::uint8_t{0}},
            {kUserControl, user}}}};
}

msg::Duration filter_delay(int filter) noexcept {
  constexpr int kMicroseconds[] = {980, 1900, 2800, 4800, 8300, 13400, 18600};
  return std::chrono::microseconds(filter >= 0 && filter < 7 ? kMicroseconds[filter] : 0);
}

Sample decode_burst(std::span<const std::uint8_t, kBurst> bytes) noexcept {
  return {three(bytes.data()), three(bytes.data() + 8)};
}

Sample decode_packet(std::span<const std::uint8_t, kPacket> bytes) noexcept {
  return {three(bytes.data()), three(bytes.data() + 6)};
}

double temperature_c(std::span<const std::uint8_t, kBurst> bytes, Chip chip) noexcept {
  const double raw = be16s(bytes.data() + 6);
  return chip == Chip::mpu6050 ? raw / 340.0 + 36.53 : raw / 333.87 + 21.0;
}

msg::Vec3 accel_mps2(const Sample& sample, const Setup& setup) noexcept {
  return scaled(sample.accel, setup.accel_g * kStandardGravity / 32768.0);
}

msg::Vec3 gyro_radps(const Sample& sample, const Setup& setup) noexcept {
  // 131 counts per deg/s at 250 deg/s, and so on: PS-MPU-6000A section 6.1.
  return scaled(sample.gyro, setup.gyro_dps / 250.0 / 131.0 * kRadPerDeg);
}

}  // namespace sinew::wire::mpu6050
