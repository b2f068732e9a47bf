#pragma once
#include "control/magnetic_model.hpp"

namespace sinew::control {

/// East, north, up around a place on the earth.
/// Frames:  x east, y north, z up; z is the difference of heights above the sea, so the plane follows the curved earth.
///          Distances are exact at the origin; 10 km away they are off by about 1e-6 of the distance squared over the
///          earth's radius (some metres in east-west by the changing latitude are accounted for).
/// Source:  WGS 84: radii of curvature of the meridian and of the prime vertical at the middle latitude.
class LocalFrame {
 public:
  /// `p_world_m`: where in the world this place is.
  void set(const GeodeticPoint& place, const math::Vec3& p_world_m) {
    place_ = place;
    p_ = p_world_m;
    known_ = 1;
  }
  bool known() const { return known_ != 0; }
  math::Vec3 to_world(const GeodeticPoint& at) const {
    const double middle = (0.5 * kDegree) * (at.latitude_deg + place_.latitude_deg);
    const Radii r = radii(middle);
    const double east_rad = math::wrap_pi((at.longitude_deg - place_.longitude_deg) * kDegree);
    return {p_.x + east_rad * (r.across_m + place_.height_m) * math::cos(middle),
            p_.y + (at.latitude_deg - place_.latitude_deg) * kDegree * (r.along_m + place_.height_m),
            p_.z + at.height_m - place_.height_m};
  }
  /// The place of the world's origin.
  GeodeticPoint origin() const {
    const Radii r = radii(place_.latitude_deg * kDegree);
    const double latitude = place_.latitude_deg - p_.y / (r.along_m + place_.height_m) / kDegree;
    const double around_m = (r.across_m + place_.height_m) * math::cos(place_.latitude_deg * kDegree);
    return {latitude, place_.longitude_deg - p_.x / around_m / kDegree, place_.height_m - p_.z};
  }
  /// The world turned about its origin: the place lies elsewhere in it.
  void turn_world(double angle_rad) { p_ = math::Quat::from_axis_angle({0, 0, 1}, angle_rad).rotate(p_); }

 private:
  static constexpr double kDegree = math::kPi / 180;
  struct Radii {
    double along_m, across_m;  // of the meridian; of the prime vertical
  };
  static Radii radii(double latitude_rad) {
    constexpr double kMajor_m = 6378137, kE2 = (2 - 1 / 298.257223563) / 298.257223563;
    const double s = math::sin(latitude_rad), w = math::sqrt(1 - kE2 * s * s);
    return {kMajor_m * (1 - kE2) / (w * w * w), kMajor_m / w};
  }

  GeodeticPoint place_;
  math::Vec3 p_;
  std::uint32_t known_ = 0, reserved_ = 0;
};

}  // namespace sinew::control
