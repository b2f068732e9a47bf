#include "robots/air_robot/steer.hpp"

#include <gtest/gtest.h>

#include "math/linear.hpp"
#include "msg/text_values.hpp"
#include "robots/air_robot/text_pose.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::air_robot::steer_test {
namespace {

using msg::Time;
using namespace std::chrono_literals;

constexpr Time kNow{2'000'000'000};

struct SteerRig {
  Steer steer;
  rt::ModuleRig rig;
  msg::VelocityCommand velocity;
  msg::ActuatorCommand joints;

  explicit SteerRig(std::int64_t count) : rig(steer) {
    rig.set("channels", std::int64_t{4});
    rig.set("joint_count", count);
    rig.set("forward_1", 1.0);
    rig.set("turn_4", -2.0);
    velocity.stamp = joints.stamp = kNow;
    velocity.linear_mps.x = 0.5, velocity.angular_radps.z = 0.25;
    joints.count = 2, joints.armed = 1;
    joints.value = {0.7, -0.3};
  }
  rt::StepStatus step(bool with_joints) {
    rig.put("velocity", velocity);
    if (with_joints) rig.put("joints", joints);
    return rig.step(kNow, 10ms);
  }
};

TEST(Steer, JointsAreTheChannelsBehindTheDrives) {
  SteerRig r(2);
  ASSERT_EQ(r.step(true), rt::StepStatus::ok);
  const auto* out = r.rig.get<msg::ActuatorCommand>("drives");
  ASSERT_NE(out, nullptr);
  EXPECT_EQ(out->count, 6u);
  EXPECT_EQ(out->armed, 1u);
  EXPECT_EQ(out->value[0], 0.5);
  EXPECT_EQ(out->value[3], -0.5);
  EXPECT_EQ(out->value[4], 0.7);
  EXPECT_EQ(out->value[5], -0.3);
}

TEST(Steer, WithoutJointsItIsTheDrivesAlone) {
  SteerRig r(0);
  ASSERT_EQ(r.step(false), rt::StepStatus::ok);
  EXPECT_EQ(r.rig.get<msg::ActuatorCommand>("drives")->count, 4u);
}

TEST(Steer, JointsThatAreMissingOldOrOfAnotherNumberGiveNoCommand) {
  EXPECT_EQ(SteerRig(2).step(false), rt::StepStatus::stale);
  SteerRig old(2);
  old.joints.stamp = Time{1};
  EXPECT_EQ(old.step(true), rt::StepStatus::stale);
  SteerRig other(2);
  other.joints.count = 3;
  EXPECT_EQ(other.step(true), rt::StepStatus::fault);
  SteerRig many(5);
  many.joints.count = 5;
  EXPECT_EQ(many.step(true), rt::StepStatus::fault) << "nine channels";
}

TEST(Steer, JointsThatAreGivenUpDisarmTheGroup) {
  SteerRig r(2);
  r.joints.armed = 0;
  ASSERT_EQ(r.step(true), rt::StepStatus::ok);
  EXPECT_EQ(r.rig.get<msg::ActuatorCommand>("drives")->armed, 0u);
}

TEST(TextPose, RatesOfItsAnglesBecomeRatesAboutItsAxes) {
  TextPose pose;
  rt::ModuleRig rig{pose};
  const char* names[] = {"height", "roll", "pitch", "yaw", "roll_rate", "pitch_rate", "yaw_rate"};
  for (std::size_t i = 0; i < std::size(names); ++i) rig.set(names[i], static_cast<std::int64_t>(i));
  msg::TextValues values;
  values.stamp = kNow;
  values.count = 7;
  const double content[] = {1.5, 0.2, -0.1, 1.0, 0.3, -0.4, 0.5};
  for (std::size_t i = 0; i < 7; ++i) values.value[i] = content[i], values.measured[i] = kNow;
  values.measured[3] = Time{kNow.ns - 50'000'000};
  rig.put("values", values);
  ASSERT_EQ(rig.step(kNow, 10ms), rt::StepStatus::ok);
  const auto* out = rig.get<msg::NavState>("state");
  ASSERT_NE(out, nullptr);
  EXPECT_EQ(out->stamp.ns, kNow.ns - 50'000'000) << "of the attitude, which its rates carry on";
  // The same by differences.
  constexpr double kStep = 1e-6;
  const auto at = [&](double t) {
    return math::Quat::from_yaw_pitch_roll({1.0 + 0.5 * t, -0.1 - 0.4 * t, 0.2 + 0.3 * t});
  };
  const math::Vec3 rate = (at(0).conjugate() * at(kStep)).log() / kStep;
  EXPECT_NEAR(out->gyro_radps.x, rate.x, 1e-5);
  EXPECT_NEAR(out->gyro_radps.y, rate.y, 1e-5);
  EXPECT_NEAR(out->gyro_radps.z, rate.z, 1e-5);
}

}  // namespace
}  // namespace sinew::air_robot::steer_test
