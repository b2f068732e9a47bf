#pragma once
// The inertial filter again, dense and plain, on Eigen: the reference for the one that uses structure.
#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "control/inertial_filter.hpp"

namespace sinew::control::test {

class DenseFilter {
 public:
  using Matrix = Eigen::Matrix<double, 15, 15>;
  using Vector = Eigen::Matrix<double, 15, 1>;

  Eigen::Quaterniond q;
  Eigen::Vector3d p, v, gyro_bias, accel_bias;
  Matrix covariance = Matrix::Zero();

  DenseFilter(const InertialState& x, const InertialSpread& s)
      : q(x.q_world_base.w, x.q_world_base.x, x.q_world_base.y, x.q_world_base.z),
        p(of(x.p_world_m)),
        v(of(x.v_world_mps)),
        gyro_bias(of(x.gyro_bias_radps)),
        accel_bias(of(x.accel_bias_mps2)) {
    Vector sigma;
    sigma << s.p_m, s.p_m, s.p_m, s.v_mps, s.v_mps, s.v_mps, s.tilt_rad, s.tilt_rad, s.yaw_rad, s.gyro_bias_radps,
        s.gyro_bias_radps, s.gyro_bias_radps, s.accel_bias_mps2, s.accel_bias_mps2, s.accel_bias_mps2;
    covariance = sigma.cwiseAbs2().asDiagonal();
  }

  static Eigen::Vector3d of(const math::Vec3& a) { return {a.x, a.y, a.z}; }
  static Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
    Eigen::Matrix3d m;
    m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return m;
  }
  static Eigen::Quaterniond turn(const Eigen::Vector3d& r) {
    const double angle = r.norm();
    if (angle < 1e-300) return Eigen::Quaterniond::Identity();
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, r / angle));
  }

  void predict(const math::Vec3& gyro, const math::Vec3& accel, double dt, const InertialNoise& n) {
    const Eigen::Vector3d w = of(gyro) - gyro_bias, a = of(accel) - accel_bias;
    const Eigen::Matrix3d r = q.toRotationMatrix();
    const Eigen::Vector3d f = r * (a + 0.5 * dt * w.cross(a));
    Matrix transition = Matrix::Identity();
    transition.block<3, 3>(0, 3) = dt * Eigen::Matrix3d::Identity();
    transition.block<3, 3>(3, 6) = -dt * skew(f);
    transition.block<3, 3>(3, 12) = -dt * r;
    transition.block<3, 3>(6, 9) = -dt * r;
    Vector noise = Vector::Zero();
    noise.segment<3>(3).setConstant(n.accel * n.accel * dt);
    noise.segment<3>(6).setConstant(n.gyro * n.gyro * dt);
    noise.segment<3>(9).setConstant(n.gyro_walk * n.gyro_walk * dt);
    noise.segment<3>(12).setConstant(n.accel_walk * n.accel_walk * dt);
    covariance = transition * covariance * transition.transpose();
    covariance.diagonal() += noise;
    const Eigen::Vector3d dv = dt * (f - Eigen::Vector3d(0, 0, kGravity));
    p += dt * (v + 0.5 * dv);
    v += dv;
    q = (q * turn(dt * w)).normalized();
  }

  /// All rows at once: gain with the inverse of the innovation's covariance, Joseph form.
  void update(const std::vector<Measurement>& rows) {
    const auto n = static_cast<Eigen::Index>(rows.size());
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(n, 15), noise = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd residual(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Measurement& m = rows[static_cast<std::size_t>(i)];
      for (std::uint32_t t = 0; t < m.terms; ++t) h(i, m.index[t]) = m.coefficient[t];
      noise(i, i) = m.variance;
      residual(i) = m.residual;
    }
    const Eigen::MatrixXd s = h * covariance * h.transpose() + noise;
    const Eigen::MatrixXd gain = covariance * h.transpose() * s.inverse();
    const Matrix keep = Matrix::Identity() - gain * h;
    covariance = keep * covariance * keep.transpose() + gain * noise * gain.transpose();
    const Vector dx = gain * residual;
    p += dx.segment<3>(0);
    v += dx.segment<3>(3);
    q = (turn(dx.segment<3>(6)) * q).normalized();
    gyro_bias += dx.segment<3>(9);
    accel_bias += dx.segment<3>(12);
  }
};

}  // namespace sinew::control::test
