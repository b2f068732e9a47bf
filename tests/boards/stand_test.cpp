// The simulated body that sinew-control holds level.
#include "apps/control/stand.hpp"

#include <gtest/gtest.h>

#include <cmath>

using namespace sinew;
using namespace std::chrono_literals;

namespace {

constexpr hal::Time kStart{1'000'000'000};

const hal::Clock& started(hal::ManualClock& clock) {
  clock.set(kStart);
  return clock;
}

struct OnTheStand : testing::Test {
  msg::ImuSample after(hal::Duration d) {
    msg::ImuSample sample;
    for (const hal::Time end = clock.now() + d; clock.now() < end;) {
      clock.set(clock.now() + 1ms);
      const auto read = stand.read(sample);
      EXPECT_TRUE(read && *read);
    }
    return sample;
  }
  void command(std::array<double, 4> value, hal::Duration lease = 1s) {
    msg::ActuatorCommand c;
    for (std::size_t i = 0; i < 4; ++i) c.value[i] = value[i];
    c.count = 4;
    c.armed = 1;
    EXPECT_TRUE(stand.write(c, lease));
  }
  hal::ManualClock clock;
  app::Stand stand{started(clock), 0.3};
};

TEST_F(OnTheStand, AnImuFeelsTheTiltAndNoTurn) {
  const auto s = after(1ms);
  EXPECT_EQ(s.stamp, kStart + 1ms);
  EXPECT_NEAR(s.accel_mps2.z, 9.81 * std::cos(0.3), 1e-9);
  EXPECT_NEAR(std::hypot(s.accel_mps2.x, s.accel_mps2.y), 9.81 * std::sin(0.3), 1e-9);
  EXPECT_EQ(s.gyro_radps.x, 0);
  EXPECT_NEAR(stand.tilt_rad(), 0.3, 1e-9);
}

TEST_F(OnTheStand, ASampleComesOnceAMillisecond) {
  msg::ImuSample s;
  clock.set(clock.now() + 999us);
  EXPECT_FALSE(*stand.read(s));
  clock.set(clock.now() + 1us);
  EXPECT_TRUE(*stand.read(s));
  EXPECT_FALSE(*stand.read(s));
}

TEST_F(OnTheStand, NothingTurnsWithoutMotors) {
  const auto s = after(100ms);
  EXPECT_EQ(s.gyro_radps.y, 0);
  EXPECT_NEAR(stand.tilt_rad(), 0.3, 1e-9);
}

TEST_F(OnTheStand, MoreThrustOnTheLeftRollsRight) {
  command({0.4, 0.6, 0.6, 0.4});  // rear left and front left
  const auto s = after(20ms);
  EXPECT_GT(s.gyro_radps.x, 0.1);  // positive roll: left side up
  EXPECT_NEAR(s.gyro_radps.y, 0, 0.01);
}

TEST_F(OnTheStand, ACommandHoldsForItsLease) {
  command({0.4, 0.6, 0.6, 0.4}, 20ms);
  const double at_the_end = after(19ms).gyro_radps.x;
  const double later = after(200ms).gyro_radps.x, much_later = after(200ms).gyro_radps.x;
  EXPECT_GT(later, at_the_end);  // rotors run down
  EXPECT_LT(much_later, later);  // and then only the drag is left
}

TEST_F(OnTheStand, StopEndsItAtOnce) {
  command({0.4, 0.6, 0.6, 0.4});
  EXPECT_TRUE(stand.stop());
  EXPECT_EQ(after(50ms).gyro_radps.x, 0);
}

TEST_F(OnTheStand, ALongPauseMovesItByTwentyMilliseconds) {
  command({0.4, 0.6, 0.6, 0.4}, 10s);
  app::Stand other(clock, 0.3);
  after(20ms);
  const double steady = stand.tilt_rad();
  msg::ActuatorCommand c;
  c.value = {0.4, 0.6, 0.6, 0.4};
  c.count = 4;
  ASSERT_TRUE(other.write(c, 10s));
  msg::ImuSample s;
  clock.set(clock.now() + 5s);
  ASSERT_TRUE(*other.read(s));
  EXPECT_NEAR(other.tilt_rad(), steady, 1e-6);
}

TEST_F(OnTheStand, CommandsAreCountedFromTheFirst) {
  EXPECT_EQ(stand.first_command(), hal::kNever);
  clock.set(kStart + 7ms);
  command({0, 0, 0, 0});
  clock.set(kStart + 8ms);
  command({0, 0, 0, 0});
  EXPECT_EQ(stand.first_command(), kStart + 7ms);
  EXPECT_EQ(stand.commands(), 2u);
}

TEST_F(OnTheStand, ItHasAnImuAndFourMotorsAndNothingElse) {
  EXPECT_TRUE(stand.sensor<msg::ImuSample>("imu"));
  EXPECT_EQ(stand.sensor<msg::ImuSample>("imu2").error().code, hal::Errc::not_found);
  EXPECT_EQ(stand.sensor<msg::BaroSample>("imu").error().code, hal::Errc::not_found);
  EXPECT_TRUE(stand.actuators("motors"));
  EXPECT_EQ(stand.actuators("legs").error().code, hal::Errc::not_found);
  msg::ActuatorCommand three;
  three.count = 3;
  EXPECT_EQ(stand.write(three, 1s).error().code, hal::Errc::bad_argument);
}

}  // namespace
