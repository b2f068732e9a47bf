#include "drivers/chips/power_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "drivers/chips/registers.hpp"

namespace sinew::drivers {

using namespace std::chrono_literals;
namespace ina = wire::ina2xx;

namespace {

std::string hex(std::uint16_t word) {
  char text[8];
  std::snprintf(text, sizeof text, "0x%04x", unsigned{word});
  return text;
}

/// As bus_hint(), for a word: nothing drives the lines.
std::string hint(std::uint16_t word) { return word == 0 || word == 0xFFFF ? " (nobody there: wiring, power?)" : ""; }

}  // namespace

hal::Result<std::uint16_t> PowerMonitor::read(std::uint8_t address, std::string& why) {
  auto word = registers_.read(address);
  if (!word) why = bus_problem(registers_.where(), word.error());
  return word;
}

// The INA219 has no identity register: its set-up after a reset identifies it.
hal::Status PowerMonitor::identify(std::string& why) {
  if (config_.chip != ina::Chip::ina226) return {};
  const auto maker = read(ina::kMaker, why);
  if (!maker) return maker.error();
  const auto die = read(ina::kDie, why);
  if (!die) return die.error();
  if (*maker == ina::kMakerTi && ina::is_ina226(*die)) return {};
  why = registers_.where() + ": its ids are " + hex(*maker) + ", " + hex(*die) + "; an INA226 says 0x5449, 0x2260" +
        hint(*maker);
  return hal::Error{hal::Errc::not_found, "ina226: another chip", *maker};
}

hal::Status PowerMonitor::set_up(std::string& why) {
  if (auto done = identify(why); !done) return done;
  const auto put = [&](std::uint16_t value) {
    auto done = registers_.write(ina::kConfig, value);
    if (!done) why = bus_problem(registers_.where(), done.error());
    return done;
  };
  if (auto done = put(ina::kReset); !done) return done;
  os_.sleep_until(os_.now() + 1ms);
  const auto fresh = read(ina::kConfig, why);
  if (!fresh) return fresh.error();
  if (*fresh != chip_.after_reset) {
    why = registers_.where() + ": its set-up after a reset is " + hex(*fresh) + "; an " + chip_.name + " has " +
          hex(chip_.after_reset) + hint(*fresh);
    return hal::Error{hal::Errc::not_found, "ina2xx: another chip", *fresh};
  }
  if (auto done = put(chip_.measuring); !done) return done;
  const auto kept = read(ina::kConfig, why);
  if (!kept) return kept.error();
  if (*kept == chip_.measuring) return {};
  why = bus_problem(registers_.where(), {hal::Errc::bad_data, "ina2xx: set-up", ina::kConfig});
  return hal::Error{hal::Errc::bad_data, "ina2xx: set-up", ina::kConfig};
}

hal::Result<bool> PowerMonitor::is_ready(std::string& why) {
  const auto setup = read(ina::kConfig, why);
  if (!setup) return setup.error();
  if (*setup != chip_.measuring) {
    why = registers_.where() + ": its set-up reads " + hex(*setup) + ", not " + hex(chip_.measuring) +
          (hint(*setup).empty() ? " (it lost its power for a moment?)" : hint(*setup));
    return hal::Error{hal::Errc::bad_data, "ina2xx: set-up", *setup};
  }
  const auto flags = read(chip_.ready_at, why);
  if (!flags) return flags.error();
  return (*flags & chip_.ready) != 0;
}

double PowerMonitor::charge(double voltage_v, double current_a) const {
  if (!config_.cells) return std::numeric_limits<double>::quiet_NaN();
  const BatteryCells& cells = *config_.cells;
  const double hidden_v = cells.resistance_ohm > 0 ? current_a * cells.resistance_ohm : 0;  // NaN stays NaN
  const double cell_v = (voltage_v + hidden_v) / cells.count;
  const double full = (cell_v - cells.empty_v) / (cells.full_v - cells.empty_v);
  return std::isnan(full) ? full : std::clamp(full, 0.0, 1.0);
}

hal::Status PowerMonitor::poll(hal::Time now, std::vector<msg::BatterySample>& out, std::string& why) {
  const auto ready = is_ready(why);
  if (!ready) return ready.error();
  if (!*ready) return {};
  const auto shunt = read(ina::kShunt, why);
  if (!shunt) return shunt.error();
  const auto bus = read(ina::kBus, why);
  if (!bus) return bus.error();
  if (chip_.cleared != chip_.ready_at)
    if (const auto done = read(chip_.cleared, why); !done) return done.error();
  const double voltage_v = ina::bus_v(*bus, config_.chip);
  if (voltage_v > chip_.most_bus_v) {
    why = registers_.where() + ": says " + std::to_string(voltage_v) + " V; the chip measures at most " +
          std::to_string(static_cast<int>(chip_.most_bus_v));
    return hal::Error{hal::Errc::bad_data, "ina2xx: voltage"};
  }
  const double current_a = (config_.reversed ? -1 : 1) * ina::shunt_v(*shunt, config_.chip) / config_.shunt_ohm;
  const hal::Duration half{static_cast<std::int64_t>(chip_.window_ms / 2 * 1e6)};
  out.push_back(
      {.stamp = now - half, .voltage_v = voltage_v, .current_a = current_a, .charge = charge(voltage_v, current_a)});
  return {};
}

}  // namespace sinew::drivers
