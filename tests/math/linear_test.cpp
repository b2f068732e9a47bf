// Compared with Eigen, which only tests use.
#include "math/linear.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "math/random.hpp"
#include "msg/geometry.hpp"

namespace {

using namespace sinew;
using math::Mat;
using math::Mat3;
using math::Quat;
using math::Random;
using math::Vec3;

template <int R, int C>
Mat<R, C> random_matrix(Random& random) {
  Mat<R, C> m;
  for (double& e : m.a) e = random.uniform(-2, 2);
  return m;
}
Vec3 random_vector(Random& random) { return {random.normal(), random.normal(), random.normal()}; }
Quat random_rotation(Random& random) {
  return Quat{random.normal(), random.normal(), random.normal(), random.normal()}.normalized();
}

/// Of one type for all sizes: Eigen's solvers take a minute to compile for eight of them.
template <int R, int C>
Eigen::MatrixXd eigen(const Mat<R, C>& m) {
  Eigen::MatrixXd e(R, C);
  for (int r = 0; r < R; ++r)
    for (int c = 0; c < C; ++c) e(r, c) = m(r, c);
  return e;
}
Eigen::Vector3d eigen(const Vec3& v) { return {v.x, v.y, v.z}; }
Eigen::Quaterniond eigen(const Quat& q) { return {q.w, q.x, q.y, q.z}; }

void expect_near(const Vec3& a, const Eigen::Vector3d& b, double tolerance = 1e-14) {
  EXPECT_LT((eigen(a) - b).norm(), tolerance * (1 + b.norm())) << a.x << " " << a.y << " " << a.z << " / " << b;
}
/// The same rotation, whatever the sign.
void expect_same_rotation(const Quat& a, const Quat& b, double tolerance = 1e-14) {
  EXPECT_LT(math::angle_between(a, b), tolerance) << a.w << " " << a.x << " " << a.y << " " << a.z;
}

TEST(Vec3, ConvertsFromAndToMessages) {
  const msg::Vec3 m{1, 2, 3};
  EXPECT_EQ(Vec3(m), Vec3(1, 2, 3));
  EXPECT_EQ((2 * Vec3(m)).to<msg::Vec3>(), (msg::Vec3{2, 4, 6}));
  const msg::Quat q{0.5, -0.5, 0.5, -0.5};
  EXPECT_EQ(Quat(q).conjugate().to<msg::Quat>(), (msg::Quat{0.5, 0.5, -0.5, 0.5}));
}

TEST(Vec3, ProductsEqualEigens) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Vec3 a = random_vector(random), b = random_vector(random);
    expect_near(math::cross(a, b), eigen(a).cross(eigen(b)));
    expect_near(math::skew(a) * b, eigen(a).cross(eigen(b)));
    EXPECT_NEAR(math::dot(a, b), eigen(a).dot(eigen(b)), 1e-14);
    EXPECT_NEAR(math::norm(math::normalized(a)), 1, 1e-15);
    EXPECT_LT((eigen(math::outer(a, b)) - eigen(a) * eigen(b).transpose()).norm(), 1e-14);
  }
  EXPECT_EQ(math::normalized(Vec3{}), Vec3{});
}

TEST(Quat, ProductRotationAndMatrixEqualEigens) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Quat a = random_rotation(random), b = random_rotation(random);
    const Vec3 v = random_vector(random);
    const Eigen::Quaterniond ab = eigen(a) * eigen(b);
    expect_same_rotation(a * b, Quat{ab.w(), ab.x(), ab.y(), ab.z()});
    expect_near(a.rotate(v), eigen(a) * eigen(v));
    expect_near(a.matrix() * v, eigen(a) * eigen(v));
    expect_near(a.conjugate().rotate(a.rotate(v)), eigen(v));
    expect_near((a * b).rotate(v), eigen(a.rotate(b.rotate(v))));
  }
}

TEST(Quat, ComesBackFromItsMatrixAlsoForHalfTurns) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Quat q = random_rotation(random);
    expect_same_rotation(Quat::from_matrix(q.matrix()), q);
  }
  for (const Quat& half : {Quat{0, 1, 0, 0}, Quat{0, 0, 1, 0}, Quat{0, 0, 0, 1}, Quat{0, 0.6, 0.8, 0}})
    expect_same_rotation(Quat::from_matrix(half.matrix()), half);
}

TEST(Quat, ExponentialAndLogarithmAreInverse) {
  Random random(4);
  for (int i = 0; i < 400; ++i) {
    const Vec3 axis = math::normalized(random_vector(random));
    const double angle = i % 2 == 0 ? random.uniform(0, 3.14) : std::ldexp(random.uniform(), -i / 8);
    const Vec3 v = axis * angle;
    const Quat q = Quat::exp(v);
    expect_same_rotation(q, Quat::from_axis_angle(axis, angle));
    const Eigen::Quaterniond want(Eigen::AngleAxisd(angle, eigen(axis)));
    expect_same_rotation(q, Quat{want.w(), want.x(), want.y(), want.z()});
    EXPECT_LT(math::norm(q.log() - v), 1e-14 * (angle + 1e-3)) << angle;
    EXPECT_LT(math::norm((-q).log() - v), 1e-14 * (angle + 1e-3)) << angle;
  }
  EXPECT_EQ(Quat::exp({}), Quat{});
  EXPECT_EQ(Quat{}.log(), Vec3{});
}

