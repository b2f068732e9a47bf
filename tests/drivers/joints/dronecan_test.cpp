// DroneCAN servos and our own node against simulated nodes on a bus in memory, in steps of two milliseconds.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "drivers/joints/dronecan_servo.hpp"
#include "sim_hil/wire/memory_can.hpp"
#include "sim_hil/wire/sim_dronecan.hpp"

namespace sinew::drivers::dronecan_test {
namespace {

using namespace std::chrono_literals;
using msg::JointMode;
using sim_hil::JointModel;
using sim_hil::SimDronecanServo;
using Intent = ServoCommand::Intent;

class ToBus final : public FrameSink {
 public:
  explicit ToBus(hal::CanBus& bus) : bus_(bus) {}
  void send(const msg::CanFrame& frame) noexcept override {
    EXPECT_TRUE(bus_.send(frame, hal::kNever));
    ++frames;
  }
  std::uint64_t frames = 0;

 private:
  hal::CanBus& bus_;
};

bool wants(const CanListener& listener, const msg::CanFrame& frame) {
  for (const Interest& i : listener.interests())
    if (i.extended == frame.extended() && (frame.id & i.mask) == (i.id & i.mask)) return true;
  return false;
}

/// Does the hub's work, without a hub.
class Bench {
 public:
  explicit Bench(const DronecanNodeConfig& config = {}) : node(config) { EXPECT_EQ(check_dronecan_node(config), ""); }
  SimDronecanServo& simulated(const SimDronecanServo::Parameters& p) {
    joints.push_back(std::make_unique<JointModel>());
    return sims.add<SimDronecanServo>(*joints.back(), sim_hil::SimMount{}, p);
  }
  DronecanServo& servo(const ServoConfig& config, const DronecanServoOptions& options = {}) {
    EXPECT_EQ(to_string(check_dronecan(config, options)), "");
    servos.push_back(std::make_unique<DronecanServo>(config, options, node));
    return *servos.back();
  }
  void run(Duration duration, Intent intent = Intent::follow, double setpoint = 0) {
    for (const Time end = now + duration; now < end; now = now + 2ms) {
      msg::CanFrame frame;
      for (auto got = ours.read(frame); got && *got; got = ours.read(frame)) {
        if (wants(node, frame)) node.on_frame(frame, now);
        for (auto& s : servos)
          if (wants(*s, frame)) s->on_frame(frame, now);
      }
      ++number;
      ServoCommand command;
      command.intent = intent, command.setpoint = setpoint, command.number = number;
      node.begin(now, out);
      for (auto& s : servos) s->tick(now, command, out);
      node.end(now, out);
      sims.poll(now);
    }
  }

