// A group of joints: what it refuses, several buses, and threads.
#include "drivers/joints/servo_group.hpp"

#include <atomic>
#include <limits>
#include <thread>

#include "hal/platform.hpp"
#include "hal/wake_counter.hpp"
#include "servo_rig.hpp"

namespace sinew::drivers::servo_group_test {
namespace {

using msg::JointMode;

TEST(ServoGroup, CommandsThatCannotBeAreRefusedAndChangeNothing) {
  ServoRig rig;
  rig.add(Protocol::ak80, ServoRig::plain(Protocol::ak80, 1));
  rig.configure();
  ASSERT_TRUE(rig.until(0, JointMode::enabled));
  msg::ActuatorCommand command;
  command.armed = 1;
  command.count = 2;
  auto refused = rig.group().write(command, 1s);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, hal::Errc::bad_argument);
  command.count = 1;
  command.value[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(rig.group().write(command, 1s));
  rig.run(150ms, false);
  EXPECT_EQ(rig.sample.mode[0], JointMode::disabled) << "the lease of the last good one ran out as usual";
}

TEST(ServoGroup, DisarmedMeansNoTorque) {
  ServoRig rig;
  auto& servo = rig.add(Protocol::ak80, ServoRig::plain(Protocol::ak80, 1));
  rig.configure();
  ASSERT_TRUE(rig.until(0, JointMode::enabled));
  msg::ActuatorCommand command;
  command.count = 1;
  ASSERT_TRUE(rig.group().write(command, 1s));
  rig.run(10ms, false);
  EXPECT_FALSE(servo.live());
}

TEST(ServoGroup, FallingBackIsTheStopActionOfEachJointAndComesBeforeTheLeaseEnds) {
  ServoRig rig;
  const StopAction actions[] = {StopAction::damp, StopAction::hold, StopAction::torque_off};
  sim_hil::SimServo* motors[3];
  for (std::uint32_t i = 0; i < 3; ++i) {
    ServoConfig c = ServoRig::plain(Protocol::ak80, i + 1);
    c.stop = actions[i];
    motors[i] = &rig.add(Protocol::ak80, c);
  }
  rig.configure();
  for (std::size_t i = 0; i < 3; ++i) ASSERT_TRUE(rig.until(i, JointMode::enabled));
  rig.write(1h);
  ASSERT_TRUE(rig.group().fall_back(hal::FallBack::own));
  rig.run(20ms, false);
  EXPECT_EQ(rig.sample.mode[0], JointMode::stopping);
  EXPECT_TRUE(motors[0]->live());
  EXPECT_EQ(rig.sample.mode[1], JointMode::stopping);
  EXPECT_TRUE(motors[1]->live());
  EXPECT_EQ(rig.sample.mode[2], JointMode::disabled);
  EXPECT_FALSE(motors[2]->live());
  ASSERT_TRUE(rig.group().fall_back(hal::FallBack::limp));
  rig.run(20ms, false);
  for (const sim_hil::SimServo* motor : motors) EXPECT_FALSE(motor->live());
  ASSERT_TRUE(rig.group().fall_back(hal::FallBack::own));
  rig.run(20ms, false);
  for (const sim_hil::SimServo* motor : motors) EXPECT_FALSE(motor->live()) << "nobody is enabled by it";
}

TEST(ServoGroup, WhatWasStoppedFallsBackToNothing) {
  ServoRig rig;
  ServoConfig c = ServoRig::plain(Protocol::ak80, 1);
  c.stop = StopAction::hold;
  auto& motor = rig.add(Protocol::ak80, c);
  rig.configure();
  ASSERT_TRUE(rig.until(0, JointMode::enabled));
  ASSERT_TRUE(rig.group().stop());
  ASSERT_TRUE(rig.group().fall_back(hal::FallBack::own));
  rig.run(20ms, false);
  EXPECT_FALSE(motor.live());
  EXPECT_EQ(rig.sample.mode[0], JointMode::disabled);
}

TEST(ServoGroup, AfterAFaultItMayAskForADisarmFirst) {
  ServoRig rig;
  ServoConfig c = ServoRig::plain(Protocol::damiao, 1);
  c.needs_disarm = true;
  auto& servo = rig.add(Protocol::damiao, c);
  rig.configure();
  ASSERT_TRUE(rig.until(0, JointMode::enabled));
  servo.fail(0xA);
  ASSERT_TRUE(rig.until(0, JointMode::fault));
  rig.run(5s);
  EXPECT_EQ(rig.sample.mode[0], JointMode::disabled) << "well again, and commands alone do not enable it";
  rig.run(200ms, false);
  rig.run(1s);
  EXPECT_EQ(rig.sample.mode[0], JointMode::disabled) << "nor does a lease that was over meanwhile";
  ASSERT_TRUE(rig.group().fall_back(hal::FallBack::limp));
  rig.run(20ms, false);
  rig.run(1s);
  EXPECT_EQ(rig.sample.mode[0], JointMode::disabled) << "nor the guardian's stop for want of commands";
  ASSERT_TRUE(rig.group().stop());
  rig.run(20ms, false);
  EXPECT_TRUE(rig.until(0, JointMode::enabled));
}

TEST(ServoGroup, NineJointsAreOneTooMany) {
  ServoRig rig;
  for (std::uint32_t id = 1; id <= 8; ++id) rig.add(Protocol::ak80, ServoRig::plain(Protocol::ak80, id));
  auto ninth = std::make_unique<MitServo>(ServoRig::plain(Protocol::ak80, 9), ServoRig::mit(Protocol::ak80));
  const auto refused = rig.group().add(rig.bus[0]->hub, std::move(ninth));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, hal::Errc::bad_argument);
}

TEST(ServoGroup, SampleCarriesJointsOfAllItsBuses) {
  ServoRig rig({}, 2);
  rig.add(Protocol::ak80, ServoRig::plain(Protocol::ak80, 1), 0);
  rig.add(Protocol::cia402, ServoRig::plain(Protocol::cia402, 1), 1);
  rig.configure();
  rig.setpoint[0] = 0.3;
  rig.setpoint[1] = -0.3;
  rig.run(4s);
  EXPECT_EQ(rig.sample.count, 2u);
  EXPECT_EQ(rig.sample.ready, 3u);
  EXPECT_NEAR(rig.sample.position_rad[0], 0.3, 0.02);
  EXPECT_NEAR(rig.sample.position_rad[1], -0.3, 0.02);
  EXPECT_EQ(rig.sample.stamp, std::min(rig.sample.measured[0], rig.sample.measured[1]));
  EXPECT_EQ(rig.group().lost_samples(), 0u);
  EXPECT_GT(rig.samples, 1700u) << "one a tick";
}

TEST(ServoGroup, ReaderThatWasAwayGetsTheNewest) {
  ServoRig rig;
  rig.add(Protocol::ak80, ServoRig::plain(Protocol::ak80, 1));
  rig.configure();
  rig.run(1s);
  for (int i = 0; i < 200; ++i) {  // nobody reads the group
    rig.os.clock.set(rig.os.now() + 1ms);
    rig.bus[0]->sims.poll(rig.os.now());
    rig.bus[0]->hub.step(rig.os.now());
  }
  msg::JointState first, second;
  ASSERT_TRUE(*rig.group().read(first));
  EXPECT_FALSE(*rig.group().read(second)) << "what was old is gone";
  EXPECT_LE(rig.os.now() - first.stamp, 20ms) << "a joint at rest is asked every 12.5 ms";
  EXPECT_GT(rig.group().lost_samples(), 50u);
}

TEST(SeqLock, ReaderNeverSeesHalfOfAValue) {
  struct Pair {
    std::uint64_t a = 0, b = 0;
    double c = 0;
  };
  SeqLock<Pair> lock;
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= 200'000; ++i) lock.store({i, ~i, static_cast<double>(i)});
    done = true;
  });
  Pair seen{0, ~std::uint64_t{0}, 0};
  std::uint64_t wrong = 0, backwards = 0, before = 0;
  while (!done) {
    Pair now = seen;
    if (!lock.load(now)) continue;
    if (now.a != 0 && (now.b != ~now.a || now.c != static_cast<double>(now.a))) ++wrong;
    if (now.a < before) ++backwards;
    before = now.a;
  }
  writer.join();
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(backwards, 0u);
  ASSERT_TRUE(lock.load(seen));
  EXPECT_EQ(seen.a, 200'000u);
}

