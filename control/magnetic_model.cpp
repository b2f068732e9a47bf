#include "control/magnetic_model.hpp"

namespace sinew::control {
namespace {

constexpr double kReferenceRadius_m = 6371200;                         // of the model
constexpr double kMajor_m = 6378137, kFlattening = 1 / 298.257223563;  // WGS 84
constexpr double kDegree = math::kPi / 180;

/// Geocentric latitude and radius of a geodetic point.
struct Geocentric {
  double sin_latitude, cos_latitude, r_m;
  double sin_tilt, cos_tilt;  // of the angle from the geodetic to the geocentric latitude
};

Geocentric geocentric(const GeodeticPoint& at) {
  const math::SinCos geodetic = math::sincos(at.latitude_deg * kDegree);
  const double e2 = kFlattening * (2 - kFlattening);
  const double rc = kMajor_m / math::sqrt(1 - e2 * geodetic.sin * geodetic.sin);
  const double p = (rc + at.height_m) * geodetic.cos, z = (rc * (1 - e2) + at.height_m) * geodetic.sin;
  const double r = math::sqrt(p * p + z * z), s = z / r, c = p / r;
  return {s, c, r, s * geodetic.cos - c * geodetic.sin, c * geodetic.cos + s * geodetic.sin};
}

}  // namespace

std::optional<math::Vec3> earth_field_t(const GeodeticPoint& at, double year) {
  if (!(math::fabs(at.latitude_deg) < 89.9) || !(math::fabs(at.longitude_deg) <= 360) ||
      !(math::fabs(at.height_m) < 1e6) || !(math::fabs(year) < 1e4)) {
    return std::nullopt;
  }
  const Geocentric g = geocentric(at);
  const double x = g.sin_latitude, u = g.cos_latitude;
  const double since = year - kMagneticEpoch;

  // Schmidt semi-normalised associated Legendre functions of sin(latitude), and their derivatives by the latitude.
  constexpr int kSize = kMagneticDegree + 1;
  double p[kSize][kSize] = {}, dp[kSize][kSize] = {};
  p[0][0] = 1;
  for (int n = 1; n < kSize; ++n) {
    for (int m = 0; m <= n; ++m) {
      if (n == m) {
        const double k = n == 1 ? 1 : math::sqrt(1 - 1 / (2.0 * n));
        p[n][n] = k * u * p[n - 1][n - 1];
        dp[n][n] = k * (u * dp[n - 1][n - 1] - x * p[n - 1][n - 1]);
        continue;
      }
      const double root = math::sqrt(double(n * n - m * m));
      const double before = n > 1 ? math::sqrt(double((n - 1) * (n - 1) - m * m)) : 0;
      p[n][m] = ((2 * n - 1) * x * p[n - 1][m] - (n > 1 ? before * p[n - 2][m] : 0)) / root;
      dp[n][m] = ((2 * n - 1) * (x * dp[n - 1][m] + u * p[n - 1][m]) - (n > 1 ? before * dp[n - 2][m] : 0)) / root;
    }
  }
  math::SinCos turn[kSize];
  for (int m = 0; m < kSize; ++m) turn[m] = math::sincos(m * at.longitude_deg * kDegree);

  const double ratio = kReferenceRadius_m / g.r_m;
  double north = 0, east = 0, down = 0, power = ratio * ratio;
  int degree = 0;
  for (const MagneticCoefficient& k : kMagneticCoefficients) {
    if (k.n != degree) {
      degree = k.n;
      power *= ratio;
    }
    const double c = k.g + since * k.g_rate, s = k.h + since * k.h_rate;
    const double along = c * turn[k.m].cos + s * turn[k.m].sin, across = c * turn[k.m].sin - s * turn[k.m].cos;
    north -= power * along * dp[k.n][k.m];
    east += power * k.m * across * p[k.n][k.m] / u;
    down -= power * (k.n + 1) * along * p[k.n][k.m];
  }
  const double geodetic_north = north * g.cos_tilt - down * g.sin_tilt;
  const double geodetic_down = north * g.sin_tilt + down * g.cos_tilt;
  return math::Vec3{east, geodetic_north, -geodetic_down} * 1e-9;
}

}  // namespace sinew::control
