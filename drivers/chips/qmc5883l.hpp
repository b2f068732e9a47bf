#pragma once
#include <memory>

#include "drivers/chips/registers.hpp"
#include "drivers/mount.hpp"
#include "drivers/polled_sensor.hpp"
#include "wire/qmc5883l.hpp"

namespace sinew::drivers {

/// QMC5883L magnetometer on I2C (0x0D). Poll it twice as fast as its rate.
/// Stamps:  the time of reading. Frames: base.
/// Errors:  set_up(): not_found (no answer, another chip), bad_argument, bad_data. poll(): those of the bus; bad_data
///          where the field is beyond the range (a magnet, a motor cable).
class Qmc5883l final : public PolledDevice<msg::MagSample> {
 public:
  Qmc5883l(hal::Os& os, std::unique_ptr<Registers> registers, const wire::qmc5883l::Setup& setup,
           const MountAngles& mount)
      : os_(os), registers_(std::move(registers)), setup_(setup), mount_(mount) {}
  hal::Status set_up(std::string& why) override;
  hal::Status poll(hal::Time now, std::vector<msg::MagSample>& out, std::string& why) override;

 private:
  hal::Os& os_;
  std::unique_ptr<Registers> registers_;
  wire::qmc5883l::Setup setup_;
  Mount mount_;
};

}  // namespace sinew::drivers