TEST(ServoGroup, RunsOnThreadsOfTwoBusesAndStopsThem) {
  hal::Os& os = hal::system_os();
  sim_hil::MemoryCan wires[2] = {sim_hil::MemoryCan(1'000'000, &os), sim_hil::MemoryCan(1'000'000, &os)};
  ServoGroup group(os, "head");
  sim_hil::JointModel joints[2];
  sim_hil::MemoryCanPort* far[2];
  sim_hil::SimServo* motors[2];
  std::vector<std::unique_ptr<CanHub>> hubs;
  std::vector<std::unique_ptr<sim_hil::SimServos>> sims;
  for (std::size_t i = 0; i < 2; ++i) {
    hal::CanBus& near = wires[i].attach();
    far[i] = &wires[i].attach();
    ServoConfig c = ServoRig::plain(Protocol::damiao, 1);
    c.name = i == 0 ? "pan" : "tilt";
    c.feedback_timeout = 2s;  // a shared machine may sleep
    CanHubConfig config{.name = c.name, .tick_hz = 200};
    config.thread.name = c.name;
    hubs.push_back(std::make_unique<CanHub>(os, near, config));
    ASSERT_TRUE(group.add(*hubs[i], std::make_unique<MitServo>(c, ServoRig::mit(Protocol::damiao))));
    sims.push_back(std::make_unique<sim_hil::SimServos>(*far[i]));
    motors[i] = &sims[i]->add<sim_hil::SimMitMotor>(
        joints[i], sim_hil::SimMount{},
        sim_hil::SimMitMotor::Parameters{1, 0, ServoRig::mit(Protocol::damiao).type, 0ms});
    std::string why;
    ASSERT_TRUE(hubs[i]->configure(why)) << why;
  }
  hal::WakeCounter wakes;
  group.set_wake(&wakes);
  for (auto& hub : hubs) ASSERT_TRUE(hub->start());
  std::atomic<bool> end{false};
  std::thread world([&] {
    while (!end) {
      for (auto& s : sims) s->poll(os.now());
      std::this_thread::sleep_for(500us);
    }
  });
  const Time give_up = os.now() + 10s;
  msg::JointState state;
  bool there = false;
  while (!there && os.now() < give_up) {
    msg::ActuatorCommand command;
    command.count = 2;
    command.armed = 1;
    command.value = {0.3, -0.3};
    ASSERT_TRUE(group.write(command, 2s));
    while (*group.read(state)) {
      there = state.ready == 3 && std::abs(state.position_rad[0] - 0.3) < 0.03 &&
              std::abs(state.position_rad[1] + 0.3) < 0.03;
    }
    std::this_thread::sleep_for(2ms);
  }
  EXPECT_TRUE(there);
  EXPECT_GT(wakes.count(), 0u);
  group.set_wake(nullptr);
  for (auto& hub : hubs) hub->stop();
  end = true;
  world.join();
  for (auto& s : sims) s->poll(os.now());  // the hubs' last words
  for (const sim_hil::SimServo* motor : motors) EXPECT_FALSE(motor->live()) << "a hub leaves no motor with torque";
}

}  // namespace
}  // namespace sinew::drivers::servo_group_test