  sim_hil::MemoryCan wire;
  sim_hil::MemoryCanPort& ours = wire.attach();
  sim_hil::MemoryCanPort& theirs = wire.attach();
  ToBus out{ours};
  DronecanNode node;
  sim_hil::SimServos sims{theirs};
  std::vector<std::unique_ptr<JointModel>> joints;
  std::vector<std::unique_ptr<DronecanServo>> servos;
  Time now{1'000'000'000};
  std::uint32_t number = 0;
};

ServoConfig actuator(std::uint32_t node, std::uint32_t id) {
  ServoConfig c;
  c.name = "pan", c.node_id = node, c.actuator_id = id, c.stop = StopAction::hold;
  c.limits.velocity_radps = 20, c.limits.effort_nm = 20;
  return c;
}

SimDronecanServo::Parameters sim(std::uint8_t node, std::uint8_t id) {
  SimDronecanServo::Parameters p;
  p.node_id = node, p.actuator_id = id;
  return p;
}

TEST(DronecanServo, ActuatorsFollowTheirPositions) {
  Bench bench;
  for (std::uint8_t i = 0; i < 4; ++i) bench.simulated(sim(static_cast<std::uint8_t>(20 + i), i));
  for (std::uint8_t i = 0; i < 4; ++i) bench.servo(actuator(20u + i, i));
  bench.run(3s, Intent::follow, 0.7);
  for (auto& s : bench.servos) {
    EXPECT_EQ(s->feedback().mode, JointMode::enabled);
    EXPECT_NEAR(s->feedback().position_rad, 0.7, 0.02);
    EXPECT_EQ(s->feedback().faults, 0u);
    EXPECT_EQ(s->stats().malformed, 0u);
  }
  EXPECT_NEAR(bench.joints[3]->position_rad(), 0.7, 0.02);
}

TEST(DronecanServo, KnowsWhoItIs) {
  Bench bench;
  auto p = sim(20, 0);
  p.unique_id = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  p.name = "com.example.servo";
  bench.simulated(p);
  DronecanServo& servo = bench.servo(actuator(20, 0));
  bench.run(1s, Intent::off);
  ASSERT_TRUE(servo.identity().known);
  EXPECT_STREQ(servo.identity().name, "com.example.servo");
  EXPECT_EQ(servo.identity().serial, 0x0807060504030201u);
  EXPECT_EQ(servo.identity().revision, 0x100u);
  EXPECT_EQ(servo.feedback().mode, JointMode::disabled);
}

TEST(DronecanServo, EscTurnsAsFastAsItIsTold) {
  Bench bench;
  auto p = sim(30, 2);
  p.esc = true;
  SimDronecanServo& esc = bench.simulated(p);
  ServoConfig c = actuator(30, 2);
  c.mode = ServoMode::velocity, c.stop = StopAction::torque_off;
  DronecanServo& servo = bench.servo(c, {.esc = true, .esc_full_radps = 100, .status_hz = 100});
  esc.temperature_c = 60, esc.voltage_v = 22.5;
  bench.run(800ms, Intent::follow, 10);  // the joint model has stops at 12 rad
  EXPECT_NEAR(servo.feedback().velocity_radps, 10, 1.5);
  EXPECT_TRUE(std::isnan(servo.feedback().position_rad)) << "an ESC measures none";
  EXPECT_NEAR(servo.feedback().temperature_c, 60, 0.2);
  EXPECT_NEAR(servo.feedback().voltage_v, 22.5, 0.02);
  bench.run(100ms, Intent::stop);
  EXPECT_FALSE(esc.live()) << "command 0";
}

TEST(DronecanServo, HotEscTurnsSlowerAndSaysSo) {
  Bench bench;
  auto p = sim(30, 2);
  p.esc = true;
  SimDronecanServo& esc = bench.simulated(p);
  ServoConfig c = actuator(30, 2);
  c.mode = ServoMode::velocity, c.stop = StopAction::torque_off;
  c.derating = {60, 80};
  DronecanServo& servo = bench.servo(c, {.esc = true, .esc_full_radps = 100, .status_hz = 100});
  esc.temperature_c = 70;  // half of the limit is left: 10 of 20 rad/s
  bench.run(800ms, Intent::follow, 18);
  EXPECT_NEAR(servo.feedback().velocity_radps, 10, 1);
  EXPECT_NE(servo.feedback().faults & msg::kJointDerated, 0u);
  EXPECT_EQ(servo.feedback().mode, JointMode::enabled);
  esc.temperature_c = 90;
  bench.run(500ms, Intent::follow, 18);
  EXPECT_NEAR(servo.feedback().velocity_radps, 0, 1);
}

TEST(DronecanNode, ArmsTheBusAsLongAsAServoIsLiveAndDisarmsIt) {
  Bench bench;
  SimDronecanServo& servo = bench.simulated(sim(20, 0));
  bench.servo(actuator(20, 0));
  bench.run(2100ms, Intent::follow, 0.3);  // it was said 100 ms ago
  EXPECT_TRUE(servo.live());
  auto& stranger = bench.wire.attach();
  wire::DronecanId id;
  id.type = wire::kDronecanArmingStatus.type, id.source = 99;
  const std::array<std::uint8_t, 1> disarmed{};
  wire::DronecanSplitter splitter(id, wire::kDronecanArmingStatus.signature, 0, disarmed);
  msg::CanFrame frame;
  ASSERT_TRUE(splitter.next(frame));
  ASSERT_TRUE(stranger.send(frame, hal::kNever));
  bench.run(2ms, Intent::follow, 0.3);
  bench.run(2ms, Intent::follow, 0.3);
  EXPECT_FALSE(servo.live()) << "a device that minds it";
  bench.run(600ms, Intent::follow, 0.3);
  EXPECT_TRUE(servo.live()) << "said again twice a second";
  bench.run(10ms, Intent::off);
  EXPECT_FALSE(servo.live()) << "at once, not by its time-out";
}

TEST(DronecanServo, WhenTheLeaseEndsThePositionIsHeldAndWhenItIsOffNothingIsSent) {
  Bench bench;
  SimDronecanServo& servo = bench.simulated(sim(20, 0));
  bench.servo(actuator(20, 0));
  bench.run(2s, Intent::follow, 0.5);
  bench.run(1s, Intent::stop);
  EXPECT_EQ(bench.servos[0]->feedback().mode, JointMode::stopping);
  EXPECT_TRUE(servo.live());
  EXPECT_NEAR(bench.joints[0]->position_rad(), 0.5, 0.02);
  const auto commands = servo.commands();
  bench.run(1s, Intent::off);
  EXPECT_LE(servo.commands(), commands + 1) << "one may have been on its way";
  EXPECT_FALSE(servo.live()) << "its own time-out";
  EXPECT_EQ(bench.servos[0]->feedback().mode, JointMode::disabled);
}

TEST(DronecanServo, SilentNodeIsLostAndComesBackByANewCommand) {
  Bench bench;
  SimDronecanServo& quiet = bench.simulated(sim(20, 0));
  SimDronecanServo& other = bench.simulated(sim(21, 1));
  bench.servo(actuator(20, 0)), bench.servo(actuator(21, 1));
  bench.run(2s, Intent::follow, 0.3);
  quiet.faults.silent = true;
  bench.run(1s, Intent::follow, 0.3);
  EXPECT_EQ(bench.servos[0]->feedback().mode, JointMode::absent);
  EXPECT_NE(bench.servos[0]->feedback().faults & msg::kJointLost, 0u);
  EXPECT_EQ(bench.servos[0]->stats().losses, 1u);
  EXPECT_FALSE(quiet.live()) << "and nothing is sent to it";
  EXPECT_TRUE(other.live());
  EXPECT_EQ(bench.servos[1]->feedback().mode, JointMode::enabled) << "the others go on";
  quiet.faults.silent = false;
  bench.run(5s, Intent::follow, 0.3);
  EXPECT_EQ(bench.servos[0]->feedback().mode, JointMode::enabled);
}

TEST(DronecanServo, FaultOfTheNodeStopsItsJointAndTellsItsCode) {
  Bench bench;
  SimDronecanServo& broken = bench.simulated(sim(20, 0));
  bench.servo(actuator(20, 0));
  bench.run(2s, Intent::follow, 0.3);
  broken.fail(0x1234);
  bench.run(2s, Intent::follow, 0.3);
  EXPECT_EQ(bench.servos[0]->feedback().mode, JointMode::fault);
  EXPECT_EQ(bench.servos[0]->feedback().faults & msg::kJointOther, std::uint32_t{msg::kJointOther});
  EXPECT_EQ(bench.servos[0]->feedback().fault_code, 0x1234u);
  broken.power(false);
  bench.run(1s, Intent::follow, 0.3);
  broken.power(true);
  bench.run(5s, Intent::follow, 0.3);
  EXPECT_EQ(bench.servos[0]->feedback().mode, JointMode::enabled) << "after its power was cycled";
}

TEST(DronecanServo, TwoNodesOfOneIdAreNoticed) {
  Bench bench;
  SimDronecanServo& first = bench.simulated(sim(20, 0));
  first.uptime_offset_s = 1000;
  bench.simulated(sim(20, 0)).uptime_offset_s = 500;
  bench.servo(actuator(20, 0));
  bench.run(3s, Intent::follow, 0.0);
  EXPECT_NE(bench.servos[0]->feedback().faults & msg::kJointDuplicate, 0u);
  EXPECT_EQ(bench.servos[0]->feedback().mode, JointMode::fault);
}

TEST(DronecanServo, ASecondNodeOfItsIdThatIsPluggedInLaterIsNoticed) {
  Bench bench;
  bench.simulated(sim(20, 0)).uptime_offset_s = 1000;
  bench.servo(actuator(20, 0));
  bench.run(2s, Intent::follow, 0.0);
  ASSERT_EQ(bench.servos[0]->feedback().mode, JointMode::enabled);
  bench.simulated(sim(20, 0));
  bench.run(3s, Intent::follow, 0.0);
  EXPECT_NE(bench.servos[0]->feedback().faults & msg::kJointDuplicate, 0u);
}

TEST(DronecanServo, EveryTenthFrameMayBeLost) {
  Bench bench;
  bench.simulated(sim(20, 0)).faults.lost = 0.1;
  ServoConfig c = actuator(20, 0);
  c.feedback_timeout = 200ms;
  bench.servo(c);
  bench.run(4s, Intent::follow, 0.4);
  EXPECT_EQ(bench.servos[0]->feedback().mode, JointMode::enabled);
  EXPECT_EQ(bench.servos[0]->stats().losses, 0u);
  EXPECT_NEAR(bench.joints[0]->position_rad(), 0.4, 0.05);
}

TEST(DronecanServo, SpoofedPositionsStayWithinWhatAJointCanDo) {
  Bench bench;
  bench.simulated(sim(20, 0));
  ServoConfig c = actuator(20, 0);
  c.limits.velocity_radps = 2;
  bench.servo(c);
  bench.run(1s, Intent::follow, 0.3);
  ASSERT_EQ(bench.servos[0]->feedback().mode, JointMode::enabled);
  auto& liar = bench.wire.attach();
  double worst = 0;
  // Whole transfers in its name that are all right but for where it is.
  for (std::uint8_t n = 0; n < 100; ++n) {
    std::array<std::uint8_t, 16> bytes{};
    const std::size_t size = encode(wire::DronecanActuatorStatus{.position = 2.5}, bytes);
    wire::DronecanId id;
    id.type = wire::kDronecanActuatorStatus.type, id.source = 20;
    wire::DronecanSplitter frames(id, wire::kDronecanActuatorStatus.signature, n % 32, std::span(bytes).first(size));
    for (msg::CanFrame frame; frames.next(frame);) ASSERT_TRUE(liar.send(frame, hal::kNever));
    bench.run(10ms, Intent::follow, 0.3);
    worst = std::max(worst, std::abs(bench.servos[0]->feedback().position_rad - 0.3));
  }
  EXPECT_GT(bench.servos[0]->stats().implausible, 20u);
  EXPECT_LT(worst, 0.3);
  EXPECT_NEAR(bench.joints[0]->position_rad(), 0.3, 0.02);
}

TEST(DronecanServo, GarbageUnderItsIdentifiersOnlyCounts) {
  Bench bench;
  SimDronecanServo& servo = bench.simulated(sim(20, 0));
  bench.servo(actuator(20, 0));
  bench.run(2s, Intent::follow, 0.3);
  servo.faults.garbage = true;
  bench.run(2s, Intent::follow, 0.3);
  const ServoFeedback& f = bench.servos[0]->feedback();
  EXPECT_TRUE(f.mode == JointMode::absent || f.mode == JointMode::fault);
  EXPECT_NEAR(f.position_rad, 0.3, 0.5) << "no wild position was believed";
  EXPECT_GT(bench.servos[0]->stats().malformed, 0u);
}

TEST(DronecanServo, FullBusOfForeignFramesForAMinuteOnlyCounts) {
  Bench bench;
  bench.simulated(sim(20, 0));
  bench.servo(actuator(20, 0));
  bench.run(1s, Intent::follow, 0.4);
  auto& stranger = bench.wire.attach();
  std::uint32_t random = 1;
  const auto next = [&random] { return (random = random * 1664525u + 1013904223u) >> 8; };
  for (int tick = 0; tick < 30000; ++tick) {
    for (int i = 0; i < 14; ++i) {  // 2 ms of a bus of 1 Mbit/s
      msg::CanFrame frame;
      frame.flags = next() % 4 == 0 ? 0u : msg::kCanExtended;
      frame.id = frame.extended() ? next() << 5 & 0x1FFFFFFF : next() & 0x7FF;
      // Every source but ours and our servo's, and half of them with the types that we listen to.
      const std::uint32_t type = next() % 2 == 0 ? 1011u : 341u;
      if (next() % 2 == 0 && frame.extended()) frame.id = type << 8 | (30 + next() % 90);
      if (frame.extended() && ((frame.id & 0x7F) == 20 || (frame.id & 0x7F) == 10)) frame.id ^= 1;
      frame.size = next() % 9;
      for (std::size_t k = 0; k < frame.size; ++k) frame.data[k] = static_cast<std::uint8_t>(next());
      ASSERT_TRUE(stranger.send(frame, hal::kNever));
    }
    bench.run(2ms, Intent::follow, 0.4);
    ASSERT_EQ(bench.servos[0]->feedback().mode, JointMode::enabled) << tick;
    for (msg::CanFrame frame; *stranger.read(frame);) {
    }
  }
  EXPECT_EQ(bench.servos[0]->stats().losses, 0u);
  EXPECT_EQ(bench.servos[0]->stats().faults, 0u);
  EXPECT_NEAR(bench.joints[0]->position_rad(), 0.4, 0.02);
}

TEST(DronecanServo, WrongConfigurationsAreNamed) {
  ServoConfig c = actuator(20, 0);
  c.stop = StopAction::torque_off;
  EXPECT_EQ(to_string(check_dronecan(c, {})), "on_stop: \"hold\"; an actuator in mode position has no other");
  c = actuator(128, 0);
  EXPECT_EQ(to_string(check_dronecan(c, {})), "id: an integer from 1 to 127");
  EXPECT_EQ(to_string(check_dronecan(actuator(1, 0), {.esc = true})),
            "mode: \"velocity\"; an ESC has no other; esc_full_radps: a number above 0; required for an ESC; "
            "on_stop: \"torque_off\"; an ESC has no other");
  c = actuator(1, 20);
  c.mode = ServoMode::velocity, c.stop = StopAction::torque_off;
  EXPECT_EQ(to_string(check_dronecan(c, {.esc = true})),
            "esc_full_radps: a number above 0; required for an ESC; actuator_id: an integer from 0 to 19, for an ESC");
  EXPECT_EQ(to_string(check_dronecan(c, {.esc = true, .esc_full_radps = 10})),
            "actuator_id: an integer from 0 to 19, for an ESC");
}

// ---- our own node ----

/// Everything that the other side of the bus hears, put together.
std::vector<std::pair<wire::DronecanId, std::vector<std::uint8_t>>> heard(hal::CanBus& bus, std::uint8_t as_node) {
  static constexpr wire::DronecanWanted kAll[] = {wire::kDronecanNodeStatus, wire::kDronecanGetNodeInfo,
                                                  wire::kDronecanAllocation};
  wire::DronecanAssembler assembler(kAll, 4);
  std::vector<std::pair<wire::DronecanId, std::vector<std::uint8_t>>> out;
  msg::CanFrame frame;
  wire::DronecanTransfer transfer;
  for (auto got = bus.read(frame); got && *got; got = bus.read(frame))
    if (assembler.push(frame, frame.stamp, as_node, transfer) == wire::DronecanAssembler::Heard::complete)
      out.emplace_back(transfer.id, std::vector<std::uint8_t>(transfer.payload.begin(), transfer.payload.end()));
  return out;
}

TEST(DronecanNode, SaysItsStatusEachSecond) {
  Bench bench;
  auto& ear = bench.wire.attach();
  bench.run(3500ms);
  const auto said = heard(ear, 99);
  ASSERT_EQ(said.size(), 4u);
  for (std::uint32_t i = 0; i < 4; ++i) {
    wire::DronecanNodeStatus status;
    ASSERT_TRUE(decode(said[i].second, status));
    EXPECT_EQ(said[i].first.source, 10);
    EXPECT_EQ(status.uptime_s, i);
  }
}

TEST(DronecanNode, TellsWhoItIsAFewFramesATick) {
  DronecanNodeConfig config;
  config.name = "org.sinew.test";
  config.unique_id = {9, 8, 7};
  Bench bench(config);
  auto& ear = bench.wire.attach();
  bench.run(4ms);
  heard(ear, 99);
  wire::DronecanId id;
  id.service = id.request = true, id.type = 1, id.source = 99, id.destination = 10;
  wire::DronecanSplitter splitter(id, wire::kDronecanGetNodeInfo.signature, 7, {});
  msg::CanFrame frame;
  ASSERT_TRUE(splitter.next(frame));
  ASSERT_TRUE(ear.send(frame, hal::kNever));
  const auto before = bench.out.frames;
  bench.run(4ms);
  EXPECT_LE(bench.out.frames - before, 4u) << "two a tick";
  bench.run(40ms);
  const auto said = heard(ear, 99);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0].first.destination, 99);
  EXPECT_FALSE(said[0].first.request);
  wire::DronecanNodeInfo info;
  ASSERT_TRUE(decode(said[0].second, info));
  EXPECT_EQ(info.name(), "org.sinew.test");
  EXPECT_EQ(info.unique_id[2], 7);
  EXPECT_EQ(bench.node.stats().answers, 1u);
}

TEST(DronecanNode, GivesNodeIdsByItsTable) {
  DronecanNodeConfig config;
  auto p = sim(0, 0), q = sim(0, 1), stranger = sim(0, 2);
  for (std::uint8_t i = 0; i < 16; ++i) p.unique_id[i] = i, q.unique_id[i] = static_cast<std::uint8_t>(100 + i);
  stranger.unique_id.fill(0xEE);
  config.allocation = {{p.unique_id, 50}, {q.unique_id, 51}};
  Bench bench(config);
  SimDronecanServo &first = bench.simulated(p), &second = bench.simulated(q), &third = bench.simulated(stranger);
  bench.servo(actuator(50, 0)), bench.servo(actuator(51, 1));
  bench.run(20s, Intent::follow, 0.2);
  EXPECT_EQ(first.node_id(), 50);
  EXPECT_EQ(second.node_id(), 51);
  EXPECT_EQ(third.node_id(), 0) << "it is not in the table";
  EXPECT_EQ(bench.node.stats().allocated, 2u);
  EXPECT_GT(bench.node.stats().allocation_unknown, 0u);
  EXPECT_EQ(bench.servos[1]->feedback().mode, JointMode::enabled) << "and they are driven";
}

TEST(DronecanNode, SomebodyElseWithOurIdIsCounted) {
  Bench bench;
  bench.simulated(sim(10, 5));
  bench.run(3s);
  EXPECT_GE(bench.node.stats().own_id_heard, 2u);
}

TEST(DronecanNode, WrongTablesAreNamed) {
  DronecanNodeConfig c;
  c.node_id = 0;
  EXPECT_EQ(check_dronecan_node(c), "dronecan: node_id: 1..127");
  c.node_id = 10;
  c.allocation = {{{1}, 10}};
  EXPECT_EQ(check_dronecan_node(c), "dronecan: allocation: node_id: 1..127, and not ours");
  c.allocation = {{{1}, 11}, {{2}, 11}};
  EXPECT_EQ(check_dronecan_node(c), "dronecan: allocation: each node id and each unique id once");
}

}  // namespace
}  // namespace sinew::drivers::dronecan_test
