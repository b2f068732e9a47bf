#pragma once
#include <optional>

#include "drivers/polled_sensor.hpp"
#include "drivers/serial/serial_line.hpp"
#include "wire/nmea.hpp"
#include "wire/sensor_bytes.hpp"
#include "wire/ubx.hpp"

namespace sinew::drivers {

struct GnssConfig {
  bool configure_ubx = false;  // asks a u-blox receiver for NAV-PVT at this period
  std::uint16_t period_ms = 200;
  hal::Duration delay{};          // from the solution's instant to its arrival: the receiver's manual
  double error_per_hdop_m = 2.5;  // NMEA tells no accuracy: one sigma is this times the dilution
};

/// A satellite receiver on a serial line: NMEA (GGA with RMC, GSA, VTG) or UBX (NAV-PVT, preferred when it comes).
/// Stamps:  the time of arrival, less `delay`. Without a fix the position is NaN, and a sample.
/// Errors:  closed when the line is gone; bad_data when nothing but garbage comes (wrong bit rate),
///          or the same instant again and again. A sentence or a solution that is repeated is dropped.
class GnssReceiver final : public PolledDevice<msg::GnssSample> {
 public:
  GnssReceiver(SerialOpener opener, const GnssConfig& config) : line_(std::move(opener)), config_(config) {}
  hal::Status set_up(std::string& why) override;
  hal::Status poll(hal::Time now, std::vector<msg::GnssSample>& out, std::string& why) override;
  hal::Serial* line() override { return line_.get(); }

 private:
  /// One of UBX; the same instant twice is one solution.
  void on_solution(const wire::UbxPvt& pvt, hal::Time now, std::vector<msg::GnssSample>& out);
  void on_sentence(const wire::NmeaSentence& s, hal::Time now, std::vector<msg::GnssSample>& out);
  /// One instant's sentences as a sample.
  void flush(hal::Time now, std::vector<msg::GnssSample>& out);
  msg::GnssSample combined() const;

  SerialLine line_;
  GnssConfig config_;
  wire::NmeaScanner nmea_;
  wire::UbxScanner ubx_;
  std::optional<wire::NmeaGga> gga_;
  std::optional<wire::NmeaRmc> rmc_;
  std::optional<wire::NmeaGsa> gsa_;           // of the newest instant that had one
  hal::Time came_in_;                          // arrival of the first sentence of this instant
  std::optional<hal::Time> pvt_;               // when UBX spoke last
  double told_s_ = -1;                         // UTC of the instant that became a sample last
  std::optional<std::uint32_t> told_week_ms_;  // UBX: its time of week, when it had a position
  hal::Time told_at_;                          // and when it did
  bool repeats_ = false;                       // only that instant comes, again and again
  std::uint64_t bytes_ = 0;                    // since the last frame of either kind
};

}  // namespace sinew::drivers
