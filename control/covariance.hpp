#pragma once
#include <array>
#include <cstdint>

#include "math/linear.hpp"

namespace sinew::control {

/// Where each error state sits in the covariance and in a correction. All in world axes but the biases and the body's
/// magnetic field, which are in base axes. The first kErrInertial are always there; the field of the earth, the field
/// of the body and the wind (east, north) are the surroundings, estimated outdoors only
/// (Covariance::open_surroundings()).
enum ErrorIndex : int {
  kErrP = 0,
  kErrV = 3,
  kErrTheta = 6,
  kErrGyroBias = 9,
  kErrAccelBias = 12,
  kErrInertial = 15,
  kErrEarthField = 15,
  kErrBodyField = 18,
  kErrWind = 21,
  kErrStates = 23
};

/// One scalar measurement, linear in the errors: residual = sum(coefficient * error) + noise.
struct Measurement {
  static constexpr int kMaxTerms = 9;  // a magnetometer axis has 7, a late velocity 7, a drag 9
  std::array<double, kMaxTerms> coefficient{};
  std::array<std::uint8_t, kMaxTerms> index{};
  std::uint32_t terms = 0;
  double residual = 0;
  double variance = 1;

  void add(int error_index, double c) {
    index[terms] = static_cast<std::uint8_t>(error_index);
    coefficient[terms++] = c;
  }
};

using ErrorVector = std::array<double, kErrStates>;

/// Covariance of the error states of an inertial filter, worked on by its structure instead of as a dense matrix.
/// Shape:   15 x 15 in blocks of 3 (position, velocity, attitude, gyro bias, accelerometer bias), outdoors 23 x 23
/// (field
///          of the earth, field of the body, wind). Only the upper triangle is kept, so the matrix is symmetric by
///          construction. With 15 states the arithmetic, and so each bit, is that of 15 states alone.
/// Thread:  owner.   RT: yes.
class Covariance {
 public:
  /// Variance added per step to each block.
  struct Noise {
    double velocity = 0, attitude = 0, gyro_bias = 0, accel_bias = 0;
    double earth_field = 0, body_field = 0, wind = 0;
  };

  /// Forgets all; 15 states.
  void set_diagonal(const ErrorVector& variance);
  /// From now on 23 states; the new ones have these variances and no correlations.
  void open_surroundings(double earth_field, double body_field, double wind);
  bool has_surroundings() const { return states_ == kErrStates; }
  /// P = F P F^T + Q with F of one inertial step of `dt_s`:
  ///   p' = p + dt v,   v' = v - [f dt]x theta - R dt a,   theta' = theta - R dt g,   g and a constant.
  void propagate(const math::Mat3& r_world_base, const math::Vec3& f_world_mps2, double dt_s, const Noise& q);
  /// Variance of the innovation of `m`; fills `gain` with P H^T (not yet divided by it), as far as there are states.
  double innovation(const Measurement& m, ErrorVector& gain) const;
  /// P -= gain gain^T / s: the correction by one scalar measurement.
  void correct(const ErrorVector& gain, double s);

  double operator()(int r, int c) const { return r <= c ? p_[r][c] : p_[c][r]; }
  double variance(int i) const { return p_[i][i]; }
  /// Forgets what is known about one state: its variance becomes `variance`, its correlations 0.
  void reopen(int i, double variance);
  /// Turns the axes of the states `i` and `i + 1` by the angle with this cosine and sine: a rotation of the world.
  void turn_pair(int i, double cosine, double sine);

 private:
  template <int kTo>
  double innovation_of(const Measurement& m, ErrorVector& gain) const;
  template <int kTo>
  void subtract_outer(const double* gain, double inverse);
  void propagate_surroundings(const math::Mat3& r_world_base, const double (&f_dt)[3], double dt_s, const Noise& q);

  static constexpr int kColumns = 24;
  alignas(16) double p_[kErrStates][kColumns] = {};
  std::int32_t states_ = kErrInertial;
  [[maybe_unused]] std::int32_t fill_[3] = {};  // the matrix is aligned to 16: no padding in a state
};

}  // namespace sinew::control
