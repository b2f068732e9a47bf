#include "sim_hil/wire/sim_power_monitor.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sim_hil {

namespace chip = wire::ina2xx;

void SimPowerMonitor::reset() {
  words_.clear();
  words_[chip::kConfig] = chip::facts(chip_).after_reset;
  if (chip_ != chip::Chip::ina226) return;
  words_[chip::kMaker] = chip::kMakerTi;
  words_[chip::kDie] = 0x2260;
}

void SimPowerMonitor::power_cycle() {
  const auto held = lock();
  reset();
}

std::uint16_t SimPowerMonitor::word(std::uint8_t address) const {
  const auto it = words_.find(address);
  return it == words_.end() ? std::uint16_t{0} : it->second;
}

void SimPowerMonitor::measure(double bus_v, double shunt_v) {
  const auto held = lock();
  const chip::Facts f = chip::facts(chip_);
  const long count = std::clamp(std::lround(shunt_v / f.shunt_v), long{f.least}, long{f.most});
  words_[chip::kShunt] = static_cast<std::uint16_t>(static_cast<std::int16_t>(count));
  words_[chip::kBus] = static_cast<std::uint16_t>(static_cast<unsigned>(std::round(bus_v / f.bus_v)) << f.bus_shift);
  words_[f.ready_at] |= f.ready;
}

void SimPowerMonitor::read_from(std::uint8_t first, std::span<std::uint8_t> into) {
  const std::uint16_t value = word(first);
  for (std::size_t i = 0; i < into.size(); ++i)
    into[i] = static_cast<std::uint8_t>(i % 2 == 0 ? value >> 8 : value & 0xFF);
  const chip::Facts f = chip::facts(chip_);
  if (first == f.cleared) words_[f.ready_at] &= static_cast<std::uint16_t>(~f.ready);
}

void SimPowerMonitor::write_to(std::uint8_t first, std::span<const std::uint8_t> values) {
  if (values.size() < 2) return;
  const auto value = static_cast<std::uint16_t>(values[0] << 8 | values[1]);
  if (first == chip::kConfig && (value & chip::kReset) != 0) return reset();
  words_[first] = value;
}

}  // namespace sinew::sim_hil
