// The board with a plant that runs on its own time: the reader thread, its queues and wake-ups. Runs under tsan.
#include <algorithm>
#include <atomic>
#include <thread>

#include "hal/linux/priority_mutex.hpp"
#include "rig.hpp"

namespace sinew::sim_hil::free_running_test {
namespace {

using hal::Errc;
using hal::system_os;

SimBoardOptions free_running() {
  SimBoardOptions o;
  o.mode = Mode::free_running;
  o.clock = &system_os();
  o.os = &system_os();
  o.late_after = 1h;
  return o;
}

/// Keeps the line open until the runtime is done with it.
void idle(PlantLink& plant) {
  while (plant.exchange()) system_os().sleep_until(system_os().now() + 1ms);
}

TEST(SimFreeRunning, SampleWakesItsReaderAndStandsOnTheRuntimeClock) {
  Time zero;
  Rig rig(
      [&](PlantLink& plant) {
        zero = system_os().now();
        ASSERT_TRUE(plant.start_clock(at(0ms), zero));
        ASSERT_TRUE(plant.send(kImu, imu_sample(1ms, 5), at(2ms)));
        idle(plant);
      },
      free_running());
  hal::WakeCounter& wakes = rig.wakes;
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  imu->set_wake(&wakes);
  ASSERT_TRUE(rig.board->start());
  msg::ImuSample s;
  ASSERT_TRUE(wakes.wait_until([&] { return *imu->read(s); }));
  EXPECT_EQ(s.stamp, zero + 1ms);
  EXPECT_EQ(s.gyro_radps.x, 5);
  EXPECT_EQ(imu->ready_at(), hal::kNever);
  EXPECT_EQ(rig.board->stats().clock_offset, zero - Time{});
  EXPECT_FALSE(rig.board->stats().remote) << "one machine, one clock";
}

/// A clock at half speed, as for a plant that cannot keep up with life.
class HalfClock final : public hal::Clock {
 public:
  Time now() const noexcept override { return Time{} + (system_os().now() - start_) / 2; }

