#include "control/inertial_filter.hpp"

#include <gmock/gmock.h>

#include "dense_filter.hpp"
#include "math/random.hpp"

namespace sinew::control::inertial_filter_test {
namespace {

using math::Vec3;
using test::DenseFilter;

Vec3 random(math::Random& r, double sigma) {
  const double x = r.normal(), y = r.normal(), z = r.normal();
  return Vec3{x, y, z} * sigma;
}

/// A tumbling, shaken vehicle: everything couples with everything.
Vec3 gyro_at(int i) { return {0.8 * math::sin(0.003 * i), 0.6 * math::cos(0.002 * i), 0.3}; }
Vec3 accel_at(int i) { return {2 * math::sin(0.005 * i), 1.5 * math::cos(0.004 * i), 9.8 + math::sin(0.01 * i)}; }

/// Rows of every kind that the estimator uses.
std::vector<Measurement> rows_at(const InertialFilter& f, math::Random& r) {
  std::vector<Measurement> rows(5);
  rows[0].add(kErrP + 2, 1);
  rows[0].residual = 0.1 - f.state().p_world_m.z + r.normal(0, 0.02);
  rows[0].variance = 4e-4;
  rows[1].add(kErrP, 1);
  rows[1].add(kErrV, -0.04);
  rows[1].add(kErrTheta + 1, -1.3);
  rows[1].add(kErrTheta + 2, 0.4);
  rows[1].residual = -f.state().p_world_m.x + r.normal(0, 0.05);
  rows[1].variance = 2.5e-3;
  rows[2].add(kErrV + 1, 1);
  rows[2].residual = -f.state().v_world_mps.y + r.normal(0, 0.1);
  rows[2].variance = 0.01;
  rows[4].add(kErrP + 1, 1);
  rows[4].add(kErrTheta, 1.3);
  rows[4].residual = -f.state().p_world_m.y + r.normal(0, 0.05);
  rows[4].variance = 2.5e-3;
  rows[3].add(kErrTheta, 9.8);
  rows[3].add(kErrTheta + 2, 0.3);
  for (int k = 0; k < 3; ++k) rows[3].add(kErrAccelBias + k, 0.2 + 0.3 * k);
  rows[3].residual = r.normal(0, 0.5);
  rows[3].variance = 1.0;
  return rows;
}

struct Difference {
  double state = 0, covariance = 0;
};

Difference compare(const InertialFilter& f, const DenseFilter& d) {
  Difference worst;
  const auto state = [&](const Vec3& a, const Eigen::Vector3d& b) {
    worst.state = std::max(worst.state, (DenseFilter::of(a) - b).cwiseAbs().maxCoeff());
  };
  state(f.state().p_world_m, d.p);
  state(f.state().v_world_mps, d.v);
  state(f.state().gyro_bias_radps, d.gyro_bias);
  state(f.state().accel_bias_mps2, d.accel_bias);
  const math::Quat& q = f.state().q_world_base;
  const Eigen::Quaterniond mine(q.w, q.x, q.y, q.z);
  worst.state = std::max(worst.state, 2 * (mine.coeffs() - d.q.coeffs()).cwiseAbs().maxCoeff());
  for (int i = 0; i < kErrInertial; ++i)
    for (int j = 0; j < kErrInertial; ++j)
      worst.covariance = std::max(worst.covariance, std::abs(f.covariance()(i, j) - d.covariance(i, j)));
  return worst;
}

TEST(InertialFilter, PredictionAgreesWithADenseFilter) {
  InertialState start;
  start.q_world_base = math::Quat{0.9, 0.3, -0.2, 0.25}.normalized();
  start.gyro_bias_radps = {0.01, -0.02, 0.03};
  start.accel_bias_mps2 = {0.1, 0.05, -0.07};
  InertialFilter f;
  f.start(start, {});
  start.q_world_base = f.state().q_world_base;
  DenseFilter d(start, {});
  for (int i = 0; i < 400; ++i) {
    f.predict(gyro_at(i), accel_at(i), 0.005, {});
    d.predict(gyro_at(i), accel_at(i), 0.005, {});
    const Difference diff = compare(f, d);
    ASSERT_LT(diff.state, 1e-9) << "step " << i;
    ASSERT_LT(diff.covariance, 1e-9) << "step " << i;
  }
}

TEST(InertialFilter, PredictionAndScalarUpdatesAgreeWithADenseFilterInJosephForm) {
  math::Random random_numbers(3);
  InertialFilter f;
  f.start({}, {});
  DenseFilter d({}, {});
  for (int i = 0; i < 5000; ++i) {
    const Vec3 gyro = gyro_at(i) + random(random_numbers, 0.01), accel = accel_at(i) + random(random_numbers, 0.2);
    f.predict(gyro, accel, 0.002, {});
    d.predict(gyro, accel, 0.002, {});
    if (i % 7 == 0) {
      const auto rows = rows_at(f, random_numbers);
      ASSERT_EQ(f.update(rows, 1e18), rows.size());
      d.update(rows);
    }
    const Difference diff = compare(f, d);
    ASSERT_LT(diff.state, 1e-9) << "step " << i;
    ASSERT_LT(diff.covariance, 1e-9) << "step " << i;
  }
}

TEST(InertialFilter, CovarianceStaysPositiveDefiniteForAnHour) {
  math::Random random_numbers(4);
  InertialFilter f;
  f.start({}, {});
  for (int i = 0; i < 200 * 3600; ++i) {
    f.predict(gyro_at(i), accel_at(i), 0.005, {});
    if (i % 10 == 0) f.update(rows_at(f, random_numbers), 16);
    if (i % 20000 != 0) continue;
    DenseFilter::Matrix p;
    for (int r = 0; r < kErrInertial; ++r)
      for (int c = 0; c < kErrInertial; ++c) p(r, c) = f.covariance()(r, c);
    const Eigen::SelfAdjointEigenSolver<DenseFilter::Matrix> eigen(p);
    ASSERT_GT(eigen.eigenvalues()(0), 0) << "after " << i / 200 << " s";
    ASSERT_NEAR(
        math::Quat(f.state().q_world_base).w * f.state().q_world_base.w + squared_norm(f.state().q_world_base.vec()), 1,
        1e-12);
  }
}

TEST(InertialFilter, MeasurementBeyondTheGateIsLeftOutAndTheOthersOfItsInstantAreUsed) {
  InertialFilter f;
  f.start({}, {});
  std::vector<Measurement> rows(2);
  rows[0].add(kErrV, 1);
  rows[0].residual = 100;
  rows[1].add(kErrV + 1, 1);
  rows[1].residual = 1;
  EXPECT_EQ(f.update(rows, 9), 1u);
  EXPECT_EQ(f.state().v_world_mps.x, 0);
  EXPECT_NEAR(f.state().v_world_mps.y, 0.8, 1e-12) << "prior 2 m/s, measured with 1 m/s";
}

TEST(InertialFilter, MeasurementThatIsNotANumberChangesNothing) {
  InertialFilter f;
  f.start({}, {});
  std::vector<Measurement> rows(1);
  rows[0].add(kErrP, 1);
  rows[0].residual = math::kNan;
  EXPECT_EQ(f.update(rows, 1e18), 0u);
  EXPECT_EQ(f.state().p_world_m, Vec3{});
  EXPECT_TRUE(math::is_finite(f.covariance()(0, 0)));
}

TEST(InertialFilter, ReopenedPositionForgetsItsCorrelations) {
  InertialFilter f;
  f.start({}, {});
  for (int i = 0; i < 100; ++i) f.predict(gyro_at(i), accel_at(i), 0.005, {});
  ASSERT_NE(f.covariance()(kErrP, kErrV), 0);
  f.reset_position(0, 7.5, 0.25);
  EXPECT_EQ(f.state().p_world_m.x, 7.5);
  for (int j = 0; j < kErrInertial; ++j) EXPECT_EQ(f.covariance()(kErrP, j), j == kErrP ? 0.25 : 0.0);
}

TEST(Covariance, With23StatesItIsWhatADenseMatrixIs) {
  using Matrix = Eigen::Matrix<double, kErrStates, kErrStates>;
  using Vector = Eigen::Matrix<double, kErrStates, 1>;
  math::Random random_number(7);
  Covariance p;
  ErrorVector start{};
  Matrix dense = Matrix::Zero();
  for (int i = 0; i < kErrStates; ++i) {
    const double variance = i < kErrInertial ? 0.1 + 0.05 * i : i < kErrBodyField ? 0.2 : i < kErrWind ? 0.3 : 4.0;
    start[std::size_t(i)] = variance;
    dense(i, i) = variance;
  }
  p.set_diagonal(start);
  p.open_surroundings(0.2, 0.3, 4.0);
  for (int step = 0; step < 300; ++step) {
    const math::Mat3 r = math::Quat::exp(random(random_number, 0.8)).matrix();
    const Vec3 f = Vec3{0, 0, 9.8} + random(random_number, 2);
    const double dt = 0.01;
    p.propagate(r, f, dt, {1e-4, 1e-6, 1e-8, 1e-7, 1e-9, 2e-9, 1e-3});
    Matrix transition = Matrix::Identity();
    Eigen::Matrix3d turn;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) turn(i, j) = r(i, j);
    transition.block<3, 3>(kErrP, kErrV) = dt * Eigen::Matrix3d::Identity();
    transition.block<3, 3>(kErrV, kErrTheta) = -dt * DenseFilter::skew(DenseFilter::of(f));
    transition.block<3, 3>(kErrV, kErrAccelBias) = -dt * turn;
    transition.block<3, 3>(kErrTheta, kErrGyroBias) = -dt * turn;
    Vector noise = Vector::Zero();
    noise.segment<3>(kErrV).setConstant(1e-4);
    noise.segment<3>(kErrTheta).setConstant(1e-6);
    noise.segment<3>(kErrGyroBias).setConstant(1e-8);
    noise.segment<3>(kErrAccelBias).setConstant(1e-7);
    noise.segment<3>(kErrEarthField).setConstant(1e-9);
    noise.segment<3>(kErrBodyField).setConstant(2e-9);
    noise.segment<2>(kErrWind).setConstant(1e-3);
    dense = transition * dense * transition.transpose();
    dense.diagonal() += noise;

    Measurement m;  // a magnetometer axis, and on every third step the wind
    Vector h = Vector::Zero();
    const int first = step % 3 == 0 ? kErrWind : kErrEarthField, count = step % 3 == 0 ? 2 : 4;
    for (int k = 0; k < 3; ++k) h(kErrTheta + k) = random_number.normal();
    for (int k = 0; k < count; ++k) h(first + k) = random_number.normal();
    for (int k = 0; k < kErrStates; ++k)
      if (h(k) != 0) m.add(k, h(k));
    m.variance = 0.5;
    ErrorVector gain;
    const double s = p.innovation(m, gain);
    p.correct(gain, s);
    const Vector wanted = dense * h;
    const double wanted_s = h.dot(wanted) + 0.5;
    EXPECT_NEAR(s, wanted_s, 1e-9 * wanted_s);
    dense -= wanted * wanted.transpose() / wanted_s;

    if (step % 50 == 49) {  // the world turns
      for (const int i : {kErrP, kErrV, kErrTheta, kErrEarthField, kErrWind})
        p.turn_pair(i, math::cos(0.7), math::sin(0.7));
      Matrix world = Matrix::Identity();
      for (const int i : {kErrP, kErrV, kErrTheta, kErrEarthField, kErrWind}) {
        world(i, i) = world(i + 1, i + 1) = math::cos(0.7);
        world(i, i + 1) = -math::sin(0.7);
        world(i + 1, i) = math::sin(0.7);
      }
      dense = world * dense * world.transpose();
    }
  }
  for (int i = 0; i < kErrStates; ++i)
    for (int j = 0; j < kErrStates; ++j) EXPECT_NEAR(p(i, j), dense(i, j), 1e-8) << i << " " << j;
}

}  // namespace
}  // namespace sinew::control::inertial_filter_test
