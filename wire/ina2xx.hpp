#pragma once
// Registers of the INA219 and INA226 power monitors: words of 16 bits, the highest byte first. We compute the current
// from the shunt's voltage; the chips' own current and power registers stay off, as they need a calibration and round
// by it.
//
// Source:  TI SBOS448G (INA219) and SBOS547A (INA226), "Register maps" and "Recommended operating conditions".
#include <cstdint>

namespace sinew::wire::ina2xx {

enum class Chip : std::uint8_t { ina219, ina226 };

inline constexpr std::uint8_t kConfig = 0x00, kShunt = 0x01, kBus = 0x02, kPower = 0x03;
inline constexpr std::uint8_t kMask = 0x06, kMaker = 0xFE, kDie = 0xFF;  // INA226 only
inline constexpr std::uint16_t kReset = 0x8000;                          // in kConfig
inline constexpr std::uint16_t kMakerTi = 0x5449;                        // "TI", in kMaker

/// What differs between the two.
struct Facts {
  const char* name;
  std::uint16_t after_reset;       // kConfig
  std::uint16_t measuring;         // kConfig: both voltages all the time, averaged over window_ms
  double window_ms;                // between two values
  double shunt_v, bus_v;           // of one bit
  int bus_shift;                   // bits below the bus voltage
  std::int16_t least, most;        // of the shunt register: here it is full
  double most_bus_v;               // recommended operating conditions
  std::uint8_t ready_at, cleared;  // register with the ready bit, and the one whose reading clears it
  std::uint16_t ready;
};
/// INA219: 32 V and 320 mV full scale, 32 samples of each. INA226: 16 of each, 1.1 ms long; full scale is 81.92 mV.
constexpr Facts facts(Chip chip) {
  if (chip == Chip::ina219)
    return {"INA219", 0x399F, 0x3EEF, 34.04, 10e-6, 4e-3, 3, -32000, 32000, 26, kBus, kPower, 0x0002};
  return {"INA226", 0x4127, 0x4527, 35.2, 2.5e-6, 1.25e-3, 0, INT16_MIN, INT16_MAX, 36, kMask, kMask, 0x0008};
}

/// The chip behind kDie of an INA226: the lowest four bits are its revision.
constexpr bool is_ina226(std::uint16_t die) { return die >> 4 == 0x226; }

/// NaN: beyond the chip's range.
double shunt_v(std::uint16_t word, Chip chip) noexcept;
double bus_v(std::uint16_t word, Chip chip) noexcept;

}  // namespace sinew::wire::ina2xx
