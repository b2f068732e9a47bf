#include "drivers/chips/bmp280.hpp"

#include <array>
#include <cstdio>
#include <utility>

namespace sinew::drivers {

using namespace std::chrono_literals;
namespace bmp = wire::bmp280;

hal::Status Bmp280::set_up(std::string& why) {
  const auto failed = [&](const hal::Error& e) {
    why = bus_problem(*registers_, e);
    return e;
  };
  const auto id = registers_->read(bmp::kId);
  if (!id) return failed(id.error());
  if (!bmp::name_of(*id)) {
    char hex[8];
    std::snprintf(hex, sizeof hex, "0x%02x", unsigned{*id});
    why = registers_->where() + ": its id is " + hex + "; a BMP280 says 0x58, a BME280 0x60" + bus_hint(*id);
    return hal::Error{hal::Errc::not_found, "bmp280: another chip", *id};
  }
  if (auto done = registers_->write(bmp::kReset, bmp::kResetWord); !done) return failed(done.error());
  os_.sleep_until(os_.now() + 5ms);  // start-up time 2 ms, table 1; then the calibration is copied
  std::array<std::uint8_t, bmp::kCalibrationBytes> bytes{};
  if (auto done = registers_->read(bmp::kCalibration, bytes); !done) return failed(done.error());
  const auto calibration = bmp::decode_calibration(bytes);
  if (!calibration) {
    why = registers_->where() + ": its calibration is empty (power, pull-ups?)";
    return hal::Error{hal::Errc::bad_data, "bmp280: calibration"};
  }
  calibration_ = *calibration;
  last_ = {};
  if (auto done = registers_->write_and_check(bmp::kSetupWrites); !done) return failed(done.error());
  os_.sleep_until(os_.now() + 50ms);  // the first measurement
  return {};
}

hal::Status Bmp280::poll(hal::Time now, std::vector<msg::BaroSample>& out, std::string& why) {
  std::array<std::uint8_t, bmp::kBurst> bytes{};
  if (auto done = registers_->read(bmp::kPressure, bytes); !done) {
    why = bus_problem(*registers_, done.error());
    return done;
  }
  const bmp::Raw raw = bmp::decode_burst(bytes);
  if (!bmp::is_measured(raw)) return {};
  // The chip has no data-ready flag: unchanged registers are the last measurement, read once more. Two measurements
  // with the same 40 bits are rare, as noise moves the lowest bits, and skipping one does no harm.
  if (std::exchange(last_, bytes) == bytes) return {};
  const bmp::Reading reading = bmp::compensate(raw, calibration_);
  if (!(reading.pressure_pa >= 30000 && reading.pressure_pa <= 110000)) {
    why = registers_->where() + ": says " + std::to_string(reading.pressure_pa) +
          " Pa; the chip measures 30000 to 110000";
    return hal::Error{hal::Errc::bad_data, "bmp280: pressure"};
  }
  out.push_back({.stamp = now - 22ms, .pressure_pa = reading.pressure_pa, .temperature_c = reading.temperature_c});
  return {};
}

}  // namespace sinew::drivers
