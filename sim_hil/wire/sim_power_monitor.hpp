#pragma once
#include <map>

#include "sim_hil/wire/sim_chip.hpp"
#include "wire/ina2xx.hpp"

namespace sinew::sim_hil {

/// An INA219 or INA226: 16-bit words behind a pointer that does not count up, a ready flag that reading clears, and a
/// set-up that a reset clears.
class SimPowerMonitor final : public SimChip {
 public:
  explicit SimPowerMonitor(wire::ina2xx::Chip chip) : chip_(chip) { reset(); }
  /// A new conversion. Takes lock().
  void measure(double bus_v, double shunt_v);
  /// Loses its power for a moment. Takes lock().
  void power_cycle();
  std::uint16_t word(std::uint8_t address) const;
  void set_word(std::uint8_t address, std::uint16_t value) { words_[address] = value; }

  void read_from(std::uint8_t first, std::span<std::uint8_t> into) override;
  void write_to(std::uint8_t first, std::span<const std::uint8_t> values) override;

 private:
  void reset();
  wire::ina2xx::Chip chip_;
  std::map<std::uint8_t, std::uint16_t> words_;
};

}  // namespace sinew::sim_hil
