// The values of a text robot as a state.
#include "robots/air_robot/text_pose.hpp"

#include <gtest/gtest.h>

#include "math/linear.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::air_robot {
namespace {

using namespace std::chrono_literals;
using msg::Time;
using rt::StepStatus;

// Its values: 0 x, 1 y, 2 height, 3 roll, 4 pitch, 5 yaw.
class TextPoseTest : public ::testing::Test {
 protected:
  TextPoseTest() {
    const char* const names[] = {"x", "y", "height", "roll", "pitch", "yaw"};
    for (std::size_t i = 0; i < 6; ++i) rig.set(names[i], static_cast<std::int64_t>(i));
    values.count = 6;
    values.value = {};
    for (std::size_t i = 0; i < 6; ++i) tell(i, 0.1 * static_cast<double>(i + 1));
  }
  void tell(std::size_t i, double value, Time when = Time{10'000'000'000}) {
    values.value[i] = value;
    values.measured[i] = values.stamp = when;
  }
  /// The state at 10.5 s; null: none.
  const msg::NavState* state() {
    rig.put("values", values, Time{10'500'000'000});
    if (rig.step(Time{10'500'000'000}, 20ms) != StepStatus::ok) return nullptr;
    return rig.get<msg::NavState>("state");
  }
  static constexpr Time kOld{9'000'000'000};

  TextPose pose;
  rt::ModuleRig rig{pose};
  msg::TextValues values;
};

TEST_F(TextPoseTest, PositionAndAttitudeAreTheValuesOfTheRobot) {
  const msg::NavState* s = state();
  ASSERT_TRUE(s);
  EXPECT_EQ(s->p_world_m.x, 0.1);
  EXPECT_EQ(s->p_world_m.y, 0.2);
  EXPECT_EQ(s->height_m, 0.1 * 3);
  const auto angles = math::Quat(s->q_world_base).yaw_pitch_roll();
  EXPECT_NEAR(angles.roll, 0.4, 1e-12);
  EXPECT_NEAR(angles.pitch, 0.5, 1e-12);
  EXPECT_NEAR(angles.yaw, 0.6, 1e-12);
  EXPECT_TRUE(s->attitude_valid && s->position_valid && s->height_valid);
}

TEST_F(TextPoseTest, AnAttitudeWithOneOldAngleIsNotValid) {
  for (const std::size_t angle : {3u, 4u, 5u}) {
    tell(angle, 0.1, kOld);
    const msg::NavState* s = state();
    ASSERT_TRUE(s);
    EXPECT_FALSE(s->attitude_valid) << angle;
    EXPECT_TRUE(s->position_valid);
    tell(angle, 0.1);
  }
}

TEST_F(TextPoseTest, APositionWithOneOldCoordinateIsNotValid) {
  for (const std::size_t axis : {0u, 1u}) {
    tell(axis, 0.1, kOld);
    const msg::NavState* s = state();
    ASSERT_TRUE(s);
    EXPECT_FALSE(s->position_valid) << axis;
    EXPECT_TRUE(s->attitude_valid);
    tell(axis, 0.1);
  }
}

TEST_F(TextPoseTest, WithoutAFreshHeightThereIsNoState) {
  tell(2, 1, kOld);
  EXPECT_FALSE(state());
}

}  // namespace
}  // namespace sinew::air_robot
