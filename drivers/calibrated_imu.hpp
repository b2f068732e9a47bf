#pragma once

#include "drivers/device_keys.hpp"
#include "drivers/driver.hpp"
#include "drivers/mount.hpp"
#include "hal/device.hpp"

namespace sinew::drivers {

/// mount_roll_deg, mount_pitch_deg, mount_yaw_deg.
MountAngles read_mount(DeviceKeys& keys);

/// How one IMU differs from its datasheet, and how it is mounted: corrected = R * ((raw - bias) * scale), first in the
/// chip's own axes, then turned into the base frame.
struct ImuCalibration {
  msg::Vec3 gyro_bias_radps, accel_bias_mps2;
  msg::Vec3 gyro_scale{1, 1, 1}, accel_scale{1, 1, 1};
  Mount mount;

  /// Keys of an IMU's [device.NAME]: gyro_bias_x_radps .., accel_bias_x_mps2 .., gyro_scale_x .., accel_scale_x ..,
  /// and those of read_mount().
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

/// An IMU with its calibration in front of it, for a board.
OpenedDevice opened_imu(std::unique_ptr<hal::Imu> raw, const ImuCalibration& calibration);

}  // namespace sinew::drivers
