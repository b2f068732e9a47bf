#pragma once
#include <optional>

#include "control/magnetic_coefficients.hpp"
#include "math/linear.hpp"

namespace sinew::control {

/// Where on the earth, on the WGS 84 ellipsoid. Height above the ellipsoid or the sea: 50 m change the field by 1 nT.
struct GeodeticPoint {
  double latitude_deg = 0, longitude_deg = 0, height_m = 0;
};

/// The main field of the earth by the World Magnetic Model 2025, without what rocks, iron and storms on the sun add.
/// Units:   T. Frames:  local east, north, up at the point.
/// Errors:  the model's own, one sigma: about 140 nT a component; declination 0.26 deg where the horizontal field is
///          20 uT, more near the poles. Storms and iron nearby can add degrees.
/// `year` is a decimal year. Outside of 2025..2030 the coefficients are carried on at their rates:
/// magnetic_model_expired() says so, and the error grows. Nothing where the arguments are not finite, or within 0.1
/// degrees of a pole, where east and north mean nothing. Source:  NCEI and BGS, "The US/UK World Magnetic Model for
/// 2025-2030", equations 4 to 19. Thread:  any.   RT: yes (some 10 us; not for every sample).
std::optional<math::Vec3> earth_field_t(const GeodeticPoint& at, double year);

constexpr bool magnetic_model_expired(double year) { return !(year >= kMagneticEpoch && year < kMagneticExpiry); }

/// Angle from true north to magnetic north, positive to the east. Units: rad.
inline double declination_rad(const math::Vec3& field_enu) { return math::atan2(field_enu.x, field_enu.y); }

}  // namespace sinew::control
