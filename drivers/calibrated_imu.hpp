#pragma once
#include <array>

#include "drivers/device_keys.hpp"
#include "hal/device.hpp"

namespace sinew::drivers {

/// What one IMU differs in from its datasheet, and how it is mounted: corrected = R * ((raw - bias) * scale), first in
/// the chip's own axes, then turned into the base frame.
struct ImuCalibration {
  msg::Vec3 gyro_bias_radps, accel_bias_mps2;
  msg::Vec3 gyro_scale{1, 1, 1}, accel_scale{1, 1, 1};
  std::array<double, 9> r_base_chip{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major

  /// Keys of an IMU's [device.NAME]: gyro_bias_x_radps .., accel_bias_x_mps2 .., gyro_scale_x .., accel_scale_x ..,
  /// mount_roll_deg, mount_pitch_deg, mount_yaw_deg (chip seen from the base, applied as yaw, pitch, roll).
  static ImuCalibration read(DeviceKeys& keys);
};

/// Another IMU, corrected. Thread, RT and errors: those of the other.
class CalibratedImu final : public hal::Imu {
 public:
  CalibratedImu(hal::Imu& raw, const ImuCalibration& calibration) : raw_(raw), calibration_(calibration) {}
  hal::Result<bool> read(msg::ImuSample& out) noexcept override;
  hal::Time ready_at() const noexcept override { return raw_.ready_at(); }
  void set_wake(hal::Wake* wake) noexcept override { raw_.set_wake(wake); }

 private:
  hal::Imu& raw_;
  const ImuCalibration calibration_;
};

}  // namespace sinew::drivers
