#pragma once
#include "drivers/polled_sensor.hpp"
#include "drivers/serial/serial_line.hpp"
#include "wire/crsf.hpp"
#include "wire/sbus.hpp"

namespace sinew::drivers {

enum class RcProtocol : std::uint8_t { sbus, crsf };

struct RcConfig {
  RcProtocol protocol = RcProtocol::crsf;
  hal::Duration lost_after = std::chrono::milliseconds(200);  // without a frame: the link is lost
};

/// A pilot's receiver on a serial line: SBUS (100000 8E2, inverted by hardware) or CRSF (420000 8N1).
/// A lost link (the receiver says so, its link quality is 0, or nothing comes for `lost_after`) is a sample with `lost`
/// = 1 and all channels 0, once per `lost_after`: readers learn of the loss without a clock of their own.
/// Stamps:  the time of reading.
/// Errors:  closed when the line is gone. Garbage moves no stick; it only makes the link lost.
class RcReceiver final : public PolledDevice<msg::RcSample> {
 public:
  RcReceiver(SerialOpener opener, const RcConfig& config) : line_(std::move(opener)), config_(config) {}
  hal::Status set_up(std::string& why) override;
  hal::Status poll(hal::Time now, std::vector<msg::RcSample>& out, std::string& why) override;
  hal::Serial* line() override { return line_.get(); }
  /// Bytes that were in no frame.
  std::uint64_t garbage() const { return sbus_.stats().skipped_bytes + crsf_.stats().skipped_bytes; }

 private:
  void on_sbus(const wire::SbusFrame& frame, hal::Time now, std::vector<msg::RcSample>& out);
  void on_crsf(std::span<const std::uint8_t> frame, hal::Time now, std::vector<msg::RcSample>& out);
  msg::RcSample sample(const wire::RcCounts& counts, hal::Time now) const;
  msg::RcSample lost(hal::Time now) const;

  SerialLine line_;
  RcConfig config_;
  wire::SbusScanner sbus_;
  wire::CrsfScanner crsf_;
  double quality_ = 0, rssi_dbm_ = 0;
  hal::Time last_byte_, last_told_;
  bool begun_ = false;
};

}  // namespace sinew::drivers
