#pragma once
#include <deque>

#include "msg/sensors.hpp"
#include "sim_hil/wire/sim_chip.hpp"

namespace sinew::sim_hil {

/// An MPU-6050 (or 6500, 9250 by its identity) fed with samples in the chip's axes; the driver sets the ranges. Asleep
/// after power-on, like the chip; the FIFO runs over when nobody reads it.
class SimMpu6050 final : public SimChip {
 public:
  explicit SimMpu6050(std::uint8_t who_am_i = 0x68) : who_am_i_(who_am_i) { reset(); }
  /// Takes lock().
  void measure(const msg::ImuSample& sample);
  std::size_t fifo_size() const { return fifo_.size(); }
  /// Resets seen: an independent count of the driver's set-ups.
  int resets() const { return resets_; }

 private:
  std::uint8_t on_read(std::uint8_t address) override;
  void on_write(std::uint8_t address, std::uint8_t value) override;
  bool is_fifo(std::uint8_t address) const override;
  void reset();

  std::uint8_t who_am_i_;
  std::deque<std::uint8_t> fifo_;
  int resets_ = 0;
};

/// An ICM-42688-P, in the same way.
class SimIcm42600 final : public SimChip {
 public:
  explicit SimIcm42600(std::uint8_t who_am_i = 0x47) : who_am_i_(who_am_i) { reset(); }
  void measure(const msg::ImuSample& sample);
  int resets() const { return resets_; }

 private:
  std::uint8_t on_read(std::uint8_t address) override;
  void on_write(std::uint8_t address, std::uint8_t value) override;
  bool is_fifo(std::uint8_t address) const override;
  void reset();

  std::uint8_t who_am_i_;
  std::deque<std::uint8_t> fifo_;
  int resets_ = 0;
};

}  // namespace sinew::sim_hil
