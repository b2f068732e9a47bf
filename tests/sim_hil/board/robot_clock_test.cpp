// A robot whose clock is not the plant's.
#include "rig.hpp"

namespace sinew::sim_hil::robot_clock_test {
namespace {

TEST(RobotClock, NeverGoesBackAndIsInvertedExactly) {
  for (const std::int64_t ppb : {0, 1, -1, 50'000, -50'000, 1'000'000, -1'000'000})
    for (const std::int64_t begin : {std::int64_t{0}, std::int64_t{999'999'990}, std::int64_t{86'400'000'000'000}}) {
      const RobotClock clock{7s, ppb};
      for (std::int64_t t = begin; t < begin + 5000; ++t) {
        const Time robot = clock.to_robot({t});
        ASSERT_LE(robot, clock.to_robot({t + 1}));
        ASSERT_EQ(clock.to_robot(clock.to_plant(robot)), robot) << ppb << ' ' << t;
        ASSERT_LE(clock.to_plant(robot).ns, t) << "a command is never later than the grant that it answers";
      }
      EXPECT_EQ((clock.to_robot({1'000'000'000}) - Time{0}).count(), 8'000'000'000 + ppb);
    }
}

TEST(SimLockstep, ARobotsOwnClockIsOnTheWireAndThePlantsInThePlant) {
  const RobotClock clock{100s, 50'000};
  Time commit{}, stamp{};
  Rig rig([&](PlantLink& plant) {
    plant.set_robot_clock(clock);
    ASSERT_TRUE(plant.grant(at(0ms)));
    ASSERT_TRUE(plant.send(kImu, imu_sample(1000ms, 5), at(1001ms)));
    ASSERT_TRUE(plant.grant(at(1001ms)));
    const Setpoints acting = plant.setpoints_at(kMotors, at(1001ms));
    commit = acting.commit, stamp = acting.stamp;
    static_cast<void>(plant.grant(at(1002ms)));
  });
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  hal::Actuators* motors = *rig.board->actuators("motors");
  const auto first = rig.board->begin();
  ASSERT_TRUE(first);
  EXPECT_EQ(*first, at(100s)) << "time begins with the first grant";
  EXPECT_EQ(*rig.board->next_grant({}), *first);
  ASSERT_EQ(*rig.board->next_grant(*first), clock.to_robot(at(1001ms)));
  EXPECT_EQ(imu->ready_at(), clock.to_robot(at(1001ms)));
  rig.clock.set(clock.to_robot(at(1001ms)));
  msg::ImuSample s;
  ASSERT_TRUE(*imu->read(s));
  EXPECT_EQ(s.stamp, clock.to_robot(at(1000ms)));
  EXPECT_EQ((s.stamp - at(101s)).count(), 50'000) << "50 ppm of a second";
  msg::ActuatorCommand command = hover(0.5);
  command.stamp = s.stamp;
  ASSERT_TRUE(motors->write(command, 20ms));
  ASSERT_TRUE(rig.board->next_grant(clock.to_robot(at(1001ms))));
  rig.finish();
  EXPECT_EQ(commit, at(1001ms));
  EXPECT_EQ(stamp, at(1000ms));
}

}  // namespace
}  // namespace sinew::sim_hil::robot_clock_test
