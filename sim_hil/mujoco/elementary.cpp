// The C library's names of elementary functions, in a program that steps MuJoCo's own dynamics.
//
// libmujoco takes these from the dynamic linker, and the C library's have other last bits where a processor has FMA. A
// program that defines them is bound first, so that mj_step() gives the same bytes on every machine of one kind.
// Link the target sinew_exact_mujoco: its object is in the program whether or not somebody calls it.
#include "math/elementary.hpp"

// NOLINTBEGIN(readability-identifier-naming): the C library's
extern "C" {
double sin(double x) noexcept { return sinew::math::sin(x); }
double cos(double x) noexcept { return sinew::math::cos(x); }
double tan(double x) noexcept { return sinew::math::tan(x); }
double asin(double x) noexcept { return sinew::math::asin(x); }
double acos(double x) noexcept { return sinew::math::acos(x); }
double atan2(double y, double x) noexcept { return sinew::math::atan2(y, x); }
double exp(double x) noexcept { return sinew::math::exp(x); }
double log(double x) noexcept { return sinew::math::log(x); }
double pow(double x, double y) noexcept { return sinew::math::pow(x, y); }
void sincos(double x, double* sine, double* cosine) noexcept {
  const sinew::math::SinCos both = sinew::math::sincos(x);
  *sine = both.sin;
  *cosine = both.cos;
}
}
// NOLINTEND(readability-identifier-naming)
