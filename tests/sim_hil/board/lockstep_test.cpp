// The board and a plant in lockstep, over real sockets; the plant runs in a thread of the test.
#include "rig.hpp"
#include "rt/trap.hpp"
#include "trap.hpp"

namespace sinew::sim_hil::lockstep_test {
namespace {

using hal::Errc;

template <class M>
std::vector<M> drain(hal::Sensor<M>& device) {
  std::vector<M> all;
  for (M m; *device.read(m);) all.push_back(m);
  return all;
}

TEST(SimLockstep, SampleIsSeenWhenItIsReadyAndNotBefore) {
  Rig rig([](PlantLink& plant) {
    ASSERT_TRUE(plant.send(kImu, imu_sample(1ms, 5), at(3ms)));
    ASSERT_TRUE(plant.send(kImu, imu_sample(2ms, 6), at(4ms)));
    static_cast<void>(plant.grant(at(10ms)));
  });
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  EXPECT_EQ(imu->ready_at(), hal::kNever);
  ASSERT_EQ(*rig.board->next_grant(at(0ms)), at(10ms));
  msg::ImuSample s;
  EXPECT_EQ(imu->ready_at(), at(3ms));
  rig.clock.set(at(3ms) - 1ns);
  EXPECT_FALSE(*imu->read(s));
  rig.clock.set(at(3ms));
  ASSERT_TRUE(*imu->read(s));
  EXPECT_EQ(s.stamp, at(1ms));
  EXPECT_EQ(s.gyro_radps.x, 5);
  EXPECT_FALSE(*imu->read(s));
  EXPECT_EQ(imu->ready_at(), at(4ms));
}

TEST(SimLockstep, RangeAndBaroCarryTheirValues) {
  Rig rig([](PlantLink& plant) {
    msg::RangeSample range;
    range.stamp = at(1ms), range.range_m = 1.25;
    msg::BaroSample baro;
    baro.stamp = at(1ms), baro.pressure_pa = 101325, baro.temperature_c = 15;
    ASSERT_TRUE(plant.send(kRange, range, at(1ms)));
    ASSERT_TRUE(plant.send(kBaro, baro, at(1ms)));
    static_cast<void>(plant.grant(at(1ms)));
  });
  hal::Range* range = *rig.board->sensor<msg::RangeSample>("range");
  hal::Baro* baro = *rig.board->sensor<msg::BaroSample>("baro");
  ASSERT_TRUE(rig.board->next_grant({}));
  rig.clock.set(at(1ms));
  const auto ranges = drain(*range);
  const auto baros = drain(*baro);
  ASSERT_EQ(ranges.size(), 1u);
  EXPECT_EQ(ranges[0].range_m, 1.25);
  ASSERT_EQ(baros.size(), 1u);
  EXPECT_EQ(baros[0].pressure_pa, 101325);
  EXPECT_EQ(baros[0].temperature_c, 15);
}

TEST(SimLockstep, BatteryCarriesItsValues) {
  PlantDescription with_battery = small_plant();
  const auto id = static_cast<std::uint16_t>(with_battery.devices.size());
  with_battery.devices.emplace_back().kind = DeviceKind::battery;
  with_battery.devices.back().name = "battery";
  Rig rig(
      [id](PlantLink& plant) {
        msg::BatterySample s;
        s.stamp = at(1ms), s.voltage_v = 15.1, s.current_a = 9, s.charge = 0.5;
        EXPECT_FALSE(plant.send(kBaro, s, at(2ms))) << "a device of another kind";
        ASSERT_TRUE(plant.send(id, s, at(2ms)));
        static_cast<void>(plant.grant(at(2ms)));
      },
      {}, with_battery);
  hal::Battery* battery = *rig.board->sensor<msg::BatterySample>("battery");
  ASSERT_TRUE(rig.board->next_grant({}));
  rig.clock.set(at(2ms));
  const auto samples = drain(*battery);
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].stamp, at(1ms));
  EXPECT_EQ(samples[0].voltage_v, 15.1);
  EXPECT_EQ(samples[0].current_a, 9);
  EXPECT_EQ(samples[0].charge, 0.5);
}

PlantDescription plant_with_two_joints() {
  PlantDescription plant = small_plant();
  plant.devices.emplace_back().kind = DeviceKind::joints;
  plant.devices.back().name = "joints";
  plant.devices.back().channels = 2;
  return plant;
}

