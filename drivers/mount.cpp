#include "drivers/mount.hpp"

#include <cmath>

#include "wire/sensor_bytes.hpp"

namespace sinew::drivers {
namespace {

struct Turn {
  double s, c;
  explicit Turn(double deg) {
    const double quarter = deg / 90;
    if (quarter == std::round(quarter)) {  // exactly so, without a rest of 1e-17
      constexpr double kSin[] = {0, 1, 0, -1};
      const auto i = static_cast<unsigned>(static_cast<long>(std::fmod(quarter, 4)) + 4) % 4;
      s = kSin[i], c = kSin[(i + 1) % 4];
    } else {
      s = std::sin(deg * wire::kRadPerDeg), c = std::cos(deg * wire::kRadPerDeg);
    }
  }
};

}  // namespace

Mount::Mount(const MountAngles& a) {
  const Turn x(a.roll_deg), y(a.pitch_deg), z(a.yaw_deg);
  m_ = {z.c * y.c,
        z.c * y.s * x.s - z.s * x.c,
        z.c * y.s * x.c + z.s * x.s,
        z.s * y.c,
        z.s * y.s * x.s + z.c * x.c,
        z.s * y.s * x.c - z.c * x.s,
        -y.s,
        y.c * x.s,
        y.c * x.c};
}

}  // namespace sinew::drivers
