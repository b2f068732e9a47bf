#include "control/rotor_allocation.hpp"

#include "control/limits.hpp"

namespace sinew::control {

RotorAllocation allocate(const math::Vec3& torque_nm, double thrust_n, const RotorParams& r) {
  constexpr double kRoll[4] = {-1, 1, 1, -1}, kPitch[4] = {-1, 1, -1, 1}, kYaw[4] = {-1, -1, 1, 1};
  RotorAllocation out;
  const double roll = torque_nm.x / (4 * r.arm_y_m * r.thrust_max_n);
  const double pitch = torque_nm.y / (4 * r.arm_x_m * r.thrust_max_n);
  const double yaw = torque_nm.z / (4 * r.torque_per_thrust_m * r.thrust_max_n);

  const double wanted = thrust_n / (4 * r.thrust_max_n);
  bool fits_as_it_is = true;
  for (std::size_t i = 0; i < 4; ++i) {
    out.command[i] = wanted + kRoll[i] * roll + kPitch[i] * pitch + kYaw[i] * yaw;
    fits_as_it_is = fits_as_it_is && out.command[i] >= r.idle && out.command[i] <= 1;
  }
  out.thrust_n = thrust_n;
  if (fits_as_it_is) return out;

  // Every rotor gets +-roll +-pitch, so the extremes are known without a search.
  const double reach = math::fabs(roll) + math::fabs(pitch), room = 1 - r.idle;
  out.tilt_share = 2 * reach > room ? room / (2 * reach) : 1;
  const double span = reach * out.tilt_share;
  const double base = clamp(wanted, r.idle + span, 1 - span);

  double up = 1 - base, down = base - r.idle;  // what yaw may add and take at the rotors with the least room
  for (int i = 0; i < 4; ++i) {
    const double tilt = (kRoll[i] * roll + kPitch[i] * pitch) * out.tilt_share;
    out.command[static_cast<std::size_t>(i)] = base + tilt;
    const double sign = kYaw[i] * yaw;
    if (sign > 0) up = up < 1 - base - tilt ? up : 1 - base - tilt;
    if (sign < 0) down = down < base + tilt - r.idle ? down : base + tilt - r.idle;
  }
  const double fits = up < down ? up : down, wish = math::fabs(yaw);
  out.yaw_share = wish > fits ? (fits > 0 ? fits / wish : 0) : 1;
  for (std::size_t i = 0; i < 4; ++i) {
    out.command[i] = clamp(out.command[i] + kYaw[i] * yaw * out.yaw_share, r.idle, 1);
  }
  out.thrust_n = 4 * base * r.thrust_max_n;
  return out;
}

}  // namespace sinew::control
