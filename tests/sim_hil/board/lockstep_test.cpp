// The board and a plant in lockstep, over real sockets; the plant runs in a thread of the test.
#include "../memory_stream.hpp"
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

// ---- camera

std::uint8_t pixel(std::size_t i, std::uint32_t number) { return static_cast<std::uint8_t>(i * 7 + number * 31); }

void send_frame(PlantLink& plant, std::uint32_t number, Duration stamp) {
  const FrameSlot slot = plant.begin_frame(kCamera);
  for (std::size_t i = 0; i < slot.pixels.size(); ++i) slot.pixels[i] = pixel(i, number);
  ASSERT_TRUE(plant.send_frame(kCamera, slot, {at(stamp), at(stamp + 20ms), 4'000'000, number}));
}

class SimCameraPath : public testing::TestWithParam<bool> {
 protected:
  SimBoardOptions options() {
    SimBoardOptions o;
    o.accepts_shared_memory = GetParam();
    return o;
  }
};

TEST_P(SimCameraPath, FrameArrivesByteForByte) {
  Rig rig(
      [](PlantLink& plant) {
        send_frame(plant, 1, 10ms);
        ASSERT_TRUE(plant.grant(at(33ms)));
        send_frame(plant, 2, 43ms);
        static_cast<void>(plant.grant(at(66ms)));
      },
      options());
  ASSERT_EQ(rig.board->shares_memory(), GetParam());
  hal::Camera* camera = *rig.board->camera("camera");
  ImageBox image(1024);
  for (std::uint32_t number : {1u, 2u}) {
    const Time until = *rig.board->next_grant(number == 1 ? at(0ms) : at(33ms));
    EXPECT_EQ(camera->ready_at(), at(30ms + (number - 1) * 33ms));
    rig.clock.set(camera->ready_at() - 1ns);
    EXPECT_FALSE(*camera->read(*image));
    rig.clock.set(until);
    ASSERT_TRUE(*camera->read(*image));
    EXPECT_EQ(image->frame_number, number);
    EXPECT_EQ(image->stamp, at(10ms + (number - 1) * 33ms));
    EXPECT_EQ(image->exposure_ns, 4'000'000);
    EXPECT_EQ(image->width, 16u);
    EXPECT_EQ(image->height, 8u);
    EXPECT_EQ(image->stride, 32u);
    EXPECT_EQ(image->format, msg::PixelFormat::yuyv);
    const auto got = image.pixels();
    ASSERT_EQ(got.size(), 256u);
    for (std::size_t i = 0; i < got.size(); ++i) ASSERT_EQ(got[i], pixel(i, number)) << i;
  }
}

TEST_P(SimCameraPath, FrameThatDoesNotFitTheMessageIsDropped) {
  Rig rig(
      [](PlantLink& plant) {
        send_frame(plant, 1, 10ms);
        static_cast<void>(plant.grant(at(33ms)));
      },
      options());
  hal::Camera* camera = *rig.board->camera("camera");
  ASSERT_TRUE(rig.board->next_grant({}));
  rig.clock.set(at(33ms));
  ImageBox small(255);
  EXPECT_EQ(camera->read(*small).error().code, Errc::bad_argument);
  EXPECT_FALSE(*camera->read(*small));
}

TEST_P(SimCameraPath, SkippedFrameNumbersAreLostFrames) {
  Rig rig(
      [](PlantLink& plant) {
        send_frame(plant, 1, 10ms);
        send_frame(plant, 4, 110ms);
        static_cast<void>(plant.grant(at(200ms)));
      },
      options());
  static_cast<void>(*rig.board->camera("camera"));
  ASSERT_TRUE(rig.board->next_grant({}));
  EXPECT_EQ(rig.board->stats().devices[kCamera].lost, 2u);
}

TEST_P(SimCameraPath, SlowReaderGetsTheNewestFramesAndTheRestIsCounted) {
  Rig rig(
      [](PlantLink& plant) {
        for (std::uint32_t n = 0; n < 6; ++n) send_frame(plant, n, n * 33ms);
        static_cast<void>(plant.grant(at(400ms)));
      },
      options());
  hal::Camera* camera = *rig.board->camera("camera");
  ASSERT_TRUE(rig.board->next_grant({}));
  rig.clock.set(at(400ms));
  ImageBox image(256);
  std::vector<std::uint32_t> numbers;
  while (*camera->read(*image)) {
    numbers.push_back(image->frame_number);
    ASSERT_EQ(image.pixels()[100], pixel(100, image->frame_number));
  }
  EXPECT_EQ(numbers, (std::vector<std::uint32_t>{2, 3, 4, 5}));
  EXPECT_EQ(rig.board->stats().devices[kCamera].overflow, 2u);
}

INSTANTIATE_TEST_SUITE_P(Frames, SimCameraPath, testing::Values(true, false),
                         [](const auto& path) { return path.param ? "InSharedMemory" : "InTheStream"; });

