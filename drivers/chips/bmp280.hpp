#pragma once
#include <array>
#include <memory>

#include "drivers/chips/registers.hpp"
#include "drivers/polled_sensor.hpp"
#include "wire/bmp280.hpp"

namespace sinew::drivers {

/// BMP280 or BME280 barometer on I2C (0x76, 0x77) or SPI. Poll it each 40 ms or slower.
/// A chip that has stopped measuring gives no samples: the value in its registers is handed on once.
/// Stamps:  the time of reading, less half of the chip's 44 ms of measuring and waiting.
/// Errors:  set_up(): not_found (no answer, another chip), bad_data (calibration, registers). poll(): those of the bus;
///          bad_data when the pressure is outside the chip's 300 to 1100 hPa; the chip is set up again then.
class Bmp280 final : public PolledDevice<msg::BaroSample> {
 public:
  Bmp280(hal::Os& os, std::unique_ptr<Registers> registers) : os_(os), registers_(std::move(registers)) {}
  hal::Status set_up(std::string& why) override;
  hal::Status poll(hal::Time now, std::vector<msg::BaroSample>& out, std::string& why) override;

 private:
  hal::Os& os_;
  std::unique_ptr<Registers> registers_;
  wire::bmp280::Calibration calibration_;
  std::array<std::uint8_t, wire::bmp280::kBurst> last_{};  // as it was read
};

}  // namespace sinew::drivers
