#pragma once
// The iron of a vehicle by the readings of its magnetometer while it was turned about: hard iron (magnetised, turns
// with the vehicle) and soft iron (bends the field that is there).
//
//   std::vector<math::Vec3> readings = ...;                      // T, base axes, in as many directions as can be had
//   const IronFit fit = fit_iron(readings, {.field_t = 48e-6});  // where the field's strength is known
//   if (fit.problem.empty()) h = fit.soft * (reading - fit.hard_t);
//
// Frames:  base. Units: T.   Thread:  any.   RT: no, it allocates.
#include <array>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "math/linear.hpp"

namespace sinew::identify {

struct IronFitOptions {
  double field_t = 0;   // strength of the field that turned, of which nothing but the direction changed; 0: not known
  double open_deg = 2;  // a direction that stays open by more than this is not shown
  std::size_t held_out_each = 5;  // each so many-th block of readings is predicted by a fit of the others; 0: none
};

/// field = soft (reading - hard), `soft` symmetric: hard x y z, then soft xx yy zz xy xz yz.
inline constexpr std::size_t kIronNumbers = 9;
struct IronEstimate {
  double value = 0;
  double half_width = 0;  // of the 95 % interval
};

struct IronFit {
  std::string problem;  // empty: all that follows is there
  math::Vec3 hard_t;
  math::Mat3 soft;
  std::array<IronEstimate, kIronNumbers> estimates{};
  double field_t = 0;  // as told, or the readings' own: `soft` then keeps volumes (its determinant is 1)
  std::size_t readings = 0;
  double rms_before_t = 0;  // of the strength's difference from `field_t`, without and with the fit
  double rms_t = 0;
  double held_out_rms_t = 0;  // in readings that were not fitted; NaN: none were held out
  double worst_deg = 0;       // 95 %: the corrected direction that is known least
  math::Vec3 worst;           // unit vector: there the field has to come from for it to be known better
  bool shown = true;          // false: worst_deg is above open_deg, or the field came from too few directions
};

/// Start: the ellipsoid in closed form, weighted so that each part of the sphere counts the same; then Levenberg and
/// Marquardt on the strength's error, errors beyond 2.5 sigmas counting linearly. The intervals hold for errors of
/// neighbouring readings that have something in common: the readings of one part of the sphere count as one there.
/// A magnetometer that is turned against the base leaves the strength as it is: that part of soft iron is not seen.
/// Errors:  `problem`: fewer than 30 readings, numbers that are not finite, readings in a plane or a point, or no
///          ellipsoid.
/// Source:  J. Vasconcelos et al., Geometric approach to strapdown magnetometer calibration in sensor frame, IEEE
///          Transactions on Aerospace and Electronic Systems 47 (2011).
IronFit fit_iron(std::span<const math::Vec3> readings, const IronFitOptions& options = {});

}  // namespace sinew::identify
