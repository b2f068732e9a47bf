#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "hal/buses.hpp"

namespace sinew::drivers {

/// The registers of a chip on I2C whose registers are words of 16 bits, the highest byte first.
/// Thread:  owner. Errors: as the bus.
class WordRegisters {
 public:
  WordRegisters(std::shared_ptr<hal::I2cBus> bus, std::uint8_t address) : bus_(std::move(bus)), address_(address) {}
  hal::Result<std::uint16_t> read(std::uint8_t address) noexcept;
  hal::Status write(std::uint8_t address, std::uint16_t value) noexcept;
  /// "i2c 0x40": for error texts.
  std::string where() const;

 private:
  std::shared_ptr<hal::I2cBus> bus_;
  std::uint8_t address_;
};

}  // namespace sinew::drivers
