// For any registers: each result is a number, or reported as none.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "wire/bmp280.hpp"
#include "wire/icm42600.hpp"
#include "wire/ina2xx.hpp"
#include "wire/mpu6050.hpp"
#include "wire/qmc5883l.hpp"

using namespace sinew;

namespace {
bool beyond(const msg::Vec3& v, double most) {
  return !(std::abs(v.x) <= most && std::abs(v.y) <= most && std::abs(v.z) <= most);
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::array<std::uint8_t, 32> r{};
  std::copy_n(data, std::min(size, r.size()), r.begin());
  const std::span<const std::uint8_t, 32> in(r);
  const auto mpu = wire::mpu6050::decode_burst(in.first<14>());
  if (beyond(wire::mpu6050::accel_mps2(mpu, {.accel_g = 16}), 157) || beyond(wire::mpu6050::gyro_radps(mpu, {}), 35))
    std::abort();
  const auto icm = wire::icm42600::decode_packet(in.first<16>());
  if (icm && (beyond(wire::icm42600::accel_mps2(*icm, {.accel_g = 16}), 157) ||
              beyond(wire::icm42600::gyro_radps(*icm, {}), 35)))
    std::abort();
  if (beyond(wire::qmc5883l::field_t(wire::qmc5883l::decode_burst(in.first<7>()), {}), 1.1e-3)) std::abort();
  for (const auto chip : {wire::ina2xx::Chip::ina219, wire::ina2xx::Chip::ina226}) {
    const double shunt_v = wire::ina2xx::shunt_v(wire::be16(in.data()), chip);
    if (std::abs(shunt_v) > 0.32 || !(wire::ina2xx::bus_v(wire::be16(&in[2]), chip) < 82)) std::abort();
  }
  if (const auto c = wire::bmp280::decode_calibration(in.first<24>())) {
    const auto reading = wire::bmp280::compensate(wire::bmp280::decode_burst(in.subspan<24, 6>()), *c);
    if (!std::isfinite(reading.temperature_c)) std::abort();
  }
  return 0;
}
