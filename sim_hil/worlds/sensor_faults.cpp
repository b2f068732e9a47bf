#include "sim_hil/worlds/sensor_faults.hpp"

#include <bit>
#include <limits>

namespace sinew::plant {
namespace {

/// Numbers of broken electronics and broken drivers: special values, absurd ones, any bits, zeros, and numbers that
/// could be true.
double garbage_number(math::Random& random) {
  using Limits = std::numeric_limits<double>;
  switch (random.below(9)) {
    case 0:
      return Limits::quiet_NaN();
    case 1:
      return Limits::infinity();
    case 2:
      return -Limits::infinity();
    case 3:
      return 1e300;
    case 4:
      return -1e300;
    case 5:
      return Limits::denorm_min();
    case 6:
      return std::bit_cast<double>(random.next_u64());
    case 7:
      return 0;
    default:
      return random.uniform(-1000, 1000);
  }
}

void scramble(msg::Vec3& v, math::Random& random) {
  v.x = garbage_number(random);
  v.y = garbage_number(random);
  v.z = garbage_number(random);
}

}  // namespace

void scramble(msg::ImuSample& s, math::Random& random) {
  scramble(s.gyro_radps, random);
  scramble(s.accel_mps2, random);
}
void scramble(msg::RangeSample& s, math::Random& random) { s.range_m = garbage_number(random); }
void scramble(msg::BaroSample& s, math::Random& random) {
  s.pressure_pa = garbage_number(random);
  s.temperature_c = garbage_number(random);
}
void scramble(msg::BatterySample& s, math::Random& random) {
  s.voltage_v = garbage_number(random);
  s.current_a = garbage_number(random);
  s.charge = garbage_number(random);
}

void scramble(msg::SolePressure& s, math::Random& random) {
  for (double& force_n : s.force_n) force_n = garbage_number(random);
}

void scramble(msg::JointState& s, math::Random& random) {
  for (std::size_t i = 0; i < s.count; ++i) {
    s.position_rad[i] = garbage_number(random);
    s.velocity_radps[i] = garbage_number(random);
    s.effort_nm[i] = garbage_number(random);
  }
}

void shift(msg::ImuSample& s, double radps) {
  s.gyro_radps.x += radps;
  s.gyro_radps.y += radps;
  s.gyro_radps.z += radps;
}
void shift(msg::RangeSample& s, double m) { s.range_m += m; }
void shift(msg::BaroSample& s, double pa) { s.pressure_pa += pa; }
void shift(msg::BatterySample& s, double v) { s.voltage_v += v; }
void shift(msg::SolePressure& s, double n) {
  for (double& force_n : s.force_n) force_n += n;
}
void shift(msg::JointState& s, double rad) {
  for (std::size_t i = 0; i < s.count; ++i) s.position_rad[i] += rad;
}

}  // namespace sinew::plant
