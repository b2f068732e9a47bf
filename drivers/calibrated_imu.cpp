#include "drivers/calibrated_imu.hpp"

#include <memory>
#include <string>

namespace sinew::drivers {
namespace {

constexpr double kMaxGyroBias_radps = 1, kMaxAccelBias_mps2 = 5;
constexpr double kMinScale = 0.8, kMaxScale = 1.25;

void read_axes(DeviceKeys& keys, const std::string& stem, const std::string& unit, msg::Vec3& out, double min,
               double max, const KeyInfo& info) {
  keys.read(stem + "_x" + unit, out.x, min, max, info);
  keys.read(stem + "_y" + unit, out.y, min, max, info);
  keys.read(stem + "_z" + unit, out.z, min, max, info);
}

msg::Vec3 corrected(const msg::Vec3& raw, const msg::Vec3& bias, const msg::Vec3& scale, const Mount& mount) {
  return mount.to_base({(raw.x - bias.x) * scale.x, (raw.y - bias.y) * scale.y, (raw.z - bias.z) * scale.z});
}

}  // namespace

MountAngles read_mount(DeviceKeys& keys) {
  MountAngles angles;
  const KeyInfo info{.unit = "deg",
                     .doc = "how the chip sits: turned by yaw, then pitch, then roll (drivers/mount.hpp)"};
  keys.read("mount_roll_deg", angles.roll_deg, -180, 180, info);
  keys.read("mount_pitch_deg", angles.pitch_deg, -180, 180, info);
  keys.read("mount_yaw_deg", angles.yaw_deg, -180, 180, info);
  return angles;
}

ImuCalibration ImuCalibration::read(DeviceKeys& keys) {
  ImuCalibration c;
  constexpr std::string_view kBias = "of the chip's own axes; `sinew calibrate imu`";
  constexpr std::string_view kScale = "true over measured, less the bias; `sinew calibrate imu --six`";
  read_axes(keys, "gyro_bias", "_radps", c.gyro_bias_radps, -kMaxGyroBias_radps, kMaxGyroBias_radps,
            {.unit = "rad/s", .doc = kBias});
  read_axes(keys, "accel_bias", "_mps2", c.accel_bias_mps2, -kMaxAccelBias_mps2, kMaxAccelBias_mps2,
            {.unit = "m/s^2", .doc = kBias});
  read_axes(keys, "gyro_scale", "", c.gyro_scale, kMinScale, kMaxScale, {.doc = kScale});
  read_axes(keys, "accel_scale", "", c.accel_scale, kMinScale, kMaxScale, {.doc = kScale});
  c.mount = Mount(read_mount(keys));
  return c;
}

hal::Result<bool> CalibratedImu::read(msg::ImuSample& out) noexcept {
  auto got = raw_.read(out);
  if (!got || !*got) return got;
  const ImuCalibration& c = calibration_;
  out.gyro_radps = corrected(out.gyro_radps, c.gyro_bias_radps, c.gyro_scale, c.mount);
  out.accel_mps2 = corrected(out.accel_mps2, c.accel_bias_mps2, c.accel_scale, c.mount);
  return got;
}

OpenedDevice opened_imu(std::unique_ptr<hal::Imu> raw, const ImuCalibration& calibration) {
  struct Both {
    Both(std::unique_ptr<hal::Imu> device, const ImuCalibration& c) : raw(std::move(device)), corrected(*raw, c) {}
    std::unique_ptr<hal::Imu> raw;
    CalibratedImu corrected;
  };
  const auto both = std::make_shared<Both>(std::move(raw), calibration);
  OpenedDevice device;
  device.owner = both;
  device.report = dynamic_cast<const hal::SelfReport*>(both->raw.get());
  device.sensor(hal::SensorKind::imu) = &both->corrected;
  return device;
}

}  // namespace sinew::drivers