TEST(SimLockstep, JointsCarryTheirValues) {
  const PlantDescription described = plant_with_two_joints();
  const auto id = static_cast<std::uint16_t>(described.devices.size() - 1);
  Rig rig(
      [id](PlantLink& plant) {
        msg::JointState s;
        s.stamp = at(1ms), s.count = 3;
        EXPECT_FALSE(plant.send(id, s, at(2ms))) << "more joints than the Welcome says";
        s.count = 2, s.ready = 3, s.measured = {at(1ms), at(1500us)}, s.position_rad = {0.5, -0.25};
        s.mode = {msg::JointMode::enabled, msg::JointMode::enabled};
        EXPECT_FALSE(plant.send(kBaro, s, at(2ms))) << "a device of another kind";
        ASSERT_TRUE(plant.send(id, s, at(2ms)));
        static_cast<void>(plant.grant(at(2ms)));
      },
      {}, described);
  hal::Joints* joints = *rig.board->sensor<msg::JointState>("joints");
  ASSERT_TRUE(rig.board->next_grant({}));
  rig.clock.set(at(2ms));
  const auto samples = drain(*joints);
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].stamp, at(1ms));
  EXPECT_EQ(samples[0].measured[1], at(1500us));
  EXPECT_EQ(samples[0].position_rad[1], -0.25);
  EXPECT_EQ(samples[0].mode[1], msg::JointMode::enabled);
  EXPECT_EQ(samples[0].ready, 3u);
}

TEST(SimLockstep, CommandReachesThePlantStepThatFollowsItsCommit) {
  std::vector<double> applied;
  Rig rig([&](PlantLink& plant) {
    for (int i = 0; plant.grant(at(i * 1ms)); ++i) applied.push_back(plant.setpoints_at(kMotors, at(i * 1ms)).value[3]);
  });
  hal::Actuators* motors = *rig.board->actuators("motors");
  Time until = *rig.board->next_grant({});
  for (int i = 1; i <= 5; ++i) {
    rig.clock.set(until);
    if (i == 3) {
      ASSERT_TRUE(motors->write(hover(0.5), 1500us));
    }
    until = *rig.board->next_grant(until);
  }
  rig.finish();
  EXPECT_EQ(applied, (std::vector<double>{0, 0, 0.5, 0.5, 0})) << "the third step's command lasts for two steps";
  EXPECT_EQ(rig.plant_stats.lease_expiries, 1u);
}

TEST(SimLockstep, RoundTripIsOneReadAndOneWriteAndAFrameThreeCopies) {
  constexpr std::uint32_t kRounds = 1000;
  Rig rig([](PlantLink& plant) {
    for (int i = 0;; ++i) {
      if (!plant.send(kImu, imu_sample(i * 1ms), at(i * 1ms))) return;
      if (i % 33 == 0) {
        static_cast<void>(plant.send_frame(kCamera, plant.begin_frame(kCamera), {at(i * 1ms), at(i * 1ms), 0, 0}));
      }
      if (!plant.grant(at(i * 1ms))) return;
    }
  });
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  hal::Camera* camera = *rig.board->camera("camera");
  hal::Actuators* motors = *rig.board->actuators("motors");
  ImageBox image(256);
  Time until = *rig.board->next_grant({});
  std::uint32_t trapped = 0, samples = 0, frames = 0;
  {
    const rt::trap::Scope scope("test", &trapped);
    for (std::uint32_t i = 0; i < kRounds; ++i) {
      rig.clock.set(until);
      msg::ImuSample s;
      while (*imu->read(s)) ++samples;
      while (*camera->read(*image)) ++frames;
      if (!motors->write(hover(0.5), 10ms)) break;
      until = *rig.board->next_grant(until);
    }
  }
  EXPECT_EQ(samples, kRounds);
  EXPECT_GE(frames, kRounds / 33);
  if (!trap::is_set()) GTEST_SKIP() << "no trap in this build: calls were not counted";
  EXPECT_EQ(trapped, 2 * kRounds + 3 * frames)
      << "allocations, locks and system calls, of which one recv and one send a round; generation, pixels, generation";
}

TEST(SimLockstep, CommandsAreCheckedBeforeTheyAreSent) {
  Rig rig([](PlantLink& plant) { static_cast<void>(plant.grant({})); });
  hal::Actuators* motors = *rig.board->actuators("motors");
  EXPECT_EQ(motors->write(hover(0.5), 1ms).error().code, Errc::bad_argument) << "before the start";
  ASSERT_TRUE(rig.board->next_grant({}));
  msg::ActuatorCommand three = hover(0.5);
  three.count = 3;
  EXPECT_EQ(motors->write(three, 1ms).error().code, Errc::bad_argument);
  EXPECT_EQ(motors->write(hover(0.0 / 0.0), 1ms).error().code, Errc::bad_argument);
  EXPECT_EQ(motors->write(hover(0.5), 0ms).error().code, Errc::bad_argument);
  EXPECT_TRUE(motors->write(hover(0.5), 1ms));
  EXPECT_EQ(rig.board->stats().devices[kMotors].samples, 1u);
  EXPECT_EQ(rig.board->stats().devices[kMotors].overflow, 4u);
}

