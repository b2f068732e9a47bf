#include "control/rotor_allocation.hpp"

#include <gmock/gmock.h>

#include <algorithm>

#include "math/random.hpp"

namespace sinew::control::rotor_allocation_test {
namespace {

using math::Vec3;

const RotorParams kRotors;

/// The effect of four commands, from the positions and senses of the rotors.
struct Effect {
  Vec3 torque_nm;
  double thrust_n = 0;
};
Effect effect(const std::array<double, 4>& command, const RotorParams& r) {
  constexpr double kX[4] = {1, -1, 1, -1}, kY[4] = {-1, 1, 1, -1}, kSpin[4] = {1, 1, -1, -1};
  Effect e;
  for (std::size_t i = 0; i < 4; ++i) {
    const double thrust = command[i] * r.thrust_max_n;
    e.thrust_n += thrust;
    e.torque_nm += cross(Vec3{kX[i] * r.arm_x_m, kY[i] * r.arm_y_m, 0}, Vec3{0, 0, thrust});
    e.torque_nm.z -= kSpin[i] * r.torque_per_thrust_m * thrust;
  }
  return e;
}

struct Wish {
  Vec3 torque_nm;
  double thrust_n;
};
Wish random_wish(math::Random& r, double size) {
  return {{r.uniform(-1, 1) * size, r.uniform(-1, 1) * size, r.uniform(-0.2, 0.2) * size}, r.uniform(-5, 30)};
}

TEST(RotorAllocation, HoverIsFourEqualCommands) {
  const RotorAllocation a = allocate({}, 12, kRotors);
  EXPECT_THAT(a.command, ::testing::Each(::testing::DoubleEq(0.5)));
}

TEST(RotorAllocation, CommandsNeverLeaveIdleToOne) {
  math::Random r(1);
  for (int i = 0; i < 100000; ++i) {
    const Wish w = random_wish(r, r.uniform(0, 10));
    for (const double c : allocate(w.torque_nm, w.thrust_n, kRotors).command) {
      ASSERT_GE(c, kRotors.idle);
      ASSERT_LE(c, 1.0);
    }
  }
}

TEST(RotorAllocation, WishThatFitsIsMetExactly) {
  math::Random r(2);
  int fitted = 0;
  for (int i = 0; i < 20000; ++i) {
    std::array<double, 4> command;
    for (double& c : command) c = r.uniform(kRotors.idle, 1);
    const Effect wish = effect(command, kRotors);  // fits: these commands do it
    const RotorAllocation a = allocate(wish.torque_nm, wish.thrust_n, kRotors);
    for (std::size_t k = 0; k < 4; ++k) ASSERT_NEAR(a.command[k], command[k], 1e-9);
    ++fitted;
  }
  EXPECT_EQ(fitted, 20000);
}

TEST(RotorAllocation, RollAndPitchSurviveWheneverTheirSpreadFits) {
  math::Random r(3);
  int limited = 0;
  for (int i = 0; i < 50000; ++i) {
    const Wish w = random_wish(r, 3);
    const RotorAllocation a = allocate(w.torque_nm, w.thrust_n, kRotors);
    const Effect e = effect(a.command, kRotors);
    limited += a.tilt_share < 1;
    ASSERT_NEAR(e.torque_nm.x, a.tilt_share * w.torque_nm.x, 1e-9);
    ASSERT_NEAR(e.torque_nm.y, a.tilt_share * w.torque_nm.y, 1e-9);
    ASSERT_NEAR(e.torque_nm.z, a.yaw_share * w.torque_nm.z, 1e-9);
    const double reach = (std::abs(w.torque_nm.x) + std::abs(w.torque_nm.y)) / (4 * kRotors.arm_x_m) * 2;
    if (reach < (1 - kRotors.idle) * kRotors.thrust_max_n) {
      ASSERT_EQ(a.tilt_share, 1);
    }
  }
  EXPECT_GT(limited, 100) << "the test must reach the limit";
}

TEST(RotorAllocation, ThrustMovesOnlyAsFarAsRollAndPitchNeed) {
  const RotorAllocation a = allocate({1.0, 0, 0}, 0.2, kRotors);
  EXPECT_NEAR(*std::min_element(a.command.begin(), a.command.end()), kRotors.idle, 1e-12);
  EXPECT_NEAR(effect(a.command, kRotors).torque_nm.x, 1.0, 1e-12);
}

TEST(RotorAllocation, YawGivesWayToThrust) {
  const RotorAllocation a = allocate({0, 0, 0.5}, 24, kRotors);
  EXPECT_EQ(a.yaw_share, 0);
  EXPECT_NEAR(a.thrust_n, 24, 1e-12);
}

}  // namespace
}  // namespace sinew::control::rotor_allocation_test
