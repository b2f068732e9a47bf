// One bus and everything on it: load, numbers, unknown and hostile frames, a bus that goes away.
#include "drivers/joints/can_hub.hpp"

#include "drivers/joints/dronecan_servo.hpp"
#include "hal/platform.hpp"
#include "servo_rig.hpp"

namespace sinew::drivers::can_hub_test {
namespace {

using msg::JointMode;

TEST(CanHub, LoadThatDoesNotFitIsSaidBeforeTheStart) {
  ServoRig rig({.name = "can0", .tick_hz = 1000});
  for (std::uint32_t id = 1; id <= 8; ++id) rig.add(Protocol::cia402, ServoRig::plain(Protocol::cia402, id));
  std::string why;
  const auto ok = rig.bus[0]->hub.configure(why);
  ASSERT_FALSE(ok);
  EXPECT_EQ(ok.error().code, hal::Errc::bad_argument);
  EXPECT_EQ(why,
            "max_load_percent: 90: 8 servos at 1000 Hz need 271 % of 1000 kbit/s: fewer servos, a lower tick_hz, or "
            "another bus");
}

TEST(CanHub, MeasuredLoadIsWithinThePlannedOne) {
  ServoRig rig({.name = "can0", .tick_hz = 500});
  for (std::uint32_t id = 1; id <= 4; ++id) rig.add(Protocol::cia402, ServoRig::plain(Protocol::cia402, id));
  rig.configure();
  rig.run(5s);
  const CanHubStats stats = rig.bus[0]->hub.stats();
  EXPECT_GT(stats.measured_load, 0.5);
  EXPECT_LT(stats.measured_load, stats.planned_load);
  EXPECT_LT(stats.planned_load, stats.measured_load * 1.2) << "planned for ticks that come a tenth earlier";
}

TEST(CanHub, TwoServosOfOneNumberAreRefused) {
  ServoRig rig;
  rig.add(Protocol::ak80, ServoRig::plain(Protocol::ak80, 4));
  ServoConfig other = ServoRig::plain(Protocol::ak80, 4);
  other.name = "elbow";
  rig.add(Protocol::ak80, other);
  std::string why;
  EXPECT_FALSE(rig.bus[0]->hub.configure(why));
  EXPECT_EQ(why, "servo 'elbow': id: 4: a number that no other servo on its bus has: 'joint4' has it");
}

TEST(CanHub, TwoDronecanDevicesOfOnePlaceAreRefusedAndOfTwoKindsAreNot) {
  const auto configure = [](std::uint32_t second_id, bool second_is_esc) {
    ServoRig rig;
    CanHub& hub = rig.bus[0]->hub;
    auto service = std::make_unique<DronecanNode>(DronecanNodeConfig{});
    DronecanNode& node = *service;
    hub.add(std::move(service));
    ServoConfig c = ServoRig::plain(Protocol::ak80, 20);
    c.stop = StopAction::hold;
    EXPECT_TRUE(rig.group().add(hub, std::make_unique<DronecanServo>(c, DronecanServoOptions{}, node)));
    c.name = "elbow";
    c.node_id = 21;
    c.actuator_id = second_id;
    DronecanServoOptions o;
    if (second_is_esc) o.esc = true, o.esc_full_radps = 100, c.mode = ServoMode::velocity;
    EXPECT_TRUE(rig.group().add(hub, std::make_unique<DronecanServo>(c, o, node)));
    std::string why;
    (void)hub.configure(why);
    return why;
  };
  EXPECT_EQ(configure(0, false),
            "servo 'elbow': actuator_id: 0: a place that no other servo on its bus has: 'joint20' has it");
  EXPECT_EQ(configure(1, false), "");
  EXPECT_EQ(configure(0, true), "");
}

/// Takes ten frames, and lets one of them go each 100 us, as a real one at 1 Mbit/s.
class NarrowBus final : public hal::CanBus {
 public:
  explicit NarrowBus(hal::Os& os) : os_(os) {}
  hal::Result<bool> read(msg::CanFrame&) noexcept override { return false; }
  hal::Status send(const msg::CanFrame& frame, Time) noexcept override {
    const Time now = os_.now();
    while (waiting_ > 0 && now >= next_out_) --waiting_, next_out_ = next_out_ + 100us;
    if (waiting_ == 10) return hal::Error{hal::Errc::timeout, "no room"};
    if (waiting_++ == 0) next_out_ = now + 100us;
    sent.push_back(frame);
    return {};
  }
  hal::Status set_filters(std::span<const hal::CanFilter>) override { return {}; }
  void set_wake(hal::Wake*) noexcept override {}
  hal::CanStats stats() const noexcept override { return {}; }
  std::uint32_t bit_rate() const noexcept override { return 1'000'000; }
  std::vector<msg::CanFrame> sent;

