// The pendulum's closed forms against its equation of motion.
#include "motion/pendulum.hpp"

#include <gtest/gtest.h>

#include "math/random.hpp"

namespace sinew::motion {
namespace {

constexpr double kOmega = 6.2;

TEST(Pendulum, MovesAsItsEquationIntegratedInSmallSteps) {
  math::Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const double cop = random.uniform(-0.05, 0.05), time = random.uniform(0.01, 0.5);
    double x = random.uniform(-0.05, 0.05), v = random.uniform(-0.3, 0.3);
    const Pendulum begin{x, x + v / kOmega};
    constexpr int kSteps = 20000;
    const double h = time / kSteps;
    for (int i = 0; i < kSteps; ++i) {  // midpoint rule
      const double xm = x + 0.5 * h * v, vm = v + 0.5 * h * kOmega * kOmega * (x - cop);
      x += h * vm;
      v += h * kOmega * kOmega * (xm - cop);
    }
    const Pendulum end = begin.later(cop, kOmega, time);
    EXPECT_NEAR(end.com_m, x, 1e-6) << trial;
    EXPECT_NEAR(end.speed_mps(kOmega), v, 1e-6) << trial;
  }
}

TEST(Pendulum, ArrivesWhereItsPushWasChosenForAndWhenItWasForetold) {
  const Pendulum begin{0.01, 0.03};
  const double cop = cop_for(begin.dcm_m, 0.08, kOmega, 0.2);
  EXPECT_NEAR(begin.later(cop, kOmega, 0.2).dcm_m, 0.08, 1e-12);
  EXPECT_NEAR(time_until(begin.dcm_m, 0.08, cop, kOmega), 0.2, 1e-12);
}

TEST(Pendulum, NeverComesBackFromBeyondTheGroundsPush) {
  EXPECT_EQ(time_until(-0.001, 0.05, 0, kOmega), math::kInf);
  EXPECT_EQ(time_until(0, 0.05, 0, kOmega), math::kInf);
}

TEST(Pendulum, ASteadyWalkBeginsItsThirdStepAsItsFirst) {
  const double period = 0.3, wide = 0.15, narrow = 0.09;
  const double first = steady_dcm(wide, narrow, kOmega, period);
  const double second = wide - Pendulum{0, first}.later(0, kOmega, period).dcm_m;
  EXPECT_NEAR(second, steady_dcm(narrow, wide, kOmega, period), 1e-12);
  const Pendulum begin{0, second};
  EXPECT_NEAR(narrow - begin.later(0, kOmega, period).dcm_m, first, 1e-12);
}

}  // namespace
}  // namespace sinew::motion
