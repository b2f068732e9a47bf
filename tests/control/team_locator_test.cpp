// A robot in the frame of its team, and a mate's pad in its own.
#include "control/team_locator.hpp"

#include <gtest/gtest.h>

#include "rt/exec/module_rig.hpp"

namespace sinew::control::team_locator_test {
namespace {

using namespace std::chrono_literals;
using rt::StepStatus;

constexpr msg::Time kNow{1'000'000'000};

msg::NavState state_at(const msg::Vec3& p) {
  msg::NavState s;
  s.stamp = kNow;
  s.p_world_m = p;
  s.position_valid = s.attitude_valid = 1;
  s.p_std_m = 0.1;
  s.tilt_std_rad = 0.01;
  return s;
}

/// Starts at (2, 1) of the team, and looks along its y.
struct Locator {
  TeamLocator module;
  rt::ModuleRig rig{module};

  Locator() {
    rig.set("start_x_m", 2.0);
    rig.set("start_y_m", 1.0);
    rig.set("start_yaw_deg", 90.0);
  }
};

TEST(TeamLocator, SaysItsPoseByTheStart) {
  Locator l;
  l.rig.put("state", state_at({3, 0, 1}));
  ASSERT_EQ(l.rig.step(kNow, 50ms), StepStatus::ok);
  const auto* pose = l.rig.get<msg::TeamPose>("pose");
  ASSERT_NE(pose, nullptr);
  EXPECT_NEAR(pose->p_team_m.x, 2, 1e-12);
  EXPECT_NEAR(pose->p_team_m.y, 4, 1e-12) << "3 m ahead, and ahead is the team's y";
  EXPECT_NEAR(pose->p_team_m.z, 1, 1e-12);
  EXPECT_NEAR(math::Quat(pose->q_team_base).yaw(), math::kPi / 2, 1e-9);
  // 0.1 m by the filter, 2 cm of the start, and 1 degree of it at 3 m, across.
  const double along = 0.1 * 0.1 + 0.02 * 0.02, turn = math::kPi / 180;
  EXPECT_NEAR(pose->covariance[7], along, 1e-9);
  EXPECT_NEAR(pose->covariance[0], along + 9 * turn * turn, 1e-9);
  EXPECT_NEAR(pose->covariance[35], turn * turn, 1e-12);
}

TEST(TeamLocator, SaysThePadOnlyOnceItIsKnown) {
  Locator l;
  msg::NavState state = state_at({3, 0, 1});
  l.rig.put("state", state);
  ASSERT_EQ(l.rig.step(kNow, 50ms), StepStatus::ok);
  EXPECT_EQ(l.rig.get<msg::PlaceEstimate>("pad"), nullptr);
  state.pad_known = 1;
  state.pad_world_m = {1, 0.5, 0};
  l.rig.put("state", state);
  ASSERT_EQ(l.rig.step(kNow, 50ms), StepStatus::ok);
  const auto* pad = l.rig.get<msg::PlaceEstimate>("pad");
  ASSERT_NE(pad, nullptr);
  EXPECT_NEAR(pad->p_m.x, 2 - 0.5, 1e-12);
  EXPECT_NEAR(pad->p_m.y, 1 + 1, 1e-12);
  // 0.1 m of the own place, 0.1 m of the sighting, 2 cm of the start, which is turned by a degree.
  const double turn = math::kPi / 180;
  EXPECT_NEAR(pad->covariance_m2[4], 0.01 + 0.01 + 0.0004 + 0.25 * turn * turn, 1e-9);
}

TEST(TeamLocator, BringsAMatesPadIntoItsOwnFrameAndNoSurer) {
  Locator l;
  msg::PlaceEstimate pad;
  pad.stamp = kNow;
  pad.p_m = {1.5, 2, 0};
  pad.covariance_m2 = {0.04, 0, 0, 0, 0.01, 0, 0, 0, 0.01};
  l.rig.put("state", state_at({0, 0, 0}));
  l.rig.put("mate_pad", pad);
  ASSERT_EQ(l.rig.step(kNow, 50ms), StepStatus::ok);
  const auto* told = l.rig.get<msg::PlaceEstimate>("told_pad");
  ASSERT_NE(told, nullptr);
  EXPECT_EQ(told->stamp, kNow);
  EXPECT_NEAR(told->p_m.x, 1, 1e-12);
  EXPECT_NEAR(told->p_m.y, 0.5, 1e-12);
  EXPECT_GT(told->covariance_m2[0], 0.01) << "the team's y is ahead here";
  EXPECT_GT(told->covariance_m2[4], 0.04);
  EXPECT_LT(told->covariance_m2[4], 0.05);
}

TEST(TeamLocator, IsStaleWithoutAFreshState) {
  Locator l;
  EXPECT_EQ(l.rig.step(kNow, 50ms), StepStatus::stale);
  l.rig.put("state", state_at({0, 0, 0}));
  EXPECT_EQ(l.rig.step(kNow + 200ms, 50ms), StepStatus::stale);
  EXPECT_EQ(l.rig.get<msg::TeamPose>("pose"), nullptr);
}

}  // namespace
}  // namespace sinew::control::team_locator_test
