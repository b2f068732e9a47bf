#include "apps/calibrate/imu_rest.hpp"

#include <gmock/gmock.h>

namespace sinew::app::imu_rest_test {
namespace {

using ::testing::HasSubstr;

constexpr double kG = 9.81;

msg::ImuSample sample(double gyro, double accel_z) { return {{}, {gyro, 0.01, -0.02}, {0, 0, accel_z}}; }

TEST(ImuRest, MeanIsTheBiasOfAnImuThatLiesStill) {
  ImuRest rest;
  for (int i = 0; i < 1000; ++i) rest.add(sample(i % 2 ? 0.031 : 0.029, i % 2 ? kG + 0.1 : kG - 0.1));
  EXPECT_EQ(rest.count(), 1000u);
  EXPECT_NEAR(rest.gyro_mean_radps().x, 0.03, 1e-12);
  EXPECT_NEAR(rest.gyro_mean_radps().z, -0.02, 1e-12);
  EXPECT_NEAR(rest.accel_mean_mps2().z, kG, 1e-9);
  EXPECT_NEAR(rest.gyro_spread_radps(), 0.001, 1e-5);
  EXPECT_EQ(rest.moved(), "");
}

TEST(ImuRest, TellsWhatMovedFromWhatLay) {
  ImuRest shaken, turned, rocked;
  for (int i = 0; i < 100; ++i) {
    shaken.add(sample(0, i % 2 ? kG + 2 : kG - 2));
    turned.add(sample(1.0, kG));
    rocked.add(sample(i % 2 ? 0.2 : -0.2, kG));
  }
  EXPECT_THAT(shaken.moved(), HasSubstr("shaken"));
  EXPECT_THAT(turned.moved(), HasSubstr("it turned: 1.000 rad/s about x"));
  EXPECT_THAT(rocked.moved(), HasSubstr("it moved"));
}

TEST(ImuRest, SixPositionsGiveBiasAndScaleOfEachAxis) {
  // raw = true / scale + bias
  const msg::Vec3 bias{0.2, -0.1, 0.05}, scale{1.01, 0.99, 1.02};
  std::vector<msg::Vec3> means;
  for (const double up : {1.0, -1.0}) {
    means.push_back({bias.x + up * kG / scale.x, bias.y, bias.z});
    means.push_back({bias.x, bias.y + up * kG / scale.y, bias.z});
    means.push_back({bias.x, bias.y, bias.z + up * kG / scale.z});
  }
  std::string why;
  const auto c = six_positions(means, kG, why);
  ASSERT_TRUE(c) << why;
  EXPECT_NEAR(c->bias_mps2.x, bias.x, 1e-12);
  EXPECT_NEAR(c->bias_mps2.y, bias.y, 1e-12);
  EXPECT_NEAR(c->scale.z, scale.z, 1e-12);
  EXPECT_NEAR(c->scale.y, scale.y, 1e-12);
}

TEST(ImuRest, PositionThatIsMissingOrSkewedIsNamed) {
  std::string why;
  EXPECT_FALSE(six_positions({{kG, 0, 0}, {-kG, 0, 0}, {0, kG, 0}, {0, -kG, 0}, {0, 0, kG}}, kG, why));
  EXPECT_EQ(why, "z down: this position is missing");
  EXPECT_FALSE(six_positions({{kG, 0, 0}, {kG, 0.1, 0}}, kG, why));
  EXPECT_EQ(why, "x up: this position was there already");
  EXPECT_FALSE(six_positions({{7, 7, 0}}, kG, why));
  EXPECT_THAT(why, HasSubstr("did not lie flat"));
}

}  // namespace
}  // namespace sinew::app::imu_rest_test
