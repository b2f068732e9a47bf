#include "sim_hil/pitch/robot_io.hpp"

#include <algorithm>

namespace sinew::plant {
namespace {

enum Stream : std::uint32_t { kDrawStream = 0x70697464, kNoiseStream = 0x7069746e };

constexpr double kLeastDelay_ms = 20, kMostDelay_ms = 36;
constexpr double kLeastFriction = 0.6, kMostFriction = 1.0;
constexpr double kGyroMost_radps = 34.9, kAccelMost_mps2 = 157;  // ranges of 2000 degrees/s and 16 g

std::size_t steps_of(double ms) { return static_cast<std::size_t>(math::round(ms * 1e6 / kPitchStepNs)); }

math::Vec3 limited(const math::Vec3& v, double most) {
  return {std::clamp(v.x, -most, most), std::clamp(v.y, -most, most), std::clamp(v.z, -most, most)};
}

}  // namespace

RobotDraw::RobotDraw(const BodyErrors& e, std::uint64_t seed, std::size_t robot) {
  // All numbers are drawn whatever is switched off, so that one error more leaves the others as they were.
  math::Random random(seed, kDrawStream, robot);
  const double delay_ms = random.uniform(kLeastDelay_ms, kMostDelay_ms);
  command_delay_ns = static_cast<std::int64_t>(
      steps_of(math::is_finite(e.command_delay_ms) ? e.command_delay_ms : delay_ms) * kPitchStepNs);
  const double friction = random.uniform(kLeastFriction, kMostFriction);
  sole_friction = math::is_finite(e.sole_friction) ? e.sole_friction : friction;
  for (double& factor : gain) factor = 1 + e.gain_spread * random.uniform(-1, 1);
  for (double& factor : mass) factor = 1 + e.mass_spread * random.uniform(-1, 1);
  for (int i = 0; i < 3; ++i) gyro_bias_radps[i] = e.gyro_bias_radps * random.normal();
  for (int i = 0; i < 3; ++i) accel_bias_mps2[i] = e.accel_bias_mps2 * random.normal();
  for (auto& foot : cell)
    for (double& factor : foot) factor = 1 + e.cell_spread * random.uniform(-1, 1);
  constexpr double kRad = math::kPi / 180;
  for (double& zero : zero_rad) zero = kRad * e.joint_zero_deg * random.normal();
  for (kinematics::Pose& p : sole) {
    const double roll = kRad * e.sole_tilt_deg * random.normal(), pitch = kRad * e.sole_tilt_deg * random.normal();
    p = {{0, 0, 0.001 * e.sole_height_mm * random.normal()}, math::Quat::exp({roll, pitch, 0})};
  }
}

RobotIo::RobotIo(const BodyErrors& errors, const RobotDraw& draw, std::size_t joints, std::uint64_t seed,
                 std::size_t robot)
    : errors_(errors),
      draw_(draw),
      joints_(joints),
      noise_(seed, kNoiseStream, robot),
      command_steps_(std::min(kRing - 1, static_cast<std::size_t>(draw.command_delay_ns / kPitchStepNs))),
      joint_steps_(std::min(kRing - 1, steps_of(errors.joint_delay_ms))),
      imu_steps_(std::min(kRing - 1, steps_of(errors.imu_delay_ms))),
      on_the_way_(kRing),
      imu_(kRing),
      slow_(kRing) {
  sensors_.joints = joints;
}

std::span<const JointDrive> RobotIo::obeyed() {
  on_the_way_[steps_ % kRing] = said_;
  const std::size_t from = steps_ >= command_steps_ ? steps_ - command_steps_ : 0;
  const auto& drive = steps_ >= command_steps_ ? on_the_way_[from % kRing] : on_the_way_[kRing - 1];
  ++steps_;
  obeyed_ = drive;
  for (std::size_t j = 0; j < joints_; ++j)
    if (draw_.zero_rad[j] != 0) obeyed_[j].position_rad -= draw_.zero_rad[j];
  return {obeyed_.data(), joints_};
}

void RobotIo::measure(const Measured& value, std::int64_t now_ns) {
  Imu& imu = imu_[samples_ % kRing];
  imu.stamp_ns = now_ns;
  const auto noisy = [&](const math::Vec3& v, const math::Vec3& bias, double sigma) {
    math::Vec3 out = v + bias;
    for (int i = 0; i < 3; ++i) out[i] += sigma * noise_.normal();
    return out;
  };
  imu.gyro_radps = limited(noisy(value.gyro_radps, draw_.gyro_bias_radps, errors_.gyro_noise_radps), kGyroMost_radps);
  imu.accel_mps2 = limited(noisy(value.accel_mps2, draw_.accel_bias_mps2, errors_.accel_noise_mps2), kAccelMost_mps2);
  Slow& slow = slow_[samples_ % kRing];
  slow.stamp_ns = now_ns;
  std::copy_n(value.joint.begin(), joints_, slow.joint.begin());
  for (std::size_t j = 0; j < joints_; ++j) slow.joint[j].position_rad += draw_.zero_rad[j];
  for (std::size_t foot = 0; foot < 2; ++foot)
    for (std::size_t cell = 0; cell < 4; ++cell)
      slow.cell_n[foot][cell] =
          std::max(0.0, value.cell_n[foot][cell] * draw_.cell[foot][cell] + errors_.cell_noise_n * noise_.normal());

  // Before the first value has arrived the robot has the first one.
  const auto arrived = [&](std::size_t delay) { return (samples_ >= delay ? samples_ - delay : 0) % kRing; };
  const Imu& old_imu = imu_[arrived(imu_steps_)];
  sensors_.imu_stamp_ns = old_imu.stamp_ns;
  sensors_.gyro_radps = old_imu.gyro_radps, sensors_.accel_mps2 = old_imu.accel_mps2;
  const Slow& old = slow_[arrived(joint_steps_)];
  sensors_.joints_stamp_ns = sensors_.cells_stamp_ns = old.stamp_ns;
  std::copy_n(old.joint.begin(), joints_, sensors_.joint.begin());
  sensors_.cell_n = old.cell_n;
  ++samples_;
}

}  // namespace sinew::plant