TEST(Quat, YawPitchRollAreRotationsAboutZYX) {
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const double yaw = random.uniform(-3, 3), pitch = random.uniform(-1.5, 1.5), roll = random.uniform(-3, 3);
    const Quat q = Quat::from_yaw_pitch_roll({yaw, pitch, roll});
    const Eigen::Quaterniond want = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
    expect_same_rotation(q, Quat{want.w(), want.x(), want.y(), want.z()});
    const math::YawPitchRoll back = q.yaw_pitch_roll();
    EXPECT_NEAR(back.yaw, yaw, 1e-12);
    EXPECT_NEAR(back.pitch, pitch, 1e-12);
    EXPECT_NEAR(back.roll, roll, 1e-12);
    EXPECT_NEAR(q.yaw(), yaw, 1e-12);
  }
  EXPECT_NEAR(Quat::from_yaw_pitch_roll({0, math::kPi / 2, 0}).yaw_pitch_roll().pitch, math::kPi / 2, 1e-7);
}

TEST(Quat, BetweenTakesTheFirstDirectionToTheSecond) {
  Random random(6);
  for (int i = 0; i < 200; ++i) {
    const Vec3 a = random_vector(random), b = i % 4 == 0 ? -2 * a : random_vector(random);
    const Quat q = Quat::between(a, b);
    EXPECT_LT(math::norm(q.rotate(math::normalized(a)) - math::normalized(b)), 1e-14);
  }
  EXPECT_EQ(Quat::between({1, 0, 0}, {3, 0, 0}), Quat{});
}

TEST(Quat, NormalisingNothingGivesIdentity) {
  EXPECT_EQ((Quat{0, 0, 0, 0}.normalized()), Quat{});
  EXPECT_EQ((Quat{math::kNan, 0, 0, 0}.normalized()), Quat{});
}

TEST(Mat, SumsProductsAndBlocksEqualEigens) {
  Random random(7);
  const auto a = random_matrix<4, 6>(random), b = random_matrix<4, 6>(random);
  const auto c = random_matrix<6, 3>(random);
  EXPECT_LT((eigen(a + b) - (eigen(a) + eigen(b))).norm(), 1e-15);
  EXPECT_LT((eigen(a - 2 * b) - (eigen(a) - 2 * eigen(b))).norm(), 1e-15);
  EXPECT_LT((eigen(a * c) - eigen(a) * eigen(c)).norm(), 1e-14);
  EXPECT_EQ(eigen(a.transpose()), eigen(a).transpose());
  const auto block = a.block<2, 3>(1, 2);
  EXPECT_EQ(eigen(block), eigen(a).block(1, 2, 2, 3));
  auto d = a;
  d.set_block(2, 3, block);
  EXPECT_EQ(d(3, 5), a(2, 4));
  const auto s = random_matrix<5, 5>(random);
  EXPECT_EQ(s.symmetric(), s.symmetric().transpose());
  EXPECT_NEAR(s.trace(), eigen(s).trace(), 1e-15);
}

template <int N>
void check_solvers(Random& random) {
  for (int i = 0; i < 50; ++i) {
    const auto m = random_matrix<N, N>(random);
    const auto spd = (m * m.transpose() + Mat<N, N>::identity() * 0.1).symmetric();
    const auto b = random_matrix<N, 2>(random);
    const auto factor = math::cholesky(spd);
    ASSERT_TRUE(factor);
    EXPECT_LT((eigen(spd) * eigen(factor->solve(b)) - eigen(b)).norm(), 1e-11);
    EXPECT_LT((eigen(factor->solve(b)) - eigen(spd).llt().solve(eigen(b))).norm(), 1e-9);
    EXPECT_LT((eigen(spd * factor->inverse()) - Eigen::MatrixXd::Identity(N, N)).norm(), 1e-11);
    const auto x = math::solve(m, b);
    ASSERT_TRUE(x);
    const Eigen::MatrixXd want = eigen(m).fullPivLu().solve(eigen(b));
    EXPECT_LT((eigen(*x) - want).norm(), 1e-9 * (1 + want.norm() * want.norm()));
    const auto inverse = math::inverse(m);
    ASSERT_TRUE(inverse);
    EXPECT_LT((eigen(*inverse) - eigen(m).inverse()).norm(), 1e-9 * (1 + eigen(m).inverse().squaredNorm()));
  }
}

TEST(Mat, SolversEqualEigensForEverySizeUpToEight) {
  Random random(8);
  check_solvers<1>(random);
  check_solvers<2>(random);
  check_solvers<3>(random);
  check_solvers<4>(random);
  check_solvers<5>(random);
  check_solvers<6>(random);
  check_solvers<7>(random);
  check_solvers<8>(random);
}

TEST(Mat, SolversRefuseWhatHasNoSolution) {
  EXPECT_FALSE(math::cholesky(Mat<2, 2>{1, 2, 2, 1}));
  EXPECT_FALSE(math::cholesky(Mat<2, 2>{1, math::kNan, math::kNan, 1}));
  EXPECT_FALSE(math::inverse(Mat<2, 2>{1, 2, 2, 4}));
  EXPECT_FALSE(math::inverse(Mat<2, 2>{math::kInf, 0, 0, 1}));
  EXPECT_FALSE(math::inverse(Mat<2, 2>{}));
  EXPECT_TRUE(math::inverse(Mat<2, 2>{0, 1, 1, 0})) << "needs a row exchange";
}

}  // namespace
