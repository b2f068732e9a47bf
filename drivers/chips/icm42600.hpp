#pragma once
#include <memory>

#include "drivers/chips/imu_watch.hpp"
#include "drivers/chips/registers.hpp"
#include "drivers/mount.hpp"
#include "drivers/polled_sensor.hpp"
#include "drivers/sample_clock.hpp"
#include "wire/icm42600.hpp"

namespace sinew::drivers {

struct Icm42600Config {
  wire::icm42600::Setup chip;  // ranges, rate, FIFO
  MountAngles mount;
  hal::Duration stuck_after = std::chrono::milliseconds(500);  // the same numbers for so long: set up again; 0: never
};

/// ICM-42605, -42688-P and their sisters on I2C or SPI; see Mpu6050, which behaves in the same way.
/// Stamps:  when the chip took the sample; the delay of its filter is not taken off (below 2 ms at 1 kHz).
class Icm42600 final : public PolledDevice<msg::ImuSample> {
 public:
  Icm42600(hal::Os& os, std::unique_ptr<Registers> registers, const Icm42600Config& config);
  hal::Status set_up(std::string& why) override;
  hal::Status poll(hal::Time now, std::vector<msg::ImuSample>& out, std::string& why) override;
  std::uint64_t overflows() const { return overflows_; }
  static hal::Duration period(const Icm42600Config& config);

 private:
  hal::Status poll_fifo(hal::Time now, std::vector<msg::ImuSample>& out, std::string& why);
  hal::Status poll_newest(hal::Time now, std::vector<msg::ImuSample>& out, std::string& why);
  hal::Status deliver(const wire::icm42600::Sample& raw, hal::Time stamp, hal::Time now,
                      std::vector<msg::ImuSample>& out, std::string& why);

  hal::Os& os_;
  std::unique_ptr<Registers> registers_;
  Icm42600Config config_;
  Mount mount_;
  SampleClock clock_;
  ImuWatch watch_;
  std::uint64_t overflows_ = 0;
  bool cut_ = false;  // a burst of the FIFO failed, or its packets made no sense
};

}  // namespace sinew::drivers
