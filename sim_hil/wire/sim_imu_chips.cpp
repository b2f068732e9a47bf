#include "sim_hil/wire/sim_imu_chips.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "wire/icm42600.hpp"
#include "wire/mpu6050.hpp"

namespace sinew::sim_hil {
namespace {

namespace mpu = wire::mpu6050;
namespace icm = wire::icm42600;

/// Six big-endian counts, as both chips lay them out; clipped at the range.
std::vector<std::uint8_t> counts(const msg::Vec3& v, double per_unit) {
  std::vector<std::uint8_t> out;
  for (const double axis : {v.x, v.y, v.z}) {
    const auto c = static_cast<std::uint16_t>(
        static_cast<std::int16_t>(std::clamp(std::lround(axis * per_unit), -32768L, 32767L)));
    out.push_back(static_cast<std::uint8_t>(c >> 8));
    out.push_back(static_cast<std::uint8_t>(c));
  }
  return out;
}

double accel_counts(int full_g) { return 32768.0 / (full_g * wire::kStandardGravity); }
double gyro_counts(int full_dps) { return 131.0 * 250.0 / full_dps / wire::kRadPerDeg; }

}  // namespace

void SimMpu6050::reset() {
  for (int i = 0; i < 256; ++i) poke(static_cast<std::uint8_t>(i), 0);
  poke(mpu::kPower1, who_am_i_ == 0x68 ? 0x40 : 0x01);  // the older chip sleeps after power-on
  poke(mpu::kWhoAmI, who_am_i_);
  fifo_.clear();
}

void SimMpu6050::measure(const msg::ImuSample& sample) {
  const auto held = lock();
  if (peek(mpu::kPower1) & 0x40) return;
  const auto a = counts(sample.accel_mps2, accel_counts(2 << (peek(mpu::kAccelConfig) >> 3 & 3)));
  const auto g = counts(sample.gyro_radps, gyro_counts(250 << (peek(mpu::kGyroConfig) >> 3 & 3)));
  for (std::uint8_t i = 0; i < 6; ++i) {
    poke(static_cast<std::uint8_t>(mpu::kAccelX + i), a[i]);
    poke(static_cast<std::uint8_t>(mpu::kAccelX + 8 + i), g[i]);
  }
  poke(mpu::kIntStatus, peek(mpu::kIntStatus) | mpu::kDataReady);
  if (!(peek(mpu::kUserControl) & mpu::kFifoOn) || peek(mpu::kFifoEnable) != mpu::kFifoAccelGyro) return;
  fifo_.insert(fifo_.end(), a.begin(), a.end());
  fifo_.insert(fifo_.end(), g.begin(), g.end());
  const std::size_t room = who_am_i_ == 0x68 ? 1024 : 512;
  while (fifo_.size() > room) fifo_.pop_front();  // the oldest go, and packets are cut
}

std::uint8_t SimMpu6050::on_read(std::uint8_t address) {
  if (address == mpu::kFifoCount) return static_cast<std::uint8_t>(fifo_.size() >> 8);
  if (address == mpu::kFifoCount + 1) return static_cast<std::uint8_t>(fifo_.size());
  if (address == mpu::kFifoData) {
    if (fifo_.empty()) return 0xFF;
    const std::uint8_t b = fifo_.front();
    fifo_.pop_front();
    return b;
  }
  const std::uint8_t value = peek(address);
  if (address == mpu::kIntStatus) poke(address, 0);  // reading clears it
  return value;
}

void SimMpu6050::on_write(std::uint8_t address, std::uint8_t value) {
  if (address == mpu::kWhoAmI) return;
  if (address == mpu::kPower1 && (value & mpu::kReset)) {
    ++resets_;
    return reset();
  }
  if (address == mpu::kUserControl && (value & mpu::kFifoReset)) {
    fifo_.clear();
    value = static_cast<std::uint8_t>(value & ~mpu::kFifoReset);
  }
  poke(address, value);
}

bool SimMpu6050::is_fifo(std::uint8_t address) const { return address == mpu::kFifoData; }

void SimIcm42600::reset() {
  for (int i = 0; i < 256; ++i) poke(static_cast<std::uint8_t>(i), 0);
  poke(icm::kWhoAmI, who_am_i_);
  poke(icm::kIntStatus, icm::kResetDone);
  fifo_.clear();
}

void SimIcm42600::measure(const msg::ImuSample& sample) {
  const auto held = lock();
  if ((peek(icm::kPower0) & 0x0F) != 0x0F) return;
  const auto a = counts(sample.accel_mps2, accel_counts(16 >> (peek(icm::kAccelConfig0) >> 5)));
  const auto g = counts(sample.gyro_radps, gyro_counts(2000 >> (peek(icm::kGyroConfig0) >> 5)));
  for (std::uint8_t i = 0; i < 6; ++i) {
    poke(static_cast<std::uint8_t>(icm::kTemperature + 2 + i), a[i]);
    poke(static_cast<std::uint8_t>(icm::kTemperature + 8 + i), g[i]);
  }
  poke(icm::kIntStatus, peek(icm::kIntStatus) | icm::kDataReady);
  if (peek(icm::kFifoConfig) != 0x40) return;
  if (fifo_.size() + icm::kPacket > icm::kFifoBytes) {
    poke(icm::kIntStatus, peek(icm::kIntStatus) | icm::kFifoFull);
    return;
  }
  fifo_.push_back(0x68);
  fifo_.insert(fifo_.end(), a.begin(), a.end());
  fifo_.insert(fifo_.end(), g.begin(), g.end());
  fifo_.insert(fifo_.end(), {0, 0, 0});
}

std::uint8_t SimIcm42600::on_read(std::uint8_t address) {
  if (address == icm::kFifoCount) return static_cast<std::uint8_t>(fifo_.size() >> 8);
  if (address == icm::kFifoCount + 1) return static_cast<std::uint8_t>(fifo_.size());
  if (address == icm::kFifoData) {
    if (fifo_.empty()) return 0xFF;
    const std::uint8_t b = fifo_.front();
    fifo_.pop_front();
    return b;
  }
  const std::uint8_t value = peek(address);
  if (address == icm::kIntStatus) poke(address, 0);
  return value;
}

void SimIcm42600::on_write(std::uint8_t address, std::uint8_t value) {
  if (address == icm::kWhoAmI) return;
  if (address == icm::kDeviceConfig && (value & icm::kSoftReset)) {
    ++resets_;
    return reset();
  }
  if (address == icm::kSignalPathReset && (value & icm::kFifoFlush)) {
    fifo_.clear();
    return;
  }
  poke(address, value);
}

bool SimIcm42600::is_fifo(std::uint8_t address) const { return address == icm::kFifoData; }

}  // namespace sinew::sim_hil
