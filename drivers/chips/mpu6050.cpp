#include "drivers/chips/mpu6050.hpp"

#include <array>
#include <cstdio>

namespace sinew::drivers {

using namespace std::chrono_literals;
namespace mpu = wire::mpu6050;

namespace {

constexpr std::size_t kMpuPacketsAtOnce = 20;

std::array<std::int16_t, 6> six(const mpu::Sample& s) {
  return {s.accel[0], s.accel[1], s.accel[2], s.gyro[0], s.gyro[1], s.gyro[2]};
}

}  // namespace

Mpu6050::Mpu6050(hal::Os& os, std::unique_ptr<Registers> registers, const Mpu6050Config& config)
    : os_(os),
      registers_(std::move(registers)),
      config_(config),
      mount_(config.mount),
      clock_(period(config)),
      watch_(config.stuck_after) {
  config_.chip.spi = registers_->is_spi();
}

hal::Duration Mpu6050::period(const Mpu6050Config& config) {
  return hal::Duration{1'000'000'000 / std::max(1, config.chip.rate_hz)};
}

hal::Status Mpu6050::set_up(std::string& why) {
  const auto failed = [&](const hal::Error& e) {
    why = bus_problem(*registers_, e);
    return e;
  };
  const auto who = registers_->read(mpu::kWhoAmI);
  if (!who) return failed(who.error());
  const auto found = mpu::chip_of(*who);
  if (!found) {
    char hex[8];
    std::snprintf(hex, sizeof hex, "0x%02x", unsigned{*who});
    why = registers_->where() + ": answers who-am-i with " + hex + "; an MPU-6050 says 0x68, 6500 0x70, 9250 0x71" +
          bus_hint(*who);
    return hal::Error{hal::Errc::not_found, "mpu6050: another chip", *who};
  }
  chip_ = *found;
  const auto writes = mpu::setup_writes(config_.chip, chip_);
  if (!writes) {
    why = "accel_g is 2, 4, 8 or 16; gyro_dps 250, 500, 1000 or 2000; filter 1 to 6; rate_hz 1000 / n from 4 to 1000";
    return hal::Error{hal::Errc::bad_argument, "mpu6050"};
  }
  if (auto done = registers_->write(mpu::kPower1, mpu::kReset); !done) return failed(done.error());
  os_.sleep_until(os_.now() + 100ms);  // PS-MPU-6000A section 6.3: start-up time of registers
  if (auto done = registers_->write_and_check(*writes); !done) return failed(done.error());
  os_.sleep_until(os_.now() + 30ms);  // the gyroscope starts
  clock_ = SampleClock(period(config_));
  watch_.restart();
  cut_ = false, odd_ = 0;
  if (config_.chip.fifo)
    if (auto done = empty_fifo(); !done) return failed(done.error());
  return {};
}

hal::Status Mpu6050::empty_fifo() {
  clock_.restart();
  const auto user = static_cast<std::uint8_t>(mpu::kFifoOn | (config_.chip.spi ? mpu::kI2cOff : 0));
  return registers_->write(mpu::kUserControl, user | mpu::kFifoReset);
}

hal::Status Mpu6050::poll(hal::Time now, std::vector<msg::ImuSample>& out, std::string& why) {
  hal::Status done = config_.chip.fifo ? poll_fifo(now, out, why) : poll_newest(now, out, why);
  if (!done && why.empty()) why = bus_problem(*registers_, done.error());
  return done;
}

hal::Status Mpu6050::poll_fifo(hal::Time now, std::vector<msg::ImuSample>& out, std::string& why) {
  why.clear();
  if (cut_) {  // what is in the FIFO begins in the middle of a packet
    const hal::Status emptied = empty_fifo();
    cut_ = !emptied;
    return emptied;
  }
  std::array<std::uint8_t, 2> count_bytes{};
  if (auto done = registers_->read(mpu::kFifoCount, count_bytes); !done) return done;
  const std::size_t count = wire::be16(count_bytes.data()), room = mpu::fifo_bytes(chip_);
  if (count > room) {
    why = registers_->where() + ": says " + std::to_string(count) + " bytes are in a FIFO of " + std::to_string(room);
    return hal::Error{hal::Errc::bad_data, "mpu6050: fifo", static_cast<std::int64_t>(count)};
  }
  if (count + mpu::kPacket > room) {  // full: packets may be cut
    ++overflows_;
    return empty_fifo();
  }
  // While the chip writes a packet, its count may include a part of it: the packet waits for the next poll. The same
  // remainder again and again belongs to a torn packet.
  const std::size_t rest = count % mpu::kPacket;
  odd_ = rest == 0 ? 0 : rest == rest_ ? odd_ + 1 : 1;
  rest_ = rest;
  if (odd_ >= kTorn) {
    odd_ = 0, ++overflows_;
    return empty_fifo();
  }
  if (odd_ > 0) return {};
  const std::size_t packets = count / mpu::kPacket;
  if (packets == 0) return {};
  const auto stamps = clock_.found(packets, now - mpu::filter_delay(config_.chip.filter));
  for (std::size_t at = 0; at < packets;) {
    std::array<std::uint8_t, kMpuPacketsAtOnce * mpu::kPacket> bytes{};
    const std::size_t n = std::min(packets - at, kMpuPacketsAtOnce);
    const std::span part(bytes.data(), n * mpu::kPacket);
    if (auto done = registers_->read(mpu::kFifoData, part); !done) {
      cut_ = true;  // a part of the burst may have left the FIFO
      return done;
    }
    if (ImuWatch::is_dead(part)) {
      why = registers_->where() + ": reads only 0x00 or 0xff (power, pull-ups?)";
      return hal::Error{hal::Errc::bad_data, "mpu6050: dead line"};
    }
    for (std::size_t i = 0; i < n; ++i, ++at) {
      const auto raw =
          mpu::decode_packet(std::span<const std::uint8_t, mpu::kPacket>(part.subspan(i * mpu::kPacket, mpu::kPacket)));
      if (watch_.is_stuck(six(raw), now)) {
        why = registers_->where() + ": repeats the same numbers";
        return hal::Error{hal::Errc::bad_data, "mpu6050: stuck"};
      }
      out.push_back(sample(raw, stamps.at(at)));
    }
  }
  return {};
}

hal::Status Mpu6050::poll_newest(hal::Time now, std::vector<msg::ImuSample>& out, std::string& why) {
  why.clear();
  std::array<std::uint8_t, mpu::kBurst + 1> bytes{};  // status, then the burst: the status is that of the sample
  static_assert(mpu::kIntStatus + 1 == mpu::kAccelX);
  if (auto done = registers_->read(mpu::kIntStatus, bytes); !done) return done;
  const std::span<const std::uint8_t, mpu::kBurst> burst(bytes.data() + 1, mpu::kBurst);
  if (ImuWatch::is_dead(burst)) {
    why = registers_->where() + ": reads only 0x00 or 0xff (power, pull-ups?)";
    return hal::Error{hal::Errc::bad_data, "mpu6050: dead line"};
  }
  if (!(bytes[0] & mpu::kDataReady)) return {};
  const auto raw = mpu::decode_burst(burst);
  if (watch_.is_stuck(six(raw), now)) {
    why = registers_->where() + ": repeats the same numbers";
    return hal::Error{hal::Errc::bad_data, "mpu6050: stuck"};
  }
  out.push_back(sample(raw, clock_.found(1, now - mpu::filter_delay(config_.chip.filter)).first));
  return {};
}

msg::ImuSample Mpu6050::sample(const mpu::Sample& raw, hal::Time stamp) const {
  msg::ImuSample out;
  out.stamp = stamp;
  out.accel_mps2 = mount_.to_base(mpu::accel_mps2(raw, config_.chip));
  out.gyro_radps = mount_.to_base(mpu::gyro_radps(raw, config_.chip));
  return out;
}

}  // namespace sinew::drivers
