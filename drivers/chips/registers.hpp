#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "hal/buses.hpp"
#include "wire/sensor_bytes.hpp"

namespace sinew::drivers {

/// The registers of one chip, on I2C or SPI. Addresses count up within one read.
/// Thread:  owner. Errors: as the bus.
class Registers {
 public:
  static constexpr std::size_t kMostBytes = 512;  // in one read
  virtual ~Registers() = default;
  virtual hal::Status read(std::uint8_t first, std::span<std::uint8_t> into) noexcept = 0;
  virtual hal::Status write(std::uint8_t address, std::uint8_t value) noexcept = 0;
  /// "i2c 0x68", "spi": for error texts.
  virtual std::string where() const = 0;
  virtual bool is_spi() const noexcept { return false; }

  hal::Result<std::uint8_t> read(std::uint8_t address) noexcept {
    std::uint8_t value = 0;
    if (auto done = read(address, {&value, 1}); !done) return done.error();
    return value;
  }
  /// Writes all, then reads all back: a chip that does not keep the values is not set up.
  /// Errors:  bad_data with the address of the register as detail.
  hal::Status write_and_check(std::span<const wire::RegisterWrite> writes) noexcept;
};

class I2cRegisters final : public Registers {
 public:
  I2cRegisters(std::shared_ptr<hal::I2cBus> bus, std::uint8_t address) : bus_(std::move(bus)), address_(address) {}
  using Registers::read;
  hal::Status read(std::uint8_t first, std::span<std::uint8_t> into) noexcept override;
  hal::Status write(std::uint8_t address, std::uint8_t value) noexcept override;
  std::string where() const override;

 private:
  std::shared_ptr<hal::I2cBus> bus_;
  std::uint8_t address_;
};

/// Bit 7 of the first byte says read, as in InvenSense's and Bosch's chips.
class SpiRegisters final : public Registers {
 public:
  explicit SpiRegisters(std::shared_ptr<hal::SpiBus> bus) : bus_(std::move(bus)) {}
  using Registers::read;
  hal::Status read(std::uint8_t first, std::span<std::uint8_t> into) noexcept override;
  hal::Status write(std::uint8_t address, std::uint8_t value) noexcept override;
  std::string where() const override { return "spi"; }
  bool is_spi() const noexcept override { return true; }

 private:
  std::shared_ptr<hal::SpiBus> bus_;
  std::array<std::uint8_t, kMostBytes + 1> out_{}, in_{};
};

/// A hint for errors: 0x00 and 0xFF may mean that nothing drives the line. Empty: another value.
std::string bus_hint(std::uint8_t value);
/// "i2c 0x68: no answer", "spi: input/output error (errno 5)".
std::string bus_problem(const std::string& where, const hal::Error& error);
inline std::string bus_problem(const Registers& registers, const hal::Error& error) {
  return bus_problem(registers.where(), error);
}

}  // namespace sinew::drivers
