#include "control/imu_selector.hpp"

#include <gmock/gmock.h>

namespace sinew::control::imu_selector_test {
namespace {

using math::Vec3;

struct Bench {
  ImuSelector selector;
  std::int64_t now_ns = 0;
  std::uint32_t count = 3;
  Vec3 gyro_error[3];
  double fit[3] = {0.1, 0.1, 0.1};
  bool silent[3] = {false, false, false};

  std::uint32_t run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 1000); ++i) {
      now_ns += 1'000'000;
      for (std::uint32_t k = 0; k < count; ++k) {
        if (silent[k]) continue;
        selector.add_sample(k, {now_ns}, Vec3{0.1, 0.2, 0.3} + gyro_error[k], {0, 0, 9.81});
        if (i % 100 == 0) selector.add_fit(k, fit[k], 0.1);
      }
      selector.choose(count, {now_ns});
    }
    return selector.chosen();
  }
};

TEST(ImuSelector, StaysWithTheFirstWhileAllAgree) {
  Bench b;
  EXPECT_EQ(b.run(5), 0U);
}

TEST(ImuSelector, ThreeVoteOneOutThatDiffersAndTakeItBackOnceItHasAgreed) {
  Bench b;
  b.run(1);
  b.gyro_error[0] = {0, 1, 0};
  EXPECT_NE(b.run(0.5), 0U);
  EXPECT_TRUE(b.selector.voted_out(0));
  b.gyro_error[0] = {};
  b.run(1);
  EXPECT_TRUE(b.selector.voted_out(0));
  b.run(2);
  EXPECT_FALSE(b.selector.voted_out(0));
}

TEST(ImuSelector, OfTwoTheOneWhoseForecastsFitIsTaken) {
  Bench b;
  b.count = 2;
  b.run(3);
  b.fit[0] = 0.9;
  EXPECT_EQ(b.run(0.5), 0U) << "not at once";
  EXPECT_EQ(b.run(6), 1U);
}

TEST(ImuSelector, TwoThatDifferDoNotVoteEachOtherOut) {
  Bench b;
  b.count = 2;
  b.gyro_error[0] = {0, 1, 0};
  b.run(2);
  EXPECT_FALSE(b.selector.voted_out(0));
  EXPECT_FALSE(b.selector.voted_out(1));
}

TEST(ImuSelector, SilentOneIsLeftAtOnce) {
  Bench b;
  b.count = 2;
  b.run(1);
  b.silent[0] = true;
  EXPECT_EQ(b.run(0.03), 1U);
}

}  // namespace
}  // namespace sinew::control::imu_selector_test
