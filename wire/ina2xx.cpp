#include "wire/ina2xx.hpp"

#include <limits>

namespace sinew::wire::ina2xx {

double shunt_v(std::uint16_t word, Chip chip) noexcept {
  const Facts f = facts(chip);
  const auto count = static_cast<std::int16_t>(word);
  if (count <= f.least || count >= f.most) return std::numeric_limits<double>::quiet_NaN();
  return count * f.shunt_v;
}

double bus_v(std::uint16_t word, Chip chip) noexcept {
  const Facts f = facts(chip);
  return (word >> f.bus_shift) * f.bus_v;
}

}  // namespace sinew::wire::ina2xx
