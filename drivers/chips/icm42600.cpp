#include "drivers/chips/icm42600.hpp"

#include <array>
#include <cstdio>

namespace sinew::drivers {

using namespace std::chrono_literals;
namespace icm = wire::icm42600;

namespace {

constexpr std::size_t kIcmPacketsAtOnce = 16;

hal::Error dead_line(const Registers& registers, std::string& why) {
  why = registers.where() + ": reads only 0x00 or 0xff (power, pull-ups?)";
  return {hal::Errc::bad_data, "icm42600: dead line"};
}

}  // namespace

Icm42600::Icm42600(hal::Os& os, std::unique_ptr<Registers> registers, const Icm42600Config& config)
    : os_(os),
      registers_(std::move(registers)),
      config_(config),
      mount_(config.mount),
      clock_(period(config)),
      watch_(config.stuck_after) {}

hal::Duration Icm42600::period(const Icm42600Config& config) {
  return hal::Duration{1'000'000'000 / std::max(1, config.chip.rate_hz)};
}

hal::Status Icm42600::set_up(std::string& why) {
  const auto failed = [&](const hal::Error& e) {
    why = bus_problem(*registers_, e);
    return e;
  };
  if (auto done = registers_->write(icm::kBank, 0); !done) return failed(done.error());
  const auto who = registers_->read(icm::kWhoAmI);
  if (!who) return failed(who.error());
  if (!icm::name_of(*who)) {
    char hex[8];
    std::snprintf(hex, sizeof hex, "0x%02x", unsigned{*who});
    why = registers_->where() + ": answers who-am-i with " + hex + "; an ICM-42605 says 0x42, an ICM-42688-P 0x47" +
          bus_hint(*who);
    return hal::Error{hal::Errc::not_found, "icm42600: another chip", *who};
  }
  const auto writes = icm::setup_writes(config_.chip);
  if (!writes) {
    why =
        "accel_g is 2, 4, 8 or 16; gyro_dps 250, 500, 1000 or 2000; rate_hz 25, 50, 100, 200, 500, 1000, 2000, 4000 or "
        "8000";
    return hal::Error{hal::Errc::bad_argument, "icm42600"};
  }
  if (auto done = registers_->write(icm::kDeviceConfig, icm::kSoftReset); !done) return failed(done.error());
  os_.sleep_until(os_.now() + 2ms);  // DS-000347, DEVICE_CONFIG: wait 1 ms
  if (auto done = registers_->write_and_check(*writes); !done) return failed(done.error());
  os_.sleep_until(os_.now() + 50ms);  // the gyroscope runs 45 ms after it was switched on
  if (config_.chip.fifo)
    if (auto done = registers_->write(icm::kSignalPathReset, icm::kFifoFlush); !done) return failed(done.error());
  clock_ = SampleClock(period(config_));
  watch_.restart();
  cut_ = false;
  return {};
}

hal::Status Icm42600::poll(hal::Time now, std::vector<msg::ImuSample>& out, std::string& why) {
  why.clear();
  hal::Status done = config_.chip.fifo ? poll_fifo(now, out, why) : poll_newest(now, out, why);
  if (!done && why.empty()) why = bus_problem(*registers_, done.error());
  return done;
}

hal::Status Icm42600::poll_fifo(hal::Time now, std::vector<msg::ImuSample>& out, std::string& why) {
  if (cut_) {  // what is in the FIFO begins in the middle of a packet
    clock_.restart();
    const hal::Status flushed = registers_->write(icm::kSignalPathReset, icm::kFifoFlush);
    cut_ = !flushed;
    return flushed;
  }
  std::array<std::uint8_t, 3> head{};  // status and count are adjacent registers
  static_assert(icm::kIntStatus + 1 == icm::kFifoCount);
  if (auto done = registers_->read(icm::kIntStatus, head); !done) return done;
  const std::size_t count = wire::be16(&head[1]);
  // Up to one packet more than the FIFO holds can be on its way.
  if (count > icm::kFifoBytes + icm::kPacket) {
    why = registers_->where() + ": says " + std::to_string(count) + " bytes are in a FIFO of 2048";
    return hal::Error{hal::Errc::bad_data, "icm42600: fifo", static_cast<std::int64_t>(count)};
  }
  if ((head[0] & icm::kFifoFull) && count + icm::kPacket > icm::kFifoBytes) {
    ++overflows_;
    clock_.restart();
    return registers_->write(icm::kSignalPathReset, icm::kFifoFlush);
  }
  const std::size_t packets = count / icm::kPacket;
  if (packets == 0) return {};
  const auto stamps = clock_.found(packets, now);
  for (std::size_t at = 0; at < packets;) {
    std::array<std::uint8_t, kIcmPacketsAtOnce * icm::kPacket> bytes{};
    const std::size_t n = std::min(packets - at, kIcmPacketsAtOnce);
    const std::span part(bytes.data(), n * icm::kPacket);
    cut_ = true;  // until the packets were read and looked right: a part of a failed burst may have left the FIFO
    if (auto done = registers_->read(icm::kFifoData, part); !done) return done;
    if (ImuWatch::is_dead(part)) return dead_line(*registers_, why);
    for (std::size_t i = 0; i < n; ++i, ++at) {
      const auto raw =
          icm::decode_packet(std::span<const std::uint8_t, icm::kPacket>(&part[i * icm::kPacket], icm::kPacket));
      if (!raw) {
        why = registers_->where() + ": the FIFO holds something else than samples";
        return hal::Error{hal::Errc::bad_data, "icm42600: packet"};
      }
      if (auto done = deliver(*raw, stamps.at(at), now, out, why); !done) return done;
    }
    cut_ = false;
  }
  return {};
}

hal::Status Icm42600::poll_newest(hal::Time now, std::vector<msg::ImuSample>& out, std::string& why) {
  constexpr std::size_t kToStatus = icm::kIntStatus - icm::kTemperature;  // one read for sample and status
  std::array<std::uint8_t, kToStatus + 1> bytes{};
  if (auto done = registers_->read(icm::kTemperature, bytes); !done) return done;
  if (ImuWatch::is_dead(std::span(bytes).first<icm::kBurst>())) return dead_line(*registers_, why);
  if (!(bytes[kToStatus] & icm::kDataReady)) return {};
  const auto raw = icm::decode_burst(std::span<const std::uint8_t, icm::kBurst>(bytes.data(), icm::kBurst));
  return deliver(raw, clock_.found(1, now).first, now, out, why);
}

hal::Status Icm42600::deliver(const icm::Sample& raw, hal::Time stamp, hal::Time now, std::vector<msg::ImuSample>& out,
                              std::string& why) {
  if (!icm::is_valid(raw)) return {};  // not started yet
  const std::array<std::int16_t, 6> six{raw.accel[0], raw.accel[1], raw.accel[2],
                                        raw.gyro[0],  raw.gyro[1],  raw.gyro[2]};
  if (watch_.is_stuck(six, now)) {
    why = registers_->where() + ": repeats the same numbers";
    return hal::Error{hal::Errc::bad_data, "icm42600: stuck"};
  }
  msg::ImuSample sample;
  sample.stamp = stamp;
  sample.accel_mps2 = mount_.to_base(icm::accel_mps2(raw, config_.chip));
  sample.gyro_radps = mount_.to_base(icm::gyro_radps(raw, config_.chip));
  out.push_back(sample);
  return {};
}

}  // namespace sinew::drivers
