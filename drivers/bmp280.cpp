#include "drivers/bmp280.hpp"

#include <array>
#include <cstdio>

namespace sinew::drivers {

using namespace std::chrono_literals;
namespace chip = wire::bmp280;

hal::Status Bmp280::set_up(std::string& why) {
  const auto failed = [&](const hal::Error& e) {
    why = bus_problem(*registers_, e);
    return e;
  };
  const auto id = registers_->read(chip::kId);
  if (!id) return failed(id.error());
  if (!chip::name_of(*id)) {
    char hex[8];
    std::snprintf(hex, sizeof hex, "0x%02x", unsigned{*id});
    why = registers_->where() + ": its id is " + hex + "; a BMP280 says 0x58, a BME280 0x60";
    return hal::Error{hal::Errc::not_found, "bmp280: another chip", *id};
  }
  if (auto done = registers_->write(chip::kReset, chip::kResetWord); !done) return failed(done.error());
  os_.sleep_until(os_.now() + 5ms);  // start-up time 2 ms, table 1; then the calibration is copied
  std::array<std::uint8_t, chip::kCalibrationBytes> bytes{};
  if (auto done = registers_->read(chip::kCalibration, bytes); !done) return failed(done.error());
  const auto calibration = chip::decode_calibration(bytes);
  if (!calibration) {
    why = registers_->where() + ": its calibration is empty (power, pull-ups?)";
    return hal::Error{hal::Errc::bad_data, "bmp280: calibration"};
  }
  calibration_ = *calibration;
  last_ = {};
  if (auto done = registers_->write_and_check(chip::kSetupWrites); !done) return failed(done.error());
  os_.sleep_until(os_.now() + 50ms);  // the first measurement
  return {};
}

hal::Status Bmp280::poll(hal::Time now, std::vector<msg::BaroSample>& out, std::string& why) {
  std::array<std::uint8_t, chip::kBurst> bytes{};
  if (auto done = registers_->read(chip::kPressure, bytes); !done) {
    why = bus_problem(*registers_, done.error());
    return done;
  }
  // It measures at its own pace, slower than it is asked at times: what it said before is no new measurement. Of two
  // real ones the lowest bits differ by noise, and where they should not for once, a sample of 25 a second is missing.
  if (bytes == last_) return {};
  last_ = bytes;
  const chip::Raw raw = chip::decode_burst(bytes);
  if (!chip::is_measured(raw)) return {};
  const chip::Reading reading = chip::compensate(raw, calibration_);
  if (!(reading.pressure_pa >= 30000 && reading.pressure_pa <= 110000)) {
    why = registers_->where() + ": says " + std::to_string(reading.pressure_pa) +
          " Pa; the chip measures 30000 to 110000";
    return hal::Error{hal::Errc::bad_data, "bmp280: pressure"};
  }
  out.push_back({.stamp = now - 22ms, .pressure_pa = reading.pressure_pa, .temperature_c = reading.temperature_c});
  return {};
}

}  // namespace sinew::drivers
