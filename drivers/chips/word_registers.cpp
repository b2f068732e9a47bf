#include "drivers/chips/word_registers.hpp"

#include <array>
#include <cstdio>

#include "wire/sensor_bytes.hpp"

namespace sinew::drivers {

hal::Result<std::uint16_t> WordRegisters::read(std::uint8_t address) noexcept {
  std::array<std::uint8_t, 2> word{};
  if (auto done = bus_->transfer(address_, {&address, 1}, word); !done) return done.error();
  return wire::be16(word.data());
}

hal::Status WordRegisters::write(std::uint8_t address, std::uint16_t value) noexcept {
  const std::uint8_t bytes[] = {address, static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)};
  return bus_->transfer(address_, bytes, {});
}

std::string WordRegisters::where() const {
  char text[16];
  std::snprintf(text, sizeof text, "i2c 0x%02x", unsigned{address_});
  return text;
}

}  // namespace sinew::drivers
