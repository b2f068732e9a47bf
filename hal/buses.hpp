#pragma once
// Buses and ports below the devices, as drivers use them. All calls are short and run on the driver's own hal thread,
// never in a step.
#include <cstdint>
#include <span>

#include "hal/clock.hpp"
#include "hal/result.hpp"

namespace sinew::hal {

class Wake;

/// An I2C bus. Thread: owner.
/// Errors:  not_found when no device answers (no acknowledge); io with errno; closed when the adapter is gone.
class I2cBus {
 public:
  virtual ~I2cBus() = default;
  /// Writes, then reads with a repeated start; either may be empty. One transfer on the bus.
  virtual Status transfer(std::uint8_t address, std::span<const std::uint8_t> write,
                          std::span<std::uint8_t> read) noexcept = 0;
};

/// One chip select of an SPI bus. Thread: owner. Errors: io with errno; closed.
class SpiBus {
 public:
  virtual ~SpiBus() = default;
  /// Full duplex under one chip select: `in` gets what came while `out` went; same length, or `in` empty.
  virtual Status transfer(std::span<const std::uint8_t> out, std::span<std::uint8_t> in) noexcept = 0;
};

/// A serial line. Thread: one thread may read while another writes.
/// Errors:  closed when the device is gone (unplugged); io with errno.
class Serial {
 public:
  virtual ~Serial() = default;
  /// What has come in, without waiting; 0: nothing.
  virtual Result<std::size_t> read_now(std::span<std::uint8_t> into) noexcept = 0;
  /// Writes as much as there is room for, without waiting; answers how much.
  virtual Result<std::size_t> write_now(std::span<const std::uint8_t> bytes) noexcept = 0;
  virtual Status set_bit_rate(std::uint32_t bits_per_s) noexcept = 0;
  /// Sleeps until something has come in or `deadline` (kNever: no limit). False: the deadline.
  virtual Result<bool> wait_readable(Time deadline) noexcept = 0;
};

/// One line of a GPIO chip. Thread: owner. Errors: not_supported (wrong direction), io, closed.
class Gpio {
 public:
  virtual ~Gpio() = default;
  virtual Result<bool> get() noexcept = 0;
  virtual Status set(bool active) noexcept = 0;
  /// Input lines opened with edges: sleeps until the next edge; answers its time. timeout: no edge by `deadline`.
  virtual Result<Time> wait_edge(Time deadline) noexcept = 0;
};

}  // namespace sinew::hal
