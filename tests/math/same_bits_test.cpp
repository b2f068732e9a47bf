// The same bits on every compiler, optimisation level and CPU: the elementary functions and the linear algebra must
// give the results written down here. A change that moves bits on purpose changes this file.
#include <gtest/gtest.h>

#include "math/hash.hpp"
#include "math/linear.hpp"
#include "math/random.hpp"

namespace {

using namespace sinew;

std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x); }

struct Golden {
  const char* what;
  double value;
  std::uint64_t bits;
};

TEST(SameBits, OfChosenArguments) {
  const Golden golden[] = {
      {"sin(0.5)", math::sin(0.5), 0x3fdeaee8744b05f0},
      {"sin(3.0)", math::sin(3.0), 0x3fc210386db6d55b},
      {"sin(1e6)", math::sin(1e6), 0xbfd6664b2568d867},
      {"sin(1e22)", math::sin(1e22), 0xbfeb453ab76bf397},
      {"sin(-0x1p-30)", math::sin(-0x1p-30), 0xbe10000000000000},
      {"cos(0.5)", math::cos(0.5), 0x3fec1528065b7d50},
      {"cos(1.5707963267948966)", math::cos(1.5707963267948966), 0x3c91a62633145c07},
      {"cos(-11.0)", math::cos(-11.0), 0x3f7220ae41ee2fdf},
      {"cos(1e300)", math::cos(1e300), 0xbfe2699022adc4c1},
      {"tan(0.5)", math::tan(0.5), 0x3fe17b4f5bf3474a},
      {"tan(1.5707963267948966)", math::tan(1.5707963267948966), 0x434d02967c31cdb5},
      {"tan(100.0)", math::tan(100.0), 0xbfe2ca74d62b5d38},
      {"atan(0.03)", math::atan(0.03), 0x3f9eb5f644234b83},
      {"atan(0.75)", math::atan(0.75), 0x3fe4978fa3269ee1},
      {"atan(1.5)", math::atan(1.5), 0x3fef730bd281f69b},
      {"atan(1e10)", math::atan(1e10), 0x3ff921fb543d4de0},
      {"atan2(1.0, 3.0)", math::atan2(1.0, 3.0), 0x3fd4978fa3269ee1},
      {"atan2(-3.0, 1.0)", math::atan2(-3.0, 1.0), 0xbff3fc176b7a8560},
      {"atan2(2.0, -7.0)", math::atan2(2.0, -7.0), 0x4006e8062854db5e},
      {"asin(0.3)", math::asin(0.3), 0x3fd380159e14f6ff},
      {"asin(-0.99)", math::asin(-0.99), 0xbff6de3c6f33d51d},
      {"acos(0.3)", math::acos(0.3), 0x3ff441f5ecbeef59},
      {"acos(0.999999)", math::acos(0.999999), 0x3f572ba46065af15},
      {"exp(1.0)", math::exp(1.0), 0x4005bf0a8b145769},
      {"exp(-0.1)", math::exp(-0.1), 0x3fecf46d99d52b3a},
      {"exp(100.0)", math::exp(100.0), 0x48f3494a9b171bf5},
      {"exp(-740.0)", math::exp(-740.0), 0x0000000000000055},
      {"log(2.0)", math::log(2.0), 0x3fe62e42fefa39ef},
      {"log(0.1)", math::log(0.1), 0xc0026bb1bbb55515},
      {"log(1.0000001)", math::log(1.0000001), 0x3e7ad7f2847b6492},
      {"log(1e-310)", math::log(1e-310), 0xc0864e69394d9508},
      {"pow(2.0, 0.5)", math::pow(2.0, 0.5), 0x3ff6a09e667f3bcc},
      {"pow(10.0, -3.0)", math::pow(10.0, -3.0), 0x3f50624dd2f1a9fc},
      {"pow(1.0001, 12345.0)", math::pow(1.0001, 12345.0), 0x400b7dd84483e523},
      {"pow(0.3, 77.7)", math::pow(0.3, 77.7), 0x37806ca8e3585f83},
      {"hypot(3.0, 5.0)", math::hypot(3.0, 5.0), 0x401752e50db3a3a2},
      {"hypot(1e200, 2e200)", math::hypot(1e200, 2e200), 0x69875eb557d922da},
      {"sqrt(2.0)", math::sqrt(2.0), 0x3ff6a09e667f3bcd},
      {"fmod(1e17, 3.3)", math::fmod(1e17, 3.3), 0x400176940521cb40},
      {"wrap_pi(40.0)", math::wrap_pi(40.0), 0x400268380ccde2e0},
  };
  for (const Golden& g : golden) EXPECT_EQ(bits(g.value), g.bits) << g.what << " = " << std::hex << bits(g.value);
}

class Sum {
 public:
  void add(double x) {
    const std::uint64_t b = bits(x);
    hash_.add(&b, sizeof b);
  }
  std::uint64_t value() const { return hash_.value(); }

 private:
  math::Hash64 hash_;
};

TEST(SameBits, OfAMillionResults) {
  math::Random random(2024, 6, 1);
  Sum sum;
  for (int i = 0; i < 50000; ++i) {
    const double x = random.uniform(-10, 10), y = random.uniform(-10, 10),
                 any = std::bit_cast<double>(random.next_u64());
    const math::SinCos sc = math::sincos(x);
    for (const double v : {sc.sin,
                           sc.cos,
                           math::tan(x),
                           math::atan(x),
                           math::atan2(y, x),
                           math::asin(x / 10),
                           math::acos(y / 10),
                           math::exp(x),
                           math::log(math::fabs(y)),
                           math::pow(math::fabs(x), y),
                           math::hypot(x, y),
                           math::fmod(x, y),
                           math::round(x),
                           math::sin(any),
                           math::atan(any),
                           math::exp(any),
                           math::log(any),
                           math::pow(any, y),
                           math::sqrt(any),
                           random.normal()})
      sum.add(v);
  }
  EXPECT_EQ(sum.value(), 0xdff6e62f8c40bb59u) << std::hex << sum.value();
}

TEST(SameBits, OfChainsOfLinearAlgebra) {
  math::Random random(2024, 6, 2);
  Sum sum;
  math::Quat q;
  math::Mat<6, 6> p = math::Mat<6, 6>::identity();
  for (int i = 0; i < 5000; ++i) {
    const math::Vec3 v{random.normal(), random.normal(), random.normal()};
    q = (q * math::Quat::exp(v * 0.01)).normalized();
    const math::Vec3 log = q.log(), turned = q.matrix() * v;
    const math::YawPitchRoll a = q.yaw_pitch_roll();
    math::Mat<6, 6> f = math::Mat<6, 6>::identity();
    f.set_block(0, 3, q.matrix() * 0.01);
    p = (f * p * f.transpose() + 0.001 * math::Mat<6, 6>::identity()).symmetric();
    if (p.trace() > 100) p = math::cholesky(p).value().inverse();
    for (const double x : {q.w, q.x, log.y, turned.z, a.yaw, a.pitch, a.roll, p(0, 0), p(2, 5), p.trace()}) sum.add(x);
  }
  EXPECT_EQ(sum.value(), 0xfc284fc918211d85u) << std::hex << sum.value();
}

}  // namespace
