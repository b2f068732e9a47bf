#pragma once
// The linear inverted pendulum: how a centre of mass at constant height moves over the place where the ground pushes.
// Units:   m, s; one axis at a time.
// Thread:  any.   RT: yes.
// Source:  S. Kajita and others, The 3D linear inverted pendulum mode (IROS 2001); its divergent part ("capture
// point"):
//          J. Pratt and others, Capture point: a step toward humanoid push recovery (Humanoids 2006); planned by it:
//          J. Englsberger, C. Ott, A. Albu-Schaeffer, Three-dimensional bipedal walking control using divergent
//          component of motion (IROS 2013).
#include "math/elementary.hpp"

namespace sinew::motion {

/// A pendulum along one axis. `dcm` = position + speed / omega is the point where the ground would have to push for the
/// mass to come to rest; it runs away from the ground's push, and the mass runs after it.
struct Pendulum {
  double com_m = 0, dcm_m = 0;

  double speed_mps(double omega_radps) const { return omega_radps * (dcm_m - com_m); }
  /// `dt_s` later, while the ground pushes at `cop_m`.
  Pendulum later(double cop_m, double omega_radps, double dt_s) const {
    const double e = math::exp(omega_radps * dt_s);
    const double dcm = cop_m + (dcm_m - cop_m) * e;
    // The mass: from the stable part com - speed / omega, which decays.
    const double stable = cop_m + (2 * com_m - dcm_m - cop_m) / e;
    return {0.5 * (dcm + stable), dcm};
  }
};

/// Where the ground has to push for the dcm to come from here to `wanted_m` in `in_s`, above 0.
inline double cop_for(double dcm_m, double wanted_m, double omega_radps, double in_s) {
  const double e = math::exp(omega_radps * in_s);
  return (dcm_m * e - wanted_m) / (e - 1);
}

/// When the dcm arrives at `wanted_m` if the ground pushes at `cop_m`: s; infinite: never.
inline double time_until(double dcm_m, double wanted_m, double cop_m, double omega_radps) {
  const double ratio = (wanted_m - cop_m) / (dcm_m - cop_m);
  if (!(ratio > 0)) return math::kInf;
  return math::log(ratio) / omega_radps;
}

/// The dcm's distance from the foot that it stands on, towards the other, at the begin of a step of `period_s`, in the
/// walk that repeats itself after two steps: the feet will be `this_m` apart after this step and `next_m` after the
/// next one. From x(k+1) = d(k) - x(k) exp(omega T).
inline double steady_dcm(double this_m, double next_m, double omega_radps, double period_s) {
  const double e = math::exp(omega_radps * period_s);
  return (e * this_m - next_m) / (e * e - 1);
}

}  // namespace sinew::motion