TEST(SimLockstep, MissingDeviceIsNamedWithThoseThatExist) {
  Rig rig([](PlantLink&) {});
  EXPECT_EQ(rig.board->sensor<msg::ImuSample>("imu2").error().code, Errc::not_found);
  EXPECT_EQ(rig.board->problem(),
            "plant 'small' has no imu 'imu2'; it has: imu 'imu', range 'range', baro 'baro', camera 'camera', "
            "actuators 'motors'");
  EXPECT_EQ(rig.board->camera("imu").error().code, Errc::not_found) << "right name, wrong kind";
  EXPECT_EQ(rig.board->radio("imu").error().code, Errc::not_found);
  EXPECT_NE(rig.board->problem().find("plant 'small' has no radio 'imu'; it has:"), std::string::npos);
}

TEST(SimLockstep, PlantThatEndsTheRunIsQuoted) {
  Rig rig([](PlantLink& plant) {
    ASSERT_TRUE(plant.send(kImu, imu_sample(0ms), at(0ms)));
    ASSERT_TRUE(plant.grant(at(0ms)));
    plant.bye("vehicle left the room");
  });
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  const Time until = *rig.board->next_grant({});
  const auto end = rig.board->next_grant(until);
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().code, Errc::closed);
  EXPECT_EQ(rig.board->end_reason(), "vehicle left the room");
  msg::ImuSample s;
  EXPECT_TRUE(*imu->read(s)) << "what came before the end can still be read";
  EXPECT_EQ(imu->read(s).error().code, Errc::closed);
  EXPECT_EQ((*rig.board->actuators("motors"))->write(hover(0.5), 1ms).error().code, Errc::closed);
}

TEST(SimLockstep, ConnectionLostMidRunIsClosedNotAHang) {
  Rig rig([](PlantLink& plant) { ASSERT_TRUE(plant.grant(at(0ms))); });  // and then it dies without a Bye
  const Time until = *rig.board->next_grant({});
  const auto end = rig.board->next_grant(until);
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().code, Errc::closed);
  EXPECT_NE(rig.board->end_reason().find("connection to plant 'small' ended: closed"), std::string::npos);
}

TEST(SimLockstep, SilentPlantTimesOut) {
  SimBoardOptions options;
  options.patience = 20ms;
  Rig rig([](PlantLink& plant) { static_cast<void>(plant.wait_start()); }, options);  // never grants
  const auto end = rig.board->next_grant({});
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().code, Errc::timeout);
}

TEST(SimLockstep, WhoeverWaitsForASilentPlantIsAskedAndMayGiveUp) {
  std::vector<Duration> asked;
  SimBoardOptions options;
  options.patience = 100s;
  options.silence.go_on = [&](Duration silent) {
    asked.push_back(silent);
    return asked.size() < 3;
  };
  Rig rig([](PlantLink& plant) { static_cast<void>(plant.wait_start()); }, options);  // never grants
  const auto end = rig.board->next_grant({});
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().code, Errc::timeout);
  EXPECT_EQ(asked.size(), 3u);
  EXPECT_LT(asked[0], asked[2]);
  EXPECT_FALSE(rig.board->ended_politely());
}

TEST(SimLockstep, APlantThatGoesOnIsToldWithTheTimeOfItsSilence) {
  Duration silent{0};
  bool goes_on = false;
  SimBoardOptions options;
  options.patience = 100s;
  options.silence.go_on = [&](Duration) { return goes_on = true; };
  options.silence.over = [&](Duration length) { silent = length; };
  Rig rig(
      [&](PlantLink& plant) {
        hal::system_os().sleep_until(hal::system_os().now() + 150ms);
        static_cast<void>(plant.grant(at(1ms)));
      },
      options);
  EXPECT_TRUE(rig.board->next_grant({}));
  EXPECT_TRUE(goes_on);
  EXPECT_GT(silent.count(), 0);
}

