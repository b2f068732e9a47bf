#include "estimator_floor.hpp"

#if __has_include(<Eigen/Dense>)
#include <Eigen/Dense>
#define SINEW_HAS_EIGEN 1
#else
#define SINEW_HAS_EIGEN 0
#endif

namespace sinew::bench {
namespace {

constexpr double kDt = 0.005, kG = 9.81, kQ = 1e-4, kR = 0.01;

/// Error states: position, velocity, attitude, accelerometer bias, gyro bias, then those that only wait. Velocity
/// couples with one attitude angle each, which is less work than a real attitude needs.
template <int kStates>
class Blocks : public EstimatorFloor {
 public:
  Blocks() {
    for (int i = 0; i < kStates; ++i) p_[i][i] = 1;
  }

 protected:
  static constexpr int kColumns = kStates + 1;  // even
  void add_row(int to, int from, double f) {
    for (int j = 0; j < kColumns; ++j) p_[to][j] += f * p_[from][j];
  }
  void predict() {
    const double tilt = kDt * kG;
    for (int i = 0; i < 3; ++i) {
      x_[i] += kDt * x_[3 + i];
      x_[3 + i] += tilt * x_[6 + (i + 1) % 3] - kDt * x_[9 + i];
    }
    for (int i = 0; i < 3; ++i) x_[6 + i] -= kDt * x_[12 + i];
    for (int i = 0; i < 3; ++i) add_row(i, 3 + i, kDt);
    for (int i = 0; i < 3; ++i) {
      add_row(3 + i, 6 + (i + 1) % 3, tilt);
      add_row(3 + i, 9 + i, -kDt);
    }
    for (int i = 0; i < 3; ++i) add_row(6 + i, 12 + i, -kDt);
    for (auto& row : p_) {
      for (int i = 0; i < 3; ++i) row[i] += kDt * row[3 + i];
      for (int i = 0; i < 3; ++i) row[3 + i] += tilt * row[6 + (i + 1) % 3] - kDt * row[9 + i];
      for (int i = 0; i < 3; ++i) row[6 + i] -= kDt * row[12 + i];
    }
    for (int i = 0; i < kStates; ++i) p_[i][i] += kQ;
  }
  alignas(64) double p_[kStates][kColumns] = {};
  double x_[kStates] = {};
};

class Block final : public Blocks<15> {
 public:
  void step(const double (&z)[3]) override {
    predict();
    update(z);
    asm volatile("" : : "r"(this) : "memory");
  }

 private:
  void update(const double (&z)[3]) {
    for (int m = 0; m < 3; ++m) {
      alignas(64) double k[kColumns] = {};
      const double s = 1 / (p_[m][m] + kR), r = z[m] - x_[m];
      for (int j = 0; j < 15; ++j) k[j] = p_[m][j];
      for (int i = 0; i < 15; ++i) {
        const double f = k[i] * s;
        x_[i] += f * r;
        for (int j = 0; j < kColumns; ++j) p_[i][j] -= f * k[j];
      }
    }
  }
};

/// 50 inertial samples with their magnetometer's and GNSS' rows.
class Outdoor final : public Blocks<23> {
 public:
  void step(const double (&z)[3]) override {
    for (int i = 0; i < 50; ++i) {
      predict();
      if (i % 5 == 0)
        for (int axis = 0; axis < 3; ++axis) {
          const int index[7] = {6, 7, 8, 15, 16, 17, 18 + axis};
          const double h[7] = {0.2, -0.4, 0.1, 0.5, 0.6, 0.7, 1};
          row(index, h, 7, z[axis]);
        }
      if (i == 0)
        for (int axis = 0; axis < 6; ++axis) {
          const int index[4] = {axis, 6, 7, 9 + axis % 3};
          const double h[4] = {1, 0.3, -0.2, 0.1};
          row(index, h, 4, z[axis % 3]);
        }
    }
    asm volatile("" : : "r"(this) : "memory");
  }

 private:
  void row(const int* index, const double* h, int terms, double z) {
    alignas(64) double k[kColumns] = {};
    double s = kR, r = z;
    for (int t = 0; t < terms; ++t) {
      for (int j = 0; j < 23; ++j) k[j] += h[t] * p_[index[t]][j];
      r -= h[t] * x_[index[t]];
    }
    for (int t = 0; t < terms; ++t) s += h[t] * k[index[t]];
    for (int i = 0; i < 23; ++i) {
      const double f = k[i] / s;
      x_[i] += f * r;
      for (int j = 0; j < kColumns; ++j) p_[i][j] -= f * k[j];
    }
  }
};

#if SINEW_HAS_EIGEN
class Dense final : public EstimatorFloor {
 public:
  Dense() {
    for (int i = 0; i < 3; ++i) {
      f_(i, 3 + i) = kDt;
      f_(3 + i, 6 + (i + 1) % 3) = kDt * kG;
      f_(3 + i, 9 + i) = -kDt;
      f_(6 + i, 12 + i) = -kDt;
      h_(i, i) = 1;
    }
  }
  void step(const double (&z)[3]) override {
    x_ = f_ * x_;
    const Matrix fp = f_ * p_;
    p_.noalias() = fp * f_.transpose();
    p_.diagonal().array() += kQ;
    const Eigen::Matrix<double, 15, 3> ph = p_ * h_.transpose();
    const Eigen::Matrix3d s = h_ * ph + kR * Eigen::Matrix3d::Identity();
    const Eigen::Matrix<double, 15, 3> k = ph * s.inverse();
    x_ += k * (Eigen::Vector3d(z[0], z[1], z[2]) - h_ * x_);
    p_.noalias() -= k * ph.transpose();
    p_ = ((p_ + p_.transpose()) * 0.5).eval();
    asm volatile("" : : "r"(this) : "memory");
  }

 private:
  using Matrix = Eigen::Matrix<double, 15, 15>;
  Matrix p_ = Matrix::Identity(), f_ = Matrix::Identity();
  Eigen::Matrix<double, 15, 1> x_ = Eigen::Matrix<double, 15, 1>::Zero();
  Eigen::Matrix<double, 3, 15> h_ = Eigen::Matrix<double, 3, 15>::Zero();
};
#endif

}  // namespace

EstimatorFloor* block_floor() {
  static Block block;
  return &block;
}

EstimatorFloor* outdoor_floor() {
  static Outdoor outdoor;
  return &outdoor;
}

EstimatorFloor* dense_eigen() {
#if SINEW_HAS_EIGEN
  static Dense dense;
  return &dense;
#else
  return nullptr;
#endif
}

}  // namespace sinew::bench