TEST(SimLockstep, FrameOverwrittenBeforeItWasReadIsAnErrorNotAPicture) {
  Rig rig([](PlantLink& plant) {
    send_frame(plant, 1, 0ms);
    ASSERT_TRUE(plant.grant(at(33ms)));
    for (std::uint32_t i = 0; i < PlantLink::kFrameSlots; ++i) static_cast<void>(plant.begin_frame(kCamera));
    static_cast<void>(plant.grant(at(34ms)));
  });
  ASSERT_TRUE(rig.board->shares_memory());
  hal::Camera* camera = *rig.board->camera("camera");
  ASSERT_TRUE(rig.board->next_grant({}));
  ASSERT_TRUE(rig.board->next_grant(at(33ms)));
  rig.clock.set(at(34ms));
  ImageBox image(256);
  EXPECT_EQ(camera->read(*image).error().code, Errc::bad_data);
  EXPECT_EQ(rig.board->stats().devices[kCamera].lost, 1u);
  EXPECT_FALSE(*camera->read(*image));
}

// ---- a plant that breaks the protocol

/// A board that hears what is scripted after a proper Welcome.
class Scripted {
 public:
  Scripted() {
    Welcome w;
    w.step = 1ms, w.plant = "script", w.devices = small_plant().devices;
    EXPECT_TRUE(writer.add(Type::welcome, 0, Time{}, w));
  }
  hal::Result<Time> run() {
    auto stream = std::make_unique<MemoryStream>(std::vector(writer.pending().begin(), writer.pending().end()), 100);
    wire = stream.get();
    SimBoardOptions options;
    options.clock = &clock;
    auto opened = SimBoard::open(std::move(stream), options, why);
    if (!opened) return opened.error();
    board = std::move(*opened);
    return board->next_grant({});
  }
  hal::ManualClock clock;
  MessageWriter writer{1 << 16};
  std::unique_ptr<SimBoard> board;
  MemoryStream* wire = nullptr;
  std::string why;
};

std::string offence(void (*commit)(MessageWriter&)) {
  Scripted s;
  commit(s.writer);
  const auto end = s.run();
  if (end) return "accepted";
  EXPECT_EQ(end.error().code, Errc::bad_data);
  s.board->bye("any");
  const std::string said(reinterpret_cast<const char*>(s.wire->written.data()), s.wire->written.size());
  EXPECT_NE(said.find(end.error().where), std::string::npos) << "the plant is told why";
  return end.error().where;
}

TEST(SimBoardRefuses, SamplesOfUnknownDevices) {
  EXPECT_EQ(offence([](MessageWriter& w) { ASSERT_TRUE(w.add(Type::imu, 1, Time{}, Sample<msg::ImuSample>{})); }),
            "sample of a device that the Welcome does not list");
  EXPECT_EQ(offence([](MessageWriter& w) { ASSERT_TRUE(w.add(Type::baro, 77, Time{}, Sample<msg::BaroSample>{})); }),
            "sample of a device that the Welcome does not list");
}

TEST(SimBoardRefuses, SamplesThatGoBackInTime) {
  EXPECT_EQ(offence([](MessageWriter& w) {
              Sample<msg::ImuSample> s;
              s.ready = Time{50};
              ASSERT_TRUE(w.add(Type::imu, kImu, Time{2}, s));
              ASSERT_TRUE(w.add(Type::imu, kImu, Time{1}, s));
            }),
            "samples of a device go back in time");
}

TEST(SimBoardRefuses, FramesThatTheWelcomeDidNotAnnounce) {
  EXPECT_EQ(offence([](MessageWriter& w) {
              FrameInfo f;
              f.width = 8, f.height = 8, f.format = msg::PixelFormat::yuyv;
              ASSERT_TRUE(w.add(Type::frame, kCamera, Time{}, f, 128));
            }),
            "frame is not what the Welcome announced");
  EXPECT_EQ(offence([](MessageWriter& w) {
              FrameInfo f;
              f.width = 16, f.height = 8, f.format = msg::PixelFormat::yuyv, f.slot = 0, f.generation = 1;
              ASSERT_TRUE(w.add(Type::frame, kCamera, Time{}, f));
            }),
            "frame is in a slot that does not exist");
}

TEST(SimBoardRefuses, MessagesOutOfPlace) {
  EXPECT_EQ(offence([](MessageWriter& w) { ASSERT_TRUE(w.add(Type::clock, 0, Time{}, ClockInfo{})); }),
            "message does not belong here");
  EXPECT_EQ(offence([](MessageWriter& w) { ASSERT_TRUE(w.add(Type::start, 0, Time{})); }),
            "message goes in the wrong direction");
}

TEST(SimBoardRefuses, GrantsThatGoBackInTime) {
  Scripted s;
  ASSERT_TRUE(s.writer.add(Type::grant, 0, Time{5}));
  ASSERT_TRUE(s.writer.add(Type::grant, 0, Time{4}));
  ASSERT_EQ(*s.run(), Time{5});
  EXPECT_STREQ(s.board->next_grant(Time{5}).error().where, "grants go back in time");
}