TEST(SimLockstep, LostSamplesAndGapsAreCounted) {
  Rig rig([](PlantLink& plant) {
    for (int ms : {0, 1, 2, 6, 7}) ASSERT_TRUE(plant.send(kImu, imu_sample(ms * 1ms), at(ms * 1ms)));
    static_cast<void>(plant.grant(at(10ms)));
  });
  static_cast<void>(*rig.board->sensor<msg::ImuSample>("imu"));
  ASSERT_TRUE(rig.board->next_grant({}));
  const DeviceStats stats = rig.board->stats().devices[kImu];
  EXPECT_EQ(stats.samples, 5u);
  EXPECT_EQ(stats.lost, 3u);
  EXPECT_EQ(stats.max_gap_stamp, 4ms);
}

TEST(SimLockstep, SampleAfterTheGrantThatPromisedItIsLate) {
  Rig rig([](PlantLink& plant) {
    ASSERT_TRUE(plant.grant(at(5ms)));
    ASSERT_TRUE(plant.send(kImu, imu_sample(4ms), at(5ms)));
    ASSERT_TRUE(plant.send(kImu, imu_sample(5ms), at(6ms)));
    static_cast<void>(plant.grant(at(6ms)));
  });
  ASSERT_TRUE(rig.board->next_grant(*rig.board->next_grant({})));
  EXPECT_EQ(rig.board->stats().devices[kImu].late, 1u);
}

TEST(SimLockstep, FullDeviceDropsTheOldestAndCountsThem) {
  SimBoardOptions options;
  options.sensor_depth = 3;
  Rig rig(
      [](PlantLink& plant) {
        for (int ms = 0; ms < 10; ++ms) ASSERT_TRUE(plant.send(kImu, imu_sample(ms * 1ms), at(ms * 1ms)));
        static_cast<void>(plant.grant(at(10ms)));
      },
      options);
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  ASSERT_TRUE(rig.board->next_grant({}));
  rig.clock.set(at(5ms));
  auto seen = drain(*imu);
  ASSERT_EQ(seen.size(), 3u);
  EXPECT_EQ(seen[0].stamp, at(3ms));
  EXPECT_EQ(rig.board->stats().devices[kImu].overflow, 3u);
  rig.clock.set(at(10ms));
  seen = drain(*imu);
  ASSERT_EQ(seen.size(), 3u);
  EXPECT_EQ(seen[0].stamp, at(7ms));
  EXPECT_EQ(rig.board->stats().devices[kImu].overflow, 4u);
}

TEST(SimLockstep, DeviceNobodyAskedForDoesNotOverflow) {
  Rig rig([](PlantLink& plant) {
    for (int i = 0; i < 5000; ++i) ASSERT_TRUE(plant.send(kImu, imu_sample(i * 1ms), at(i * 1ms)));
    static_cast<void>(plant.grant(at(5s)));
  });
  ASSERT_TRUE(rig.board->next_grant({}));
  EXPECT_EQ(rig.board->stats().devices[kImu].samples, 5000u);
  EXPECT_EQ(rig.board->stats().devices[kImu].overflow, 0u);
}

TEST(SimLockstep, QueueThatOverflowsWithinOneGrantIsCounted) {
  Rig rig([](PlantLink& plant) {
    for (int i = 0; i < 5000; ++i) ASSERT_TRUE(plant.send(kImu, imu_sample(i * 1ms), at(i * 1ms)));
    static_cast<void>(plant.grant(at(5s)));
  });
  static_cast<void>(*rig.board->sensor<msg::ImuSample>("imu"));
  ASSERT_TRUE(rig.board->next_grant({}));
  EXPECT_EQ(rig.board->stats().devices[kImu].overflow, 5000u - 4096u);
}

TEST(SimLockstep, TruthAndReportReachTheReportOnly) {
  std::vector<double> heights;
  std::string report;
  SimBoardOptions options;
  options.on_truth = [&](Time, const Truth& t) { heights.push_back(t.p_world_m.z); };
  options.on_report = [&](const std::string& json) { report = json; };
  Rig rig(
      [](PlantLink& plant) {
        Truth t;
        t.p_world_m.z = 1.5;
        ASSERT_TRUE(plant.send_truth(at(1ms), t));
        ASSERT_TRUE(plant.send_report(at(1ms), R"({"valid": true})"));
        static_cast<void>(plant.grant(at(1ms)));
      },
      options);
  ASSERT_TRUE(rig.board->next_grant({}));
  EXPECT_EQ(heights, std::vector<double>{1.5});
  EXPECT_EQ(report, R"({"valid": true})");
}

}  // namespace
}  // namespace sinew::sim_hil::lockstep_test
