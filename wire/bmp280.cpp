#include "wire/bmp280.hpp"

#include <limits>

namespace sinew::wire::bmp280 {

const char* name_of(std::uint8_t id) noexcept {
  switch (id) {
    case 0x56:
    case 0x57:
    case 0x58:
      return "BMP280";
    case 0x60:
      return "BME280";
    default:
      return nullptr;
  }
}

std::optional<Calibration> decode_calibration(std::span<const std::uint8_t, kCalibrationBytes> bytes) noexcept {
  const std::uint8_t* at = bytes.data();
  Calibration c{le16(at), le16s(at + 2), le16s(at + 4), le16(at + 6), {}};
  for (std::size_t i = 0; i < c.p2_9.size(); ++i) c.p2_9[i] = le16s(at + 8 + 2 * i);
  if (c.t1 == 0 || c.p1 == 0 || (c.t1 == 0xFFFF && c.p1 == 0xFFFF)) return {};
  return c;
}

Raw decode_burst(std::span<const std::uint8_t, kBurst> b) noexcept {
  return {b[0] << 12 | b[1] << 4 | b[2] >> 4, b[3] << 12 | b[4] << 4 | b[5] >> 4};
}

bool is_measured(const Raw& raw) noexcept { return raw.pressure != 0x80000 && raw.temperature != 0x80000; }

Reading compensate(const Raw& raw, const Calibration& c) noexcept {
  const double t = raw.temperature;
  const double a = (t / 16384.0 - c.t1 / 1024.0) * c.t2;
  const double b = t / 131072.0 - c.t1 / 8192.0;
  const double fine = a + b * b * c.t3;
  const auto p = [&](std::size_t i) { return static_cast<double>(c.p2_9[i - 2]); };

  double x = fine / 2.0 - 64000.0;
  double y = x * x * p(6) / 32768.0 + x * p(5) * 2.0;
  y = y / 4.0 + p(4) * 65536.0;
  x = (p(3) * x * x / 524288.0 + p(2) * x) / 524288.0;
  x = (1.0 + x / 32768.0) * c.p1;
  const double celsius = fine / 5120.0;
  if (x == 0) return {std::numeric_limits<double>::quiet_NaN(), celsius};
  double pressure = (1048576.0 - raw.pressure - y / 4096.0) * 6250.0 / x;
  pressure += (p(9) * pressure * pressure / 2147483648.0 + pressure * p(8) / 32768.0 + p(7)) / 16.0;
  return {pressure, celsius};
}

}  // namespace sinew::wire::bmp280
