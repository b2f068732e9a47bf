#include "apps/control/stand.hpp"

#include <algorithm>

#include "math/elementary.hpp"

namespace sinew::app {
namespace {

// As in robots/quad/quad.toml.
constexpr math::Vec3 kInertia_kgm2{0.011, 0.0112, 0.020};
constexpr double kArm_m = 0.1202, kThrustMax_n = 6.0, kTorquePerThrust_m = 0.016;
constexpr double kRotorLag_s = 0.02;
constexpr double kDrag_nms = 0.002;  // of the ball joint and the air
constexpr double kGravity_mps2 = 9.81;
constexpr double kLongestMove_s = 0.02, kMove_s = 0.001;

// Which way a rotor's thrust turns the body; order and signs of control::allocate().
constexpr std::array<double, 4> kRoll{-1, 1, 1, -1}, kPitch{-1, 1, -1, 1}, kYaw{-1, -1, 1, 1};

}  // namespace

Stand::Stand(const hal::Clock& clock, double tilt_rad)
    : clock_(clock), last_(clock.now()), q_world_base_(math::Quat::exp({-0.6 * tilt_rad, 0.8 * tilt_rad, 0})) {}

hal::Result<hal::Device*> Stand::open_sensor(hal::SensorKind kind, std::string_view name) {
  if (kind != hal::SensorKind::imu || name != "imu") return hal::Error{hal::Errc::not_found, "the stand has an imu"};
  return static_cast<hal::Device*>(static_cast<hal::Imu*>(this));
}

hal::Result<hal::Actuators*> Stand::actuators(std::string_view name) {
  if (name != "motors") return hal::Error{hal::Errc::not_found, "the stand has motors"};
  return static_cast<hal::Actuators*>(this);
}

hal::Result<bool> Stand::read(msg::ImuSample& out) noexcept {
  const hal::Time now = clock_.now();
  if (now < ready_at()) return false;
  const bool valid = now.ns < valid_until_ns_.load();
  std::array<double, kRotors> command{};
  for (std::size_t i = 0; i < kRotors && valid; ++i) command[i] = command_[i].load(std::memory_order_relaxed);
  double left_s = std::min(msg::seconds(now - last_), kLongestMove_s);
  for (; left_s > 0; left_s -= kMove_s) move(std::min(left_s, kMove_s), command);
  last_ = now;
  out.stamp = now;
  out.gyro_radps = rate_radps_.to<msg::Vec3>();
  // At the joint the IMU measures only the force that holds the body up.
  out.accel_mps2 = q_world_base_.conjugate().rotate({0, 0, kGravity_mps2}).to<msg::Vec3>();
  return true;
}

void Stand::move(double dt_s, const std::array<double, kRotors>& command) noexcept {
  math::Vec3 torque_nm;
  for (std::size_t i = 0; i < kRotors; ++i) {
    thrust_n_[i] += (command[i] * kThrustMax_n - thrust_n_[i]) * std::min(dt_s / kRotorLag_s, 1.0);
    torque_nm += thrust_n_[i] * math::Vec3{kRoll[i] * kArm_m, kPitch[i] * kArm_m, kYaw[i] * kTorquePerThrust_m};
  }
  torque_nm -= rate_radps_ * kDrag_nms;
  const math::Vec3 spin{kInertia_kgm2.x * rate_radps_.x, kInertia_kgm2.y * rate_radps_.y,
                        kInertia_kgm2.z * rate_radps_.z};
  torque_nm -= math::cross(rate_radps_, spin);
  rate_radps_ +=
      dt_s * math::Vec3{torque_nm.x / kInertia_kgm2.x, torque_nm.y / kInertia_kgm2.y, torque_nm.z / kInertia_kgm2.z};
  q_world_base_ = (q_world_base_ * math::Quat::exp(rate_radps_ * dt_s)).normalized();
}

hal::Status Stand::write(const msg::ActuatorCommand& command, hal::Duration lease) noexcept {
  if (command.count < kRotors) return hal::Error{hal::Errc::bad_argument, "four motors", command.count};
  const hal::Time now = clock_.now();
  for (std::size_t i = 0; i < kRotors; ++i)
    command_[i].store(static_cast<float>(command.value[i]), std::memory_order_relaxed);
  valid_until_ns_.store((now + lease).ns);
  if (commands() == 0) first_command_ns_.store(now.ns);
  commands_.store(commands() + 1, std::memory_order_relaxed);
  return {};
}

hal::Status Stand::stop() noexcept {
  valid_until_ns_.store(0);
  return {};
}

double Stand::tilt_rad() const {
  return math::angle_between(math::Quat::between(q_world_base_.rotate({0, 0, 1}), {0, 0, 1}), {});
}

}  // namespace sinew::app