 private:
  hal::Os& os_;
  int waiting_ = 0;
  Time next_out_{};
};

TEST(CanHub, FarewellsAllGoOutThroughAQueueThatIsTooShortForThem) {
  hal::Os& os = hal::system_os();
  NarrowBus bus(os);
  ServoGroup group(os, "arm");
  CanHubConfig config{.name = "can0", .tick_hz = 50};
  config.thread.name = "can0";
  CanHub hub(os, bus, config);
  for (std::uint32_t id = 1; id <= 8; ++id) {
    ASSERT_TRUE(group.add(hub, std::make_unique<Cia402Servo>(ServoRig::plain(Protocol::cia402, id), Cia402Options{})));
  }
  std::string why;
  ASSERT_TRUE(hub.configure(why)) << why;
  ASSERT_TRUE(hub.start());
  hub.stop();
  std::size_t off = 0, switched_off = 0;
  for (const msg::CanFrame& frame : bus.sent) {
    const wire::CanopenId id = wire::canopen_id(frame.id);
    off += id.kind == wire::CanopenKind::rpdo;
    switched_off += id.kind == wire::CanopenKind::sdo_request && frame.data[1] == 0x40 && frame.data[2] == 0x60;
  }
  EXPECT_EQ(off, 8u) << "no torque by PDO";
  EXPECT_EQ(switched_off, 8u) << "and by SDO";
}

TEST(CanHub, ProtocolsMixOnOneBus) {
  ServoRig rig;
  rig.add(Protocol::cia402, ServoRig::plain(Protocol::cia402, 1));
  rig.add(Protocol::ak80, ServoRig::plain(Protocol::ak80, 2));
  rig.add(Protocol::cybergear, ServoRig::plain(Protocol::cybergear, 3));
  rig.configure();
  for (std::size_t i = 0; i < 3; ++i) rig.setpoint[i] = 0.1 * static_cast<double>(i + 1);
  rig.run(5s);
  EXPECT_EQ(rig.sample.ready, 7u);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(rig.joints[i]->position_rad(), 0.1 * (static_cast<double>(i) + 1), 0.02);
  EXPECT_EQ(rig.bus[0]->hub.stats().unknown, 0u);
}

TEST(CanHub, TwentyJointsOnFourBusesAllFollow) {
  ServoRig rig({.tick_hz = 500}, 4);
  for (std::uint32_t i = 0; i < 20; ++i) {
    if (i > 0 && i % 8 == 0) rig.groups.push_back(std::make_unique<ServoGroup>(rig.os, "more"));
    const Protocol p = i % 5 == 4 ? Protocol::damiao : Protocol::cia402;
    rig.add(p, ServoRig::plain(p, i / 4 + 1), i % 4);
    rig.setpoint[i] = 0.05 * i;
  }
  rig.configure();
  rig.run(6s);
  for (std::uint32_t i = 0; i < 20; ++i) {
    EXPECT_NEAR(rig.joints[i]->position_rad(), 0.05 * i, 0.03) << i;
    const ServoStats& stats = rig.groups[i / 8]->servo(i % 8).stats();
    EXPECT_EQ(stats.losses + stats.faults, 0u) << i;
    EXPECT_EQ(stats.enables, 1u) << i;
  }
  for (const auto& b : rig.bus) {
    EXPECT_GT(b->hub.stats().ticks, 2600u);
    EXPECT_LT(b->hub.stats().measured_load, 0.9);
    EXPECT_EQ(b->hub.stats().late_ticks, 0u);
  }
}

/// Frames of a full bus for `seconds`, as many as 1 Mbit/s carries beside the usual frames, in virtual time.
void flood(ServoRig& rig, double seconds, std::uint32_t seed, bool valid_identifiers) {
  sim_hil::MemoryCanPort& noise = rig.bus[0]->wire.attach();
  std::uint64_t random = seed;
  const auto next = [&random] {
    random = random * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::uint32_t>(random >> 33);
  };
  sim_hil::MemoryCan& wire = rig.bus[0]->wire;
  const Time end = rig.os.now() + Duration{static_cast<std::int64_t>(seconds * 1e9)};
  double room = 0;
  while (rig.os.now() < end) {
    const std::uint64_t before = wire.bits();
    if (++rig.steps % 4 == 0) rig.write(100ms);
    rig.step();
    room += 500 - static_cast<double>(wire.bits() - before);  // half a millisecond of 1 Mbit/s
    while (room > 0) {
      msg::CanFrame frame;
      const bool extended = next() % 2 == 0;
      frame.flags = extended ? std::uint32_t{msg::kCanExtended} : 0u;
      frame.id = extended ? next() & 0x1FFFFFFF : next() & 0x7FF;
      const std::uint32_t mine[] = {0x181, 0x281, 0x701, 0x081, 0x581, 0x000, 0x182, 0x702};
      if (valid_identifiers) {
        frame.id = mine[next() % 8];
        frame.flags = 0;
      } else if (!extended && (frame.id & 0x7F) < 3) {
        frame.id |= 0x40;  // foreign: none of ours
      }
      frame.size = next() % 9;
      for (std::size_t i = 0; i < 8; ++i) frame.data[i] = static_cast<std::uint8_t>(next());
      room -= hal::can_frame_bits(frame);
      (void)noise.send(frame, hal::kNever);
    }
  }
}

TEST(CanHub, ForeignFramesAtFullLoadForAMinuteChangeOnlyCounters) {
  ServoRig rig;
  for (std::uint32_t id = 1; id <= 2; ++id) rig.add(Protocol::cia402, ServoRig::plain(Protocol::cia402, id));
  rig.configure();
  rig.setpoint[0] = 0.5;
  ASSERT_TRUE(rig.until(0, JointMode::enabled));
  ASSERT_TRUE(rig.until(1, JointMode::enabled));
  flood(rig, 60, 1, false);
  const CanHubStats stats = rig.bus[0]->hub.stats();
  EXPECT_GT(stats.unknown, 200'000u);
  EXPECT_GT(stats.measured_load, 0.95);
  for (std::size_t i = 0; i < 2; ++i) {
    const ServoStats& servo = rig.group().servo(i).stats();
    EXPECT_EQ(servo.losses + servo.faults + servo.implausible + servo.malformed, 0u);
    EXPECT_EQ(servo.enables, 1u);
  }
  EXPECT_EQ(rig.sample.ready, 3u);
  EXPECT_NEAR(rig.joints[0]->position_rad(), 0.5, 0.01);
}

/// As flood(), with frames under identifiers that have listeners, none of a length that its listener accepts.
void flood_malformed(ServoRig& rig, double seconds) {
  sim_hil::MemoryCanPort& noise = rig.bus[0]->wire.attach();
  sim_hil::MemoryCan& wire = rig.bus[0]->wire;
  std::vector<Interest> all;
  for (std::size_t i = 0; i < rig.group().size(); ++i)
    for (const Interest& one : dynamic_cast<const ServoProtocol&>(rig.group().servo(i)).interests()) all.push_back(one);
  constexpr std::uint32_t kNobodys[] = {0, 2, 3, 4, 5};  // 1: heartbeats, 6 to 8: MIT, 8: all others
  const Time end = rig.os.now() + Duration{static_cast<std::int64_t>(seconds * 1e9)};
  double room = 0;
  for (std::uint32_t n = 0; rig.os.now() < end;) {
    const std::uint64_t before = wire.bits();
    if (++rig.steps % 4 == 0) rig.write(100ms);
    rig.step();
    for (room += 500 - static_cast<double>(wire.bits() - before); room > 0; ++n) {
      const Interest& one = all[n % all.size()];
      msg::CanFrame frame;
      frame.id = one.id | (n * 2654435761u & ~one.mask & (one.extended ? 0x1FFFFFFFu : 0x7FFu));
      frame.flags = one.extended ? std::uint32_t{msg::kCanExtended} : 0u;
      frame.size = static_cast<std::uint8_t>(kNobodys[n / all.size() % std::size(kNobodys)]);
      for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(n * 2246822519u >> 13);
      room -= hal::can_frame_bits(frame);
      (void)noise.send(frame, hal::kNever);
    }
  }
}

TEST(CanHub, MalformedFramesAtFullLoadForAMinuteChangeOnlyCounters) {
  ServoRig rig;
  std::uint32_t id = 0;
  for (const Protocol p : {Protocol::cia402, Protocol::ak80, Protocol::damiao, Protocol::cybergear})
    rig.add(p, ServoRig::plain(p, ++id));
  rig.configure();
  for (std::size_t i = 0; i < id; ++i) rig.setpoint[i] = 0.2;
  for (std::size_t i = 0; i < id; ++i) ASSERT_TRUE(rig.until(i, JointMode::enabled)) << i;
  flood_malformed(rig, 60);
  EXPECT_GT(rig.bus[0]->hub.stats().measured_load, 0.95);
  for (std::size_t i = 0; i < id; ++i) {
    const ServoStats& servo = rig.group().servo(i).stats();
    EXPECT_GT(servo.malformed, 10'000u) << i;
    EXPECT_EQ(servo.losses + servo.faults + servo.implausible, 0u) << i;
    EXPECT_EQ(servo.enables, 1u) << i;
    EXPECT_NEAR(rig.joints[i]->position_rad(), 0.2, 0.02) << i;
  }
  EXPECT_EQ(rig.sample.ready, (1u << id) - 1);
}

TEST(CanHub, NonsenseUnderOurOwnIdentifiersNeverReachesAJoint) {
  ServoRig rig;
  for (std::uint32_t id = 1; id <= 2; ++id) rig.add(Protocol::cia402, ServoRig::plain(Protocol::cia402, id));
  rig.configure();
  rig.run(1s);
  flood(rig, 5, 2, true);
  // A full bus of frames with our numbers takes the joints away: that is said, and nothing of it is measured.
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_GT(rig.group().servo(i).stats().malformed, 1000u);
    EXPECT_LT(std::abs(rig.joints[i]->position_rad()), 0.5) << "nothing of it moved the joint far";
  }
  rig.run(8s);  // the bus is quiet again
  EXPECT_EQ(rig.sample.ready, 3u);
}

TEST(CanHub, BusThatGoesAwayIsCountedAndComesBack) {
  ServoRig rig;
  rig.add(Protocol::ak80, ServoRig::plain(Protocol::ak80, 1));
  rig.configure();
  ASSERT_TRUE(rig.until(0, JointMode::enabled));
  rig.bus[0]->wire.connect(false);
  rig.run(1s);
  EXPECT_EQ(rig.sample.mode[0], JointMode::absent);
  EXPECT_GT(rig.bus[0]->hub.stats().send_failed, 0u);
  EXPECT_GT(rig.bus[0]->hub.stats().errors, 0u);
  rig.bus[0]->wire.connect(true);
  EXPECT_TRUE(rig.until(0, JointMode::enabled));
}

TEST(CanHub, ErrorFramesAreCountedAndGoNoFurther) {
  ServoRig rig;
  rig.add(Protocol::ak80, ServoRig::plain(Protocol::ak80, 1));
  rig.configure();
  rig.run(100ms);
  msg::CanFrame error;
  error.flags = msg::kCanError;
  error.size = 8;
  (void)rig.bus[0]->far.send(error, hal::kNever);
  rig.run(10ms);
  EXPECT_EQ(rig.bus[0]->hub.stats().errors, 1u);
  EXPECT_EQ(rig.group().servo(0).stats().malformed, 0u);
}

TEST(CanHub, SetpointMakesTheTickThatIsNearlyDue) {
  ServoRig rig({.tick_hz = 100});
  rig.add(Protocol::ak80, ServoRig::plain(Protocol::ak80, 1));
  rig.configure();
  CanHub& hub = rig.bus[0]->hub;
  Time now = rig.os.now();
  hub.step(now);
  const std::uint64_t before = hub.stats().ticks;
  rig.write(1s);
  EXPECT_EQ(hub.step(now + 1ms), now + 9ms) << "too early: when it may come is said";
  EXPECT_EQ(hub.stats().ticks, before);
  hub.step(now + 9ms);
  EXPECT_EQ(hub.stats().ticks, before + 1);
  hub.step(now + 11ms);
  EXPECT_EQ(hub.stats().ticks, before + 1) << "the next one is a period later";
}

}  // namespace
}  // namespace sinew::drivers::can_hub_test
