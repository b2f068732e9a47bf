#pragma once
#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <mutex>

#include "hal/buses.hpp"

namespace sinew::sim_hil {

/// A chip with 256 registers of eight bits whose address counts up within one read. Reads and writes of single
/// registers can be overridden.
/// Thread:  any; the bus holds lock() while it talks to the chip.
class SimChip {
 public:
  virtual ~SimChip() = default;
  std::unique_lock<std::mutex> lock() { return std::unique_lock(mutex_); }
  void poke(std::uint8_t address, std::uint8_t value) { registers_[address] = value; }
  std::uint8_t peek(std::uint8_t address) const { return registers_[address]; }

  /// What the bus does: under lock().
  virtual void read_from(std::uint8_t first, std::span<std::uint8_t> into);
  virtual void write_to(std::uint8_t first, std::span<const std::uint8_t> values);

 protected:
  virtual std::uint8_t on_read(std::uint8_t address) { return registers_[address]; }
  virtual void on_write(std::uint8_t address, std::uint8_t value) { registers_[address] = value; }
  /// A register with more than one byte behind it: its address does not count up.
  virtual bool is_fifo(std::uint8_t) const { return false; }

 private:
  std::array<std::uint8_t, 256> registers_{};
  std::mutex mutex_;
};

/// What is wrong with a simulated bus.
enum class BusFault : std::uint8_t {
  none,
  no_answer,  // nothing acknowledges
  held_high,  // reads 0xff
  held_low,   // reads 0x00
  errors,     // every transfer fails
  gone        // the adapter was unplugged
};

/// An I2C bus with simulated chips.
class SimI2cBus final : public hal::I2cBus {
 public:
  void attach(std::uint8_t address, std::shared_ptr<SimChip> chip) { chips_[address] = std::move(chip); }
  hal::Status transfer(std::uint8_t address, std::span<const std::uint8_t> write,
                       std::span<std::uint8_t> read) noexcept override;
  std::atomic<BusFault> fault{BusFault::none};
  hal::Tally transfers;
  /// The next longer read fails when the chip has handed over so many bytes, like a read that is not acknowledged
  /// half-way. Negative: no read fails.
  std::atomic<int> cut_next_after{-1};

 private:
  std::map<std::uint8_t, std::shared_ptr<SimChip>> chips_;
};

/// One simulated chip on SPI: bit 7 of the first byte says read.
class SimSpiDevice final : public hal::SpiBus {
 public:
  explicit SimSpiDevice(std::shared_ptr<SimChip> chip) : chip_(std::move(chip)) {}
  hal::Status transfer(std::span<const std::uint8_t> out, std::span<std::uint8_t> in) noexcept override;

 private:
  std::shared_ptr<SimChip> chip_;
};

}  // namespace sinew::sim_hil
