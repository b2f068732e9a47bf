#include "control/position_law.hpp"

#include <gmock/gmock.h>

#include "control/inertial_filter.hpp"

namespace sinew::control::position_law_test {
namespace {

using math::Quat;
using math::Vec3;
using msg::FlightMode;

msg::NavState hovering() {
  msg::NavState n;
  n.attitude_valid = n.height_valid = n.position_valid = 1;
  n.p_world_m.z = n.height_m = 1.5;
  return n;
}

msg::FlightSetpoint go_to(const Vec3& p) {
  msg::FlightSetpoint s;
  s.p_world_m = p.to<msg::Vec3>();
  s.mode = FlightMode::position;
  s.armed = 1;
  return s;
}

Vec3 up_of(const msg::AttitudeSetpoint& a) { return Quat(a.q_world_base).rotate({0, 0, 1}); }

TEST(PositionLaw, HoverAtItsPlaceIsLevelAndCarriesTheWeight) {
  PositionLaw law;
  const auto a = law.step(hovering(), go_to({0, 0, 1.5}), 0.005);
  EXPECT_NEAR(a.thrust_n, 1.2 * kGravity, 1e-9);
  EXPECT_NEAR(up_of(a).z, 1, 1e-12);
}

TEST(PositionLaw, LeansTowardsItsGoalButNeverFurtherThanAllowed) {
  PositionLaw law;
  for (int i = 0; i < 2000; ++i) {
    const auto a = law.step(hovering(), go_to({50, -20, 1.5}), 0.005);
    const Vec3 up = up_of(a);
    ASSERT_GT(up.x, 0);
    ASSERT_LT(up.y, 0);
    ASSERT_LE(math::acos(up.z), law.params.tilt_rad + 1e-9);
    ASSERT_LE(a.thrust_n, law.params.thrust_max_n);
  }
}

TEST(PositionLaw, IntegralDoesNotWindUpAtTheLimit) {
  PositionLaw law;
  for (int i = 0; i < 4000; ++i) law.step(hovering(), go_to({50, 0, 1.5}), 0.005);  // twenty seconds at the limit
  const auto a = law.step(hovering(), go_to({0, 0, 1.5}), 0.005);
  EXPECT_LT(math::fabs(up_of(a).x), 0.02) << "level at once when the goal is here";
}

TEST(PositionLaw, SteadyWindIsHeldByTheIntegral) {
  PositionLaw law;
  msg::NavState n = hovering();
  double v = 0;
  for (int i = 0; i < 6000; ++i) {  // a point mass in a wind of 1 m/s^2
    const Vec3 up = up_of(law.step(n, go_to({0, 0, 1.5}), 0.005));
    v += 0.005 * (kGravity * up.x / up.z - 1.0);
    n.v_world_mps.x = v;
    n.p_world_m.x += 0.005 * v;
  }
  EXPECT_NEAR(n.p_world_m.x, 0, 0.01);
}

TEST(PositionLaw, DisarmedOrIdleGivesNoThrustAndForgets) {
  PositionLaw law;
  for (int i = 0; i < 200; ++i) law.step(hovering(), go_to({1, 0, 1.5}), 0.005);
  msg::FlightSetpoint idle;
  idle.armed = 1;
  EXPECT_EQ(law.step(hovering(), idle, 0.005).thrust_n, 0);
  PositionLaw fresh;
  EXPECT_EQ(law.step(hovering(), go_to({1, 0, 1.5}), 0.005).q_world_base,
            fresh.step(hovering(), go_to({1, 0, 1.5}), 0.005).q_world_base);
}

TEST(PositionLaw, WithoutHeightItSinksOnALittleLessThanItHadLearned) {
  PositionLaw law;
  msg::NavState n = hovering();
  n.v_world_mps.z = -0.1;  // too heavy: it keeps sinking, and the integral learns
  for (int i = 0; i < 400; ++i) law.step(n, go_to({0, 0, 1.5}), 0.005);
  n.v_world_mps.z = 0;
  const double learned = law.step(n, go_to({0, 0, 1.5}), 0.005).thrust_n;
  EXPECT_GT(learned, 1.2 * kGravity + 0.1);
  n.position_valid = n.height_valid = 0;
  EXPECT_NEAR(law.step(n, go_to({0, 0, 1.5}), 0.005).thrust_n, 0.97 * learned, 0.02);
}

TEST(PositionLaw, WithoutPositionTheHeightIsStillControlled) {
  PositionLaw law;
  msg::NavState n = hovering();
  n.position_valid = 0;
  n.p_world_m.x = 5;
  const auto low = law.step(n, go_to({0, 0, 2.0}), 0.005);
  EXPECT_GT(low.thrust_n, 1.2 * kGravity);
  EXPECT_NEAR(up_of(low).x, 0, 1e-9) << "a position that is not known pulls nowhere";
}

}  // namespace
}  // namespace sinew::control::position_law_test
