#pragma once
#include "drivers/polled_sensor.hpp"
#include "drivers/serial/serial_line.hpp"
#include "wire/tfmini.hpp"

namespace sinew::drivers {

/// TFmini, TFmini-S/Plus or TF-Luna range finder on a serial line (115200 8N1), in its standard output format.
/// Stamps:  the time of reading. Nothing in range is NaN, and a sample.
/// Errors:  closed when the line is gone; bad_data when nothing but garbage comes (wrong bit rate, RX on the wrong
/// pin).
class TfMini final : public PolledDevice<msg::RangeSample> {
 public:
  /// `weakest`: echos with less strength are nothing; see wire::decode_tfmini().
  explicit TfMini(SerialOpener opener, std::uint16_t weakest = 100) : line_(std::move(opener)), weakest_(weakest) {}
  hal::Status set_up(std::string& why) override;
  hal::Status poll(hal::Time now, std::vector<msg::RangeSample>& out, std::string& why) override;
  hal::Serial* line() override { return line_.get(); }
  const wire::ScanStats& scan_stats() const { return scanner_.stats(); }

 private:
  SerialLine line_;
  std::uint16_t weakest_;
  wire::TfMiniScanner scanner_;
  std::uint64_t garbage_ = 0;  // skipped bytes when the last good frame came
};

}  // namespace sinew::drivers
