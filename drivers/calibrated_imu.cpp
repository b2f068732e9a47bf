#include "drivers/calibrated_imu.hpp"

#include <cmath>
#include <string>

namespace sinew::drivers {
namespace {

constexpr double kMaxGyroBias_radps = 1, kMaxAccelBias_mps2 = 5;
constexpr double kMinScale = 0.8, kMaxScale = 1.25;

void read_axes(DeviceKeys& keys, const std::string& stem, const char* unit, msg::Vec3& out, double min, double max) {
  keys.read(stem + "_x" + unit, out.x, min, max);
  keys.read(stem + "_y" + unit, out.y, min, max);
  keys.read(stem + "_z" + unit, out.z, min, max);
}

msg::Vec3 corrected(const msg::Vec3& raw, const msg::Vec3& bias, const msg::Vec3& scale,
                    const std::array<double, 9>& r) {
  const double x = (raw.x - bias.x) * scale.x, y = (raw.y - bias.y) * scale.y, z = (raw.z - bias.z) * scale.z;
  return {r[0] * x + r[1] * y + r[2] * z, r[3] * x + r[4] * y + r[5] * z, r[6] * x + r[7] * y + r[8] * z};
}

}  // namespace

ImuCalibration ImuCalibration::read(DeviceKeys& keys) {
  ImuCalibration c;
  read_axes(keys, "gyro_bias", "_radps", c.gyro_bias_radps, -kMaxGyroBias_radps, kMaxGyroBias_radps);
  read_axes(keys, "accel_bias", "_mps2", c.accel_bias_mps2, -kMaxAccelBias_mps2, kMaxAccelBias_mps2);
  read_axes(keys, "gyro_scale", "", c.gyro_scale, kMinScale, kMaxScale);
  read_axes(keys, "accel_scale", "", c.accel_scale, kMinScale, kMaxScale);
  double roll_deg = 0, pitch_deg = 0, yaw_deg = 0;
  keys.read("mount_roll_deg", roll_deg, -180, 180);
  keys.read("mount_pitch_deg", pitch_deg, -180, 180);
  keys.read("mount_yaw_deg", yaw_deg, -180, 180);
  // Right angles, by far the most, are exact.
  const auto sine = [](double deg) {
    return deg == 0 || deg == 180 || deg == -180 ? 0.0
           : deg == 90                           ? 1.0
           : deg == -90                          ? -1.0
                                                 : std::sin(deg * M_PI / 180);
  };
  const auto cosine = [](double deg) {
    return deg == 90 || deg == -90 ? 0.0 : deg == 180 || deg == -180 ? -1.0 : std::cos(deg * M_PI / 180);
  };
  const double sr = sine(roll_deg), cr = cosine(roll_deg), sp = sine(pitch_deg), cp = cosine(pitch_deg),
               sy = sine(yaw_deg), cy = cosine(yaw_deg);
  c.r_base_chip = {cy * cp,
                   cy * sp * sr - sy * cr,
                   cy * sp * cr + sy * sr,
                   sy * cp,
                   sy * sp * sr + cy * cr,
                   sy * sp * cr - cy * sr,
                   -sp,
                   cp * sr,
                   cp * cr};
  return c;
}

hal::Result<bool> CalibratedImu::read(msg::ImuSample& out) noexcept {
  auto got = raw_.read(out);
  if (!got || !*got) return got;
  const ImuCalibration& c = calibration_;
  out.gyro_radps = corrected(out.gyro_radps, c.gyro_bias_radps, c.gyro_scale, c.r_base_chip);
  out.accel_mps2 = corrected(out.accel_mps2, c.accel_bias_mps2, c.accel_scale, c.r_base_chip);
  return got;
}

}  // namespace sinew::drivers