 private:
  Time start_ = system_os().now();
};

TEST(SimFreeRunning, SlowerPlantIsFollowedOnASlowerClock) {
  HalfClock half;
  SimBoardOptions options = free_running();
  options.clock = &half;
  options.rate = 0.5;
  Time zero, zero_half;
  Rig rig(
      [&](PlantLink& plant) {
        zero_half = half.now();
        zero = system_os().now();
        ASSERT_TRUE(plant.start_clock(at(0ms), zero));
        ASSERT_TRUE(plant.send(kImu, imu_sample(10ms), at(10ms)));
        idle(plant);
      },
      options);
  hal::WakeCounter& wakes = rig.wakes;
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  imu->set_wake(&wakes);
  ASSERT_TRUE(rig.board->start());
  msg::ImuSample s;
  ASSERT_TRUE(wakes.wait_until([&] { return *imu->read(s); }));
  EXPECT_GE(s.stamp, zero_half + 10ms - 1us);
  EXPECT_LE(s.stamp, half.now() + 10ms);
}

TEST(SimFreeRunning, OverflowOfAQueueIsCountedAndTheNewestThatFitRemain) {
  SimBoardOptions options = free_running();
  options.sensor_depth = 4;  // the queue behind it holds 16
  Rig rig(
      [](PlantLink& plant) {
        ASSERT_TRUE(plant.start_clock(at(0ms), system_os().now()));
        for (int i = 0; i < 100; ++i) ASSERT_TRUE(plant.send(kImu, imu_sample(i * 1ms), at(i * 1ms)));
        msg::BaroSample last;
        last.stamp = at(1s);
        ASSERT_TRUE(plant.send(kBaro, last, at(1s)));
        idle(plant);
      },
      options);
  hal::WakeCounter& wakes = rig.wakes;
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  hal::Baro* baro = *rig.board->sensor<msg::BaroSample>("baro");
  baro->set_wake(&wakes);
  ASSERT_TRUE(rig.board->start());
  msg::BaroSample b;
  ASSERT_TRUE(wakes.wait_until([&] { return *baro->read(b); }));
  EXPECT_EQ(rig.board->stats().devices[kImu].samples, 100u);
  EXPECT_EQ(rig.board->stats().devices[kImu].overflow, 84u);
  msg::ImuSample s;
  int read = 0;
  while (*imu->read(s)) ++read;
  EXPECT_EQ(read, 4);
  EXPECT_EQ(rig.board->stats().devices[kImu].overflow, 96u);
}

TEST(SimFreeRunning, ManySamplesPassInOrderWithoutLoss) {
  constexpr int kSamples = 20000;
  SimBoardOptions options = free_running();
  options.sensor_depth = 4096;
  std::atomic<int> taken{0};
  Rig rig(
      [&](PlantLink& plant) {
        ASSERT_TRUE(plant.start_clock(at(0ms), system_os().now()));
        for (int i = 0; i < kSamples; ++i) {
          while (i - taken.load() > 500) system_os().sleep_until(system_os().now() + 100us);
          ASSERT_TRUE(plant.send(kImu, imu_sample(i * 1ms, i), at(i * 1ms)));
          if (i % 10 == 0) {
            ASSERT_TRUE(plant.exchange());
          }
        }
        idle(plant);
      },
      options);
  hal::WakeCounter& wakes = rig.wakes;
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  imu->set_wake(&wakes);
  ASSERT_TRUE(rig.board->start());
  msg::ImuSample s;
  for (int i = 0; i < kSamples; ++i) {
    ASSERT_TRUE(wakes.wait_until([&] { return *imu->read(s); })) << i;
    ASSERT_EQ(s.gyro_radps.x, i);
    taken.store(i);
  }
  EXPECT_EQ(rig.board->stats().devices[kImu].overflow, 0u);
  EXPECT_EQ(rig.board->stats().devices[kImu].lost, 0u);
}

TEST(SimFreeRunning, CommandActsOnThePlantAndRunsOutThere) {
  std::atomic<bool> acted{false}, ran_out{false};
  Rig rig(
      [&](PlantLink& plant) {
        const Time zero = system_os().now();
        ASSERT_TRUE(plant.start_clock(at(0ms), zero));
        while (plant.exchange()) {
          const Setpoints s = plant.setpoints_at(kMotors, Time{} + (system_os().now() - zero));
          if (s.valid && s.value[2] == 0.5) acted = true;
          if (acted && s.lease_over) ran_out = true;
          system_os().sleep_until(system_os().now() + 200us);
        }
      },
      free_running());
  hal::Actuators* motors = *rig.board->actuators("motors");
  ASSERT_TRUE(rig.board->start());
  ASSERT_TRUE(motors->write(hover(0.5, system_os().now() - Time{}), 300ms));
  const Time deadline = system_os().now() + kLong;
  while (!ran_out && system_os().now() < deadline) system_os().sleep_until(system_os().now() + 5ms);
  EXPECT_TRUE(acted);
  EXPECT_TRUE(ran_out);
}

TEST(SimFreeRunning, PlantThatTakesNoCommandsCostsCommandsNotTheLine) {
  std::atomic<bool> jammed{true};
  Rig rig(
      [&](PlantLink& plant) {
        ASSERT_TRUE(plant.start_clock(at(0ms), system_os().now()));
        while (jammed) system_os().sleep_until(system_os().now() + 1ms);
        idle(plant);
      },
      free_running());
  hal::Actuators* motors = *rig.board->actuators("motors");
  ASSERT_TRUE(rig.board->start());
  hal::Status status;
  for (int i = 0; i < 100000 && status; ++i) status = motors->write(hover(0.5), 1ms);
  ASSERT_FALSE(status) << "a kernel buffer that never fills";
  EXPECT_EQ(status.error().code, Errc::busy);
  EXPECT_GE(rig.board->stats().commands_dropped, 1u);
  jammed = false;
  const Time deadline = system_os().now() + kLong;
  do {
    system_os().sleep_until(system_os().now() + 1ms);
    status = motors->write(hover(0.5), 1ms);
  } while (!status && system_os().now() < deadline);
  EXPECT_TRUE(status);
  rig.finish();
  EXPECT_EQ(rig.plant_reason, "runtime closed the connection") << "the framing has survived";
}

TEST(SimFreeRunning, EndOfTheRunWakesReadersAndQuotesThePlant) {
  Rig rig(
      [](PlantLink& plant) {
        ASSERT_TRUE(plant.start_clock(at(0ms), system_os().now()));
        plant.bye("battery empty");
      },
      free_running());
  hal::WakeCounter& wakes = rig.wakes;
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  imu->set_wake(&wakes);
  ASSERT_TRUE(rig.board->start());
  msg::ImuSample s;
  ASSERT_TRUE(wakes.wait_until([&] { return !imu->read(s); }));
  EXPECT_EQ(imu->read(s).error().code, Errc::closed);
  EXPECT_TRUE(rig.board->ended());
  EXPECT_EQ(rig.board->end_reason(), "battery empty");
}

TEST(SimFreeRunning, ConnectionLostMidRunEndsTheRun) {
  Rig rig([](PlantLink& plant) { ASSERT_TRUE(plant.start_clock(at(0ms), system_os().now())); }, free_running());
  hal::WakeCounter& wakes = rig.wakes;
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  imu->set_wake(&wakes);
  ASSERT_TRUE(rig.board->start());
  msg::ImuSample s;
  ASSERT_TRUE(wakes.wait_until([&] { return !imu->read(s); }));
  EXPECT_NE(rig.board->end_reason().find("peer closed the connection"), std::string::npos);
  EXPECT_EQ((*rig.board->actuators("motors"))->write(hover(0.5), 1ms).error().code, Errc::closed);
}

TEST(SimFreeRunning, SampleThatArrivesLongAfterItWasReadyIsLate) {
  SimBoardOptions options = free_running();
  options.late_after = 100ms;
  Rig rig(
      [](PlantLink& plant) {
        ASSERT_TRUE(plant.start_clock(at(10s), system_os().now()));
        ASSERT_TRUE(plant.send(kImu, imu_sample(1s), at(2s)));
        idle(plant);
      },
      options);
  hal::WakeCounter& wakes = rig.wakes;
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  imu->set_wake(&wakes);
  ASSERT_TRUE(rig.board->start());
  msg::ImuSample s;
  ASSERT_TRUE(wakes.wait_until([&] { return *imu->read(s); }));
  EXPECT_EQ(rig.board->stats().devices[kImu].late, 1u);
}

TEST(SimFreeRunning, GapBetweenArrivalsIsMeasured) {
  std::atomic<bool> first_is_read{false};
  Rig rig(
      [&](PlantLink& plant) {
        ASSERT_TRUE(plant.start_clock(at(0s), system_os().now()));
        ASSERT_TRUE(plant.send(kImu, imu_sample(1ms), at(1ms)));
        ASSERT_TRUE(plant.exchange());
        const Time give_up = system_os().now() + kLong;
        while (!first_is_read && system_os().now() < give_up) system_os().sleep_until(system_os().now() + 1ms);
        system_os().sleep_until(system_os().now() + 5ms);
        ASSERT_TRUE(plant.send(kImu, imu_sample(2ms), at(2ms)));
        idle(plant);
      },
      free_running());
  hal::WakeCounter& wakes = rig.wakes;
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  imu->set_wake(&wakes);
  ASSERT_TRUE(rig.board->start());
  msg::ImuSample s;
  ASSERT_TRUE(wakes.wait_until([&] { return *imu->read(s); }));
  first_is_read = true;
  ASSERT_TRUE(wakes.wait_until([&] { return *imu->read(s); }));
  EXPECT_EQ(rig.board->stats().devices[kImu].max_gap_stamp, 1ms);
  EXPECT_GE(rig.board->stats().devices[kImu].max_gap_arrival, 5ms);
}

TEST(SimFreeRunning, PlantWithAnotherHostClockIsRefused) {
  Rig rig([](PlantLink& plant) { static_cast<void>(plant.start_clock(at(0s), system_os().now() + 2h)); },
          free_running());
  const auto status = rig.board->start();
  ASSERT_FALSE(status);
  EXPECT_STREQ(status.error().where, "plant reads another host clock than this machine's");
}

TEST(SimFreeRunning, PlantThatDoesNotAnswerStartWithClockIsRefused) {
  Rig rig([](PlantLink& plant) { static_cast<void>(plant.grant(at(0s))); }, free_running());
  const auto status = rig.board->start();
  ASSERT_FALSE(status);
  EXPECT_STREQ(status.error().where, "plant does not answer Start with Clock");
}

TEST(SimFreeRunning, BellThatWasTakenAwayIsNotRungAgain) {
  Rig rig(
      [](PlantLink& plant) {
        ASSERT_TRUE(plant.start_clock(at(0s), system_os().now()));
        for (int i = 0; plant.send(kImu, imu_sample(i * 1us), at(i * 1us)) && plant.exchange(); ++i) {
        }
      },
      free_running());
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  ASSERT_TRUE(rig.board->start());
  msg::ImuSample s;
  for (int i = 0; i < 200; ++i) {
    auto wakes = std::make_unique<hal::WakeCounter>();  // freed while samples pour in: asan sees a ring too many
    imu->set_wake(wakes.get());
    ASSERT_TRUE(wakes->wait_until([&] { return *imu->read(s); }));
    imu->set_wake(nullptr);
  }
}

TEST(SimFreeRunning, NobodyIsWokenAfterBye) {
  Rig rig(
      [](PlantLink& plant) {
        ASSERT_TRUE(plant.start_clock(at(0s), system_os().now()));
        for (int i = 0; plant.send(kImu, imu_sample(i * 1us), at(i * 1us)) && plant.exchange(); ++i) {
        }
      },
      free_running());
  hal::Imu* imu = *rig.board->sensor<msg::ImuSample>("imu");
  imu->set_wake(&rig.wakes);
  ASSERT_TRUE(rig.board->start());
  msg::ImuSample s;
  ASSERT_TRUE(rig.wakes.wait_until([&] { return *imu->read(s); }));
  rig.board->bye("enough");
  const std::uint32_t rings = rig.wakes.count();
  rig.finish();
  EXPECT_EQ(rig.wakes.count(), rings);
  EXPECT_EQ(rig.plant_reason, "enough") << "also when the plant was writing just then";
}

class SimFreeCamera : public testing::TestWithParam<bool> {};

TEST_P(SimFreeCamera, FramesArriveWholeWhileThePlantGoesOn) {
  constexpr std::uint32_t kFrames = 200;
  SimBoardOptions options = free_running();
  options.accepts_shared_memory = GetParam();
  std::atomic<std::uint32_t> taken{0};
  Rig rig(
      [&](PlantLink& plant) {
        ASSERT_TRUE(plant.start_clock(at(0ms), system_os().now()));
        for (std::uint32_t n = 1; n <= kFrames; ++n) {
          while (n - taken.load() > 3) system_os().sleep_until(system_os().now() + 50us);
          const FrameSlot slot = plant.begin_frame(kCamera);
          for (auto& p : slot.pixels) p = static_cast<std::uint8_t>(n);
          ASSERT_TRUE(plant.send_frame(kCamera, slot, {at(n * 33ms), at(n * 33ms), 0, n}));
          ASSERT_TRUE(plant.exchange() || n == kFrames);  // with the last frame in hand the test may hang up
        }
        idle(plant);
      },
      options);
  hal::WakeCounter& wakes = rig.wakes;
  hal::Camera* camera = *rig.board->camera("camera");
  camera->set_wake(&wakes);
  ASSERT_TRUE(rig.board->start());
  ImageBox image(256);
  for (std::uint32_t n = 1; n <= kFrames; ++n) {
    ASSERT_TRUE(wakes.wait_until([&] { return *camera->read(*image); })) << n;
    ASSERT_EQ(image->frame_number, n);
    for (std::uint8_t p : image.pixels()) ASSERT_EQ(p, static_cast<std::uint8_t>(n));
    taken.store(n);
  }
  EXPECT_EQ(rig.board->stats().devices[kCamera].lost, 0u);
  EXPECT_EQ(rig.board->stats().devices[kCamera].overflow, 0u);
}

INSTANTIATE_TEST_SUITE_P(Frames, SimFreeCamera, testing::Values(true, false),
                         [](const auto& path) { return path.param ? "InSharedMemory" : "InTheStream"; });

// ---- a radio beside the actuators

TEST(SimFreeRunning, ARadioAndActuatorsSendFromThreadsOfTheirOwn) {
  constexpr int kEach = 300;
  SimBoardOptions options = free_running();
  options.send_lock = std::move(*hal::priority_mutex());
  std::atomic<int> heard{0}, wrong{0};
  Rig rig(
      [&](PlantLink& plant) {
        ASSERT_TRUE(plant.start_clock(at(0ms), system_os().now()));
        while (plant.exchange()) {
          for (const PlantLink::Sent& sent : plant.sent()) {
            const auto bytes = sent.datagram.bytes();
            wrong += std::ranges::any_of(bytes, [&](std::uint8_t b) { return b != bytes[0]; });
            ++heard;
          }
          plant.forget_sent();
          system_os().sleep_until(system_os().now() + 200us);
        }
      },
      options, plant_with_radio());
  hal::Radio* radio = *rig.board->radio("radio");
  hal::Actuators* motors = *rig.board->actuators("motors");
  ASSERT_TRUE(rig.board->start());
  std::thread speaker([&] {
    for (int i = 0; i < kEach; ++i) {
      const std::vector<std::uint8_t> bytes(200, static_cast<std::uint8_t>(i));
      EXPECT_TRUE(radio->send(bytes));
      // A plant that has no processor for a while keeps so many in a step and drops the others.
      const Time give_up = system_os().now() + kLong;
      while (heard + 8 < i && system_os().now() < give_up) system_os().sleep_until(system_os().now() + 200us);
    }
  });
  for (int i = 0; i < kEach; ++i) {
    EXPECT_TRUE(motors->write(hover(0.5), 20ms));
    if (i % 8 == 7) system_os().sleep_until(system_os().now() + 500us);
  }
  speaker.join();
  const Time give_up = system_os().now() + kLong;
  while (heard < kEach && system_os().now() < give_up) system_os().sleep_until(system_os().now() + 1ms);
  rig.finish();
  EXPECT_EQ(heard, kEach);
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(rig.plant_stats.commands, static_cast<std::uint64_t>(kEach));
}

TEST(SimFreeRunning, WithoutALockThereIsNoRadio) {
  Rig rig([](PlantLink& plant) { idle(plant); }, free_running(), plant_with_radio());
  EXPECT_EQ(rig.board->radio("radio").error().code, Errc::not_supported);
  EXPECT_NE(rig.board->problem().find("inherits priority"), std::string::npos);
}

}  // namespace
}  // namespace sinew::sim_hil::free_running_test