TEST(SimBoardRefuses, APlantOfAnotherVersion) {
  MessageWriter w(4096);
  Welcome welcome;
  welcome.version = 3, welcome.step = 1ms, welcome.plant = "future";
  ASSERT_TRUE(w.add(Type::welcome, 0, Time{}, welcome));
  hal::ManualClock clock;
  SimBoardOptions options;
  options.clock = &clock;
  std::string why;
  auto board =
      SimBoard::open(std::make_unique<MemoryStream>(std::vector(w.pending().begin(), w.pending().end())), options, why);
  ASSERT_FALSE(board);
  EXPECT_EQ(why, "plant speaks version 3 of the simulator protocol, this runtime 1");
}

TEST(SimBoardRefuses, APlantThatRefuses) {
  MessageWriter w(4096);
  ASSERT_TRUE(w.add_text(Type::bye, Time{}, "busy with another robot"));
  hal::ManualClock clock;
  SimBoardOptions options;
  options.clock = &clock;
  std::string why;
  auto board =
      SimBoard::open(std::make_unique<MemoryStream>(std::vector(w.pending().begin(), w.pending().end())), options, why);
  ASSERT_FALSE(board);
  EXPECT_EQ(board.error().code, Errc::closed);
  EXPECT_EQ(why, "plant refused: busy with another robot");
}

TEST(SimBoardRefuses, ToOpenWithoutAClock) {
  std::string why;
  EXPECT_EQ(SimBoard::open(std::make_unique<MemoryStream>(std::vector<std::byte>{}), {}, why).error().code,
            Errc::bad_argument);
}

// ---- a radio

TEST(SimLockstep, ARadioHearsWhenItArrivesAndSaysWithItsCommit) {
  std::vector<PlantLink::Sent> said;
  Rig rig(
      [&](PlantLink& plant) {
        msg::Datagram d;
        d.stamp = at(3ms), d.sender = 2, d.size = 2, d.data[0] = 7;
        ASSERT_TRUE(plant.send(kRadio, d, d.stamp));
        ASSERT_TRUE(plant.grant(at(10ms)));
        ASSERT_TRUE(plant.grant(at(20ms)));
        said.assign(plant.sent().begin(), plant.sent().end());
        plant.forget_sent();
        EXPECT_TRUE(plant.sent().empty());
      },
      {}, plant_with_radio());
  hal::Radio* radio = *rig.board->radio("radio");
  ASSERT_TRUE(rig.board->next_grant({}));
  EXPECT_EQ(radio->ready_at(), at(3ms));
  msg::Datagram d;
  rig.clock.set(at(3ms));
  ASSERT_TRUE(*radio->read(d));
  EXPECT_EQ(d.stamp, at(3ms));
  EXPECT_EQ(d.sender, 2u);
  EXPECT_EQ(d.bytes().size(), 2u);
  EXPECT_EQ(d.data[0], 7);
  rig.clock.set(at(5ms));
  const std::uint8_t hello[] = {'h', 'i'};
  EXPECT_TRUE(radio->send(hello));
  EXPECT_EQ(radio->send({}).error().code, Errc::bad_argument);
  EXPECT_EQ(radio->send(std::vector<std::uint8_t>(1201)).error().code, Errc::bad_argument);
  ASSERT_TRUE(rig.board->next_grant(at(10ms)));
  EXPECT_FALSE(rig.board->next_grant(at(20ms)));
  const hal::RadioStats stats = radio->stats();
  rig.finish();
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0].commit, at(5ms));
  EXPECT_EQ(said[0].datagram.size, 2u);
  EXPECT_EQ(said[0].datagram.data[1], 'i');
  EXPECT_EQ(stats.received, 1u);
  EXPECT_EQ(stats.sent, 1u);
  EXPECT_EQ(stats.sent_bytes, 2u);
}

TEST(SimLockstep, DatagramsThatNobodyReadsAreLostOldestFirstAndCounted) {
  Rig rig(
      [](PlantLink& plant) {
        for (std::uint8_t i = 0; i < 100; ++i) {
          msg::Datagram d;
          d.stamp = at(1ms), d.size = 1, d.data[0] = i;
          ASSERT_TRUE(plant.send(kRadio, d, d.stamp));
        }
        static_cast<void>(plant.grant(at(1ms)));
      },
      {}, plant_with_radio());
  hal::Radio* radio = *rig.board->radio("radio");
  ASSERT_TRUE(rig.board->next_grant({}));
  rig.clock.set(at(1ms));
  const auto heard = drain(*radio);
  ASSERT_EQ(heard.size(), 64u);
  EXPECT_EQ(heard[0].data[0], 36);
  EXPECT_EQ(heard[0].lost, 36u);
  EXPECT_EQ(heard[1].lost, 0u);
  EXPECT_EQ(radio->stats().rx_lost, 36u);
}

// ---- a clock that is not the plant's

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
}  // namespace sinew::sim_hil::lockstep_test
