#pragma once
#include <memory>

#include "drivers/chips/imu_watch.hpp"
#include "drivers/chips/registers.hpp"
#include "drivers/mount.hpp"
#include "drivers/polled_sensor.hpp"
#include "drivers/sample_clock.hpp"
#include "wire/mpu6050.hpp"

namespace sinew::drivers {

struct Mpu6050Config {
  wire::mpu6050::Setup chip;  // ranges, filter, rate, FIFO
  MountAngles mount;
  hal::Duration stuck_after = std::chrono::milliseconds(500);  // the same numbers for so long: set up again; 0: never
};

/// MPU-6000/6050/6500/9250 on I2C or SPI (SPI: not the 6050). With the FIFO every sample is fetched in order; without
/// it each poll takes the newest one. After a burst that failed half-way the FIFO is emptied: samples are lost, and no
/// sample mixes halves of two. An adapter that only speaks SMBus needs fifo = false.
/// Stamps:  when the chip took the sample, less the delay of its filter.
/// Errors:  set_up(): not_found (no answer, another chip), bad_argument (a set-up that the chip does not have),
///          bad_data (registers do not keep what is written). poll(): those of the bus; bad_data: lines held low or
///          high, stuck.
class Mpu6050 final : public PolledDevice<msg::ImuSample> {
 public:
  Mpu6050(hal::Os& os, std::unique_ptr<Registers> registers, const Mpu6050Config& config);
  hal::Status set_up(std::string& why) override;
  hal::Status poll(hal::Time now, std::vector<msg::ImuSample>& out, std::string& why) override;
  /// Times that the FIFO ran over, or held parts of packets, and was emptied.
  std::uint64_t overflows() const { return overflows_; }
  /// A sensible PollOptions::period.
  static hal::Duration period(const Mpu6050Config& config);

 private:
  hal::Status poll_fifo(hal::Time now, std::vector<msg::ImuSample>& out, std::string& why);
  hal::Status poll_newest(hal::Time now, std::vector<msg::ImuSample>& out, std::string& why);
  hal::Status empty_fifo();
  msg::ImuSample sample(const wire::mpu6050::Sample& raw, hal::Time stamp) const;

  hal::Os& os_;
  std::unique_ptr<Registers> registers_;
  Mpu6050Config config_;
  Mount mount_;
  wire::mpu6050::Chip chip_{};
  SampleClock clock_;
  ImuWatch watch_;
  std::uint64_t overflows_ = 0;
  bool cut_ = false;  // a burst of the FIFO failed
  static constexpr int kTorn = 5;
  int odd_ = 0;  // polls in a row that found the same part of a packet
  std::size_t rest_ = 0;
};

}  // namespace sinew::drivers
