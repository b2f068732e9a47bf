#pragma once
#include <optional>

#include "drivers/chips/word_registers.hpp"
#include "drivers/polled_sensor.hpp"
#include "msg/sensors.hpp"
#include "wire/ina2xx.hpp"

namespace sinew::drivers {

/// Estimates a battery's charge from its voltage alone, by a straight line. That is coarse (a lithium cell's curve is
/// flat in the middle) and right where it counts, at the end.
struct BatteryCells {
  int count = 1;
  double empty_v = 3.5, full_v = 4.2;  // of one cell, without a load
  double resistance_ohm = 0;           // of all cells and wires up to the measuring point: the drop under load
};

struct PowerMonitorConfig {
  wire::ina2xx::Chip chip = wire::ina2xx::Chip::ina226;
  double shunt_ohm = 0.001;
  bool reversed = false;                // the shunt is wired the other way round
  std::optional<BatteryCells> cells{};  // nothing: the charge is not known
};

/// INA219 or INA226 on I2C, between a battery and its load. A new sample each 34 or 35 ms, averaged over as long.
/// voltage_v is the voltage of the chip's bus pin. current_a is NaN when more flows than the shunt lets the chip
/// measure; charge is NaN when the number of cells is not given.
/// Stamps:  the middle of the time averaged over.
/// Errors:  set_up(): not_found (no answer, another chip), bad_data (does not keep its set-up). poll(): those of the
///          bus; bad_data: lines held low or high, a set-up that was forgotten, a voltage that the chip cannot measure.
class PowerMonitor final : public PolledDevice<msg::BatterySample> {
 public:
  PowerMonitor(hal::Os& os, WordRegisters registers, const PowerMonitorConfig& config)
      : os_(os), registers_(std::move(registers)), config_(config), chip_(wire::ina2xx::facts(config.chip)) {}
  hal::Status set_up(std::string& why) override;
  hal::Status poll(hal::Time now, std::vector<msg::BatterySample>& out, std::string& why) override;

 private:
  hal::Status identify(std::string& why);
  hal::Result<bool> is_ready(std::string& why);
  hal::Result<std::uint16_t> read(std::uint8_t address, std::string& why);
  double charge(double voltage_v, double current_a) const;

  hal::Os& os_;
  WordRegisters registers_;
  PowerMonitorConfig config_;
  wire::ina2xx::Facts chip_;
};

}  // namespace sinew::drivers
