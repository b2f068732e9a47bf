#include "sim_hil/wire/sim_serial_servo.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace sinew::sim_hil::sim_serial_servo_test {
namespace {

using namespace std::chrono_literals;
using wire::DxlBuilder;
using wire::DxlPacket;
using wire::DxlVersion;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint16_t kWatched = 126, kTen = 10;  // current, velocity, position of an XM430

struct Answer {
  std::uint8_t id = 0, error = 0;
  Bytes data;
};

/// A line with servos of one model, ids from 1 on, and a host that asks and waits.
class SerialServos {
 public:
  explicit SerialServos(std::string_view name, int count = 1, SimLineOptions options = {}, std::uint8_t delay = 0)
      : model(*wire::servo_model(name)), line(options, clock), reader_(model.version) {
    clock.set({1'000'000'000});
    for (int i = 0; i < count; ++i) {
      joints.push_back(std::make_unique<JointModel>());
      SimSerialServo::Parameters p;
      p.id = static_cast<std::uint8_t>(i + 1), p.model = &model, p.return_delay = delay;
      servos.push_back(std::make_unique<SimSerialServo>(line, *joints.back(), SimMount{}, p));
      ids.push_back(p.id);
    }
  }
  /// Sends, and reads until `answers` have come or `patience` is over.
  std::vector<Answer> ask(DxlBuilder packet, std::size_t answers = 1, Duration patience = 50ms) {
    all_.clear();
    const Time begin = clock.now();
    const auto bytes = packet.finish();
    EXPECT_FALSE(bytes.empty());
    static_cast<void>(line.host().write_now(bytes));
    while (all_.size() < answers && clock.now() - begin < patience) step(begin + patience);
    took = clock.now() - begin;
    return all_;
  }
  void run(Duration time) {
    const Time end = clock.now() + time;
    while (clock.now() < end) step(end);
  }
  void step(Time most) {
    clock.set(std::min({line.next(), clock.now() + 1ms, most}));
    line.advance(clock.now());
    std::array<std::uint8_t, 64> into{};
    for (auto n = line.host().read_now(into); n && *n > 0; n = line.host().read_now(into))
      for (std::size_t i = 0; i < *n; ++i) {
        ++heard;
        reader_.push(into[i], [&](const DxlPacket& p) {
          all_.push_back({p.id, p.error, {p.parameters.begin(), p.parameters.end()}});
        });
      }
  }
  std::vector<Answer> write(const wire::ServoRegister& reg, std::int32_t value, std::uint8_t id = 1) {
    return ask(wire::dxl_write(model.version, id, reg.address, wire::servo_bytes(model, reg, value)));
  }
  DxlBuilder goals(std::int32_t count) {
    DxlBuilder packet = wire::dxl_sync_write(model.version, model.goal_position.address, model.goal_position.size);
    for (const std::uint8_t id : ids) packet.byte(id).bytes(wire::servo_bytes(model, model.goal_position, count));
    return packet;
  }

  hal::ManualClock clock;
  const wire::ServoModel& model;
  SimSerialLine line;
  std::vector<std::unique_ptr<JointModel>> joints;
  std::vector<std::unique_ptr<SimSerialServo>> servos;
  Bytes ids;
  Duration took{};
  std::size_t heard = 0;

 private:
  wire::DxlReader reader_;
  std::vector<Answer> all_;
};

TEST(SimSerialServo, APingIsAnsweredAfterTheReturnDelayAndTheTimeOfTheBytes) {
  SerialServos rig("xm430_w350", 1, {}, 250);
  const auto answers = rig.ask(wire::dxl_ping(DxlVersion::two, 1));
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(answers[0].data.at(0) | answers[0].data.at(1) << 8, 1020);
  EXPECT_EQ(rig.took, 10 * 10us + 500us + 14 * 10us);
}

TEST(SimSerialServo, TwentyServosAreWrittenAndReadWithinEightMilliseconds) {
  SerialServos rig("xm430_w350", 20);
  const Time begin = rig.clock.now();
  // The host sends the question at once behind the goals.
  DxlBuilder goals = rig.goals(2048);
  static_cast<void>(rig.line.host().write_now(goals.finish()));
  const auto answers = rig.ask(wire::dxl_sync_read(DxlVersion::two, kWatched, kTen, rig.ids), 20);
  ASSERT_EQ(answers.size(), 20u);
  for (const Answer& a : answers) EXPECT_EQ(a.data.size(), 10u);
  // 14 + 20 * 5, 14 + 20, 20 * 21 bytes of 10 us.
  EXPECT_EQ(rig.clock.now() - begin, (114 + 34 + 420) * 10us);
  EXPECT_LT(rig.clock.now() - begin, 8ms);
}

TEST(SimSerialServo, TheFactorysReturnDelayCostsTwentyServosTenMilliseconds) {
  SerialServos rig("xm430_w350", 20, {}, 250);
  ASSERT_EQ(rig.ask(wire::dxl_sync_read(DxlVersion::two, kWatched, kTen, rig.ids), 20).size(), 20u);
  EXPECT_EQ(rig.took, (34 + 420) * 10us + 20 * 500us);
}

TEST(SimSerialServo, AFastReadIsOneAnswerOfAllAndShorter) {
  SerialServos rig("xm430_w350", 20);
  int parts = 0;
  wire::DxlReader reader(DxlVersion::two);
  DxlBuilder packet = wire::dxl_sync_read(DxlVersion::two, kWatched, kTen, rig.ids, true);
  rig.joints[6]->place(0.5);
  const auto answers = rig.ask(packet);
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(rig.took, static_cast<std::int64_t>(34 + wire::dxl_fast_status_bytes(20, 10)) * 10us);
  const DxlPacket answer{wire::kDxlBroadcast, 0x55, answers[0].error, answers[0].data};
  wire::DxlFastParts all(answer);
  for (wire::DxlFastPart part; all.next(kTen, part); ++parts) {
    EXPECT_EQ(part.id, parts + 1);
    const auto count = wire::servo_number(rig.model, rig.model.present_position, kWatched, part.data);
    EXPECT_EQ(*count, parts == 6 ? 2048 + 326 : 2048);
  }
  EXPECT_EQ(parts, 20);
}

TEST(SimSerialServo, BehindAServoThatIsSilentNobodyAnswers) {
  SerialServos rig("xm430_w350", 5);
  rig.servos[2]->power(false);
  const auto answers = rig.ask(wire::dxl_sync_read(DxlVersion::two, kWatched, kTen, rig.ids), 5);
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_EQ(answers[1].id, 2);
  rig.servos[2]->power(true);
  EXPECT_EQ(rig.ask(wire::dxl_sync_read(DxlVersion::two, kWatched, kTen, rig.ids), 5).size(), 5u);
}

TEST(SimSerialServo, WithAnEchoTheHostHearsItself) {
  SerialServos rig("xm430_w350", 1, {.echo = true});
  rig.ask(wire::dxl_ping(DxlVersion::two, 1), 2);
  EXPECT_EQ(rig.heard, 10u + 14u);
}

TEST(SimSerialServo, AnAdapterHandsBytesOverWhenItsTimerEnds) {
  SerialServos rig("xm430_w350", 1, {.latency = 16ms});
  ASSERT_EQ(rig.ask(wire::dxl_ping(DxlVersion::two, 1)).size(), 1u);
  EXPECT_EQ(rig.took, 10 * 10us + 10us + 16ms);
  rig.line.set_latency(1ms);
  ASSERT_EQ(rig.ask(wire::dxl_ping(DxlVersion::two, 1)).size(), 1u);
  EXPECT_LT(rig.took, 2ms);
}

TEST(SimSerialServo, TwoWithOneIdDestroyEachOthersAnswers) {
  SerialServos rig("xm430_w350", 2);
  rig.servos[1]->set_number(rig.model.id, 1);
  EXPECT_TRUE(rig.ask(wire::dxl_ping(DxlVersion::two, 1)).empty());
  EXPECT_GT(rig.line.collisions(), 0u);
}

TEST(SimSerialServo, ALostByteCostsItsPacketAndNoMore) {
  SerialServos rig("xm430_w350");
  int at = 0;
  rig.line.set_tamper([&](std::uint8_t b) { return ++at == 4 ? std::nullopt : std::optional(b); });
  EXPECT_TRUE(rig.ask(wire::dxl_ping(DxlVersion::two, 1), 1, 5ms).empty());
  EXPECT_EQ(rig.ask(wire::dxl_ping(DxlVersion::two, 1), 1, 5ms).size(), 1u);
}

TEST(SimSerialServo, FollowsItsGoalWhenItHasTorque) {
  for (const wire::ServoModel& m : wire::servo_models()) {
    SerialServos rig(m.name);
    const std::int32_t goal = m.centre + static_cast<std::int32_t>(0.5 / m.rad_per_count());
    ASSERT_EQ(rig.write(m.goal_position, goal).size(), 1u) << m.name;
    rig.run(300ms);
    EXPECT_EQ(rig.joints[0]->position_rad(), 0) << m.name;
    EXPECT_EQ(rig.write(m.torque_enable, 1).at(0).error, 0) << m.name;
    rig.run(2s);
    EXPECT_NEAR(rig.joints[0]->position_rad(), 0.5, m.rad_per_count()) << m.name;
  }
}

TEST(SimSerialServo, WithoutInstructionsTheWatchdogStopsItAndLocksItsGoals) {
  SerialServos rig("xm430_w350");
  const auto& m = rig.model;
  rig.write(m.goal_position, 2048 + 1000);
  rig.write(m.torque_enable, 1);
  rig.write(m.bus_watchdog, 2);
  rig.run(100ms);
  EXPECT_EQ(rig.servos[0]->number(m.bus_watchdog), 0xFF);
  rig.run(1s);
  EXPECT_NEAR(rig.joints[0]->velocity_radps(), 0, 1e-3);
  EXPECT_LT(rig.joints[0]->position_rad(), 1000 * m.rad_per_count() - 0.5) << "where it was, not at its goal";
  EXPECT_TRUE(rig.servos[0]->live());
  EXPECT_EQ(rig.write(m.goal_position, 2048).at(0).error, static_cast<int>(wire::DxlError::data_range));
  rig.write(m.bus_watchdog, 0);
  EXPECT_EQ(rig.write(m.goal_position, 2048).at(0).error, 0);
}

TEST(SimSerialServo, AFaultIsAnAlertUntilAReboot) {
  SerialServos rig("xm430_w350");
  const auto& m = rig.model;
  rig.write(m.torque_enable, 1);
  rig.servos[0]->fail(1u << 5);
  EXPECT_FALSE(rig.servos[0]->live());
  EXPECT_EQ(rig.write(m.torque_enable, 1).at(0).error, wire::kDxlAlert | static_cast<int>(wire::DxlError::result_fail));
  rig.servos[0]->fail(0);
  EXPECT_TRUE(rig.servos[0]->faulty()) << "also when its cause is gone";
  ASSERT_EQ(rig.ask(wire::dxl_reboot(m.version, 1)).size(), 1u);
  EXPECT_TRUE(rig.ask(wire::dxl_ping(m.version, 1), 1, 100ms).empty()) << "it boots";
  rig.run(300ms);
  EXPECT_EQ(rig.ask(wire::dxl_ping(m.version, 1)).at(0).error, 0);
  EXPECT_EQ(rig.write(m.torque_enable, 1).at(0).error, 0);
}

TEST(SimSerialServo, WhatItCannotDoItSays) {
  SerialServos rig("xm430_w350");
  const auto& m = rig.model;
  const auto error = [](const std::vector<Answer>& a) { return a.empty() ? -1 : static_cast<int>(a[0].error); };
  EXPECT_EQ(error(rig.ask(DxlBuilder(m.version, 1, std::uint8_t{0x30}))),
            static_cast<int>(wire::DxlError::instruction));
  EXPECT_EQ(error(rig.write(m.present_position, 0)), static_cast<int>(wire::DxlError::access));
  EXPECT_EQ(error(rig.write(m.goal_position, 5000)), static_cast<int>(wire::DxlError::data_limit));
  EXPECT_EQ(error(rig.ask(wire::dxl_read(m.version, 1, 250, 10))), static_cast<int>(wire::DxlError::access));
  rig.write(m.torque_enable, 1);
  EXPECT_EQ(error(rig.write(m.return_delay, 0)), static_cast<int>(wire::DxlError::access)) << "EEPROM, with torque";
}

TEST(SimSerialServo, RegisteredWritesWaitForTheAction) {
  SerialServos rig("mx28", 2);
  const auto& m = rig.model;
  for (const std::uint8_t id : rig.ids)
    ASSERT_EQ(rig.ask(wire::dxl_reg_write(m.version, id, m.goal_position.address,
                                          wire::servo_bytes(m, m.goal_position, 1000)))
                  .size(),
              1u);
  EXPECT_EQ(rig.servos[0]->number(m.goal_position), 2048);
  rig.ask(wire::dxl_action(m.version, wire::kDxlBroadcast), 1, 5ms);
  EXPECT_EQ(rig.servos[0]->number(m.goal_position), 1000);
  EXPECT_EQ(rig.servos[1]->number(m.goal_position), 1000);
}

TEST(SimSerialServo, BulkReadsAreAnsweredInTurn) {
  for (const char* name : {"mx28", "xm430_w350"}) {
    SerialServos rig(name, 3);
    const auto& m = rig.model;
    const std::array places{wire::DxlPlace{2, m.present_voltage.address, m.present_voltage.size},
                            wire::DxlPlace{1, m.present_temperature.address, 1}};
    const auto answers = rig.ask(wire::dxl_bulk_read(m.version, places), 2);
    ASSERT_EQ(answers.size(), 2u) << name;
    EXPECT_EQ(answers[0].id, 2) << name;
    EXPECT_EQ(answers[0].data.at(0), 120) << name << ": 12 V";
    EXPECT_EQ(answers[1].data.at(0), 25) << name;
  }
}

TEST(SimSerialServo, FeetechKeepsItsSettingsOnlyWhenTheyAreUnlocked) {
  SerialServos rig("sts3215", 1, {}, 100);
  const auto& m = rig.model;
  rig.write(m.return_delay, 0);
  EXPECT_EQ(rig.servos[0]->number(m.return_delay), 100);
  rig.write(m.lock, 0);
  rig.write(m.return_delay, 0);
  EXPECT_EQ(rig.servos[0]->number(m.return_delay), 0);
  EXPECT_EQ(rig.ask(wire::dxl_sync_read(m.version, m.present_position.address, 8, rig.ids)).at(0).data.size(), 8u);
}

}  // namespace
}  // namespace sinew::sim_hil::sim_serial_servo_test
