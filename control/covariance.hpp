#pragma once
#include <array>
#include <cstdint>

#include "math/linear.hpp"

namespace sinew::control {

/// Where each error state sits in the covariance and in a correction. All but the biases in world axes.
enum ErrorIndex : int { kErrP = 0, kErrV = 3, kErrTheta = 6, kErrGyroBias = 9, kErrAccelBias = 12, kErrStates = 15 };

/// One scalar measurement, linear in the errors: residual = sum(coefficient * error) + noise.
struct Measurement {
  static constexpr int kMaxTerms = 6;
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

/// Covariance of the 15 error states of an inertial filter, worked on by its structure instead of as a dense matrix.
/// Shape:   15 x 15 in blocks of 3 (position, velocity, attitude, gyro bias, accelerometer bias). Only the upper
///          triangle is kept, so the matrix is symmetric by construction.
/// Thread:  owner.   RT: yes.
class Covariance {
 public:
  /// Variance added per step to each block.
  struct Noise {
    double velocity = 0, attitude = 0, gyro_bias = 0, accel_bias = 0;
  };

  void set_diagonal(const ErrorVector& variance);
  /// P = F P F^T + Q with F of one inertial step of `dt_s`:
  ///   p' = p + dt v,   v' = v - [f dt]x theta - R dt a,   theta' = theta - R dt g,   g and a constant.
  void propagate(const math::Mat3& r_world_base, const math::Vec3& f_world_mps2, double dt_s, const Noise& q);
  /// Variance of the innovation of `m`; fills `gain` with P H^T (not yet divided by it).
  double innovation(const Measurement& m, ErrorVector& gain) const;
  /// P -= gain gain^T / s: the correction by one scalar measurement.
  void correct(const ErrorVector& gain, double s);

  double operator()(int r, int c) const { return r <= c ? p_[r][c] : p_[c][r]; }
  double variance(int i) const { return p_[i][i]; }
  /// Forgets what is known about one state: its variance becomes `variance`, its correlations 0.
  void reopen(int i, double variance);

 private:
  alignas(16) double p_[kErrStates][16] = {};
};

}  // namespace sinew::control
