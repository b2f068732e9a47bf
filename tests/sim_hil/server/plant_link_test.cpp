#include "sim_hil/server/plant_link.hpp"

#include <gtest/gtest.h>

#include "../memory_stream.hpp"

namespace sinew::sim_hil::plant_link_test {
namespace {

using hal::Errc;
using namespace std::chrono_literals;

constexpr std::uint16_t kMotors = 1;

PlantDescription two_devices() {
  PlantDescription p;
  p.name = "bench";
  p.step = 1ms;
  p.devices.resize(2);
  p.devices[0].kind = DeviceKind::imu, p.devices[0].name = "imu";
  p.devices[1].kind = DeviceKind::actuators, p.devices[1].name = "motors", p.devices[1].channels = 2;
  return p;
}

Command thrust(double value, Duration lease) {
  Command c;
  c.lease = lease;
  c.setpoints.count = 2, c.setpoints.armed = 1, c.setpoints.value = {value, value};
  return c;
}

/// A runtime's messages, prepared before.
class Script {
 public:
  explicit Script(Hello hello = {}) { add(Type::hello, 0, Time{}, hello); }
  Script& start() { return plain(Type::start, 0, Time{}); }
  Script& done(Time t) { return plain(Type::done, 0, t); }
  Script& stop(std::uint16_t group, Time t) { return plain(Type::stop, group, t); }
  Script& command(Time commit, const Command& c) { return add(Type::command, kMotors, commit, c); }
  Script& bye(std::string_view text) {
    EXPECT_TRUE(writer_.add_text(Type::bye, Time{}, text));
    return *this;
  }
  Script& plain(Type type, std::uint16_t device, Time t) {
    EXPECT_TRUE(writer_.add(type, device, t));
    return *this;
  }
  std::unique_ptr<PlantLink> meet() {
    auto stream = std::make_unique<MemoryStream>(std::vector(writer_.pending().begin(), writer_.pending().end()), 33);
    wire = stream.get();
    auto link = PlantLink::accept(std::move(stream), two_devices(), nullptr, why);
    return link ? std::move(*link) : nullptr;
  }
  std::string why;
  MemoryStream* wire = nullptr;

 private:
  template <class P>
  Script& add(Type type, std::uint16_t device, Time t, const P& payload) {
    EXPECT_TRUE(writer_.add(type, device, t, payload));
    return *this;
  }
  MessageWriter writer_{1 << 16};
};

TEST(PlantLink, CommandActsFromItsCommitUntilItsLeaseIsOver) {
  auto link = Script().start().command(Time{1500}, thrust(0.5, 1000ns)).done(Time{1000}).meet();
  ASSERT_TRUE(link->wait_start());
  EXPECT_FALSE(link->setpoints_at(kMotors, Time{999}).valid) << "nothing has been commanded";
  ASSERT_TRUE(link->grant(Time{1000}));
  EXPECT_FALSE(link->setpoints_at(kMotors, Time{1499}).valid);
  const Setpoints on = link->setpoints_at(kMotors, Time{1500});
  EXPECT_TRUE(on.valid);
  EXPECT_EQ(on.count, 2u);
  EXPECT_EQ(on.value[1], 0.5);
  EXPECT_TRUE(link->setpoints_at(kMotors, Time{2499}).valid);
  const Setpoints off = link->setpoints_at(kMotors, Time{2500});
  EXPECT_FALSE(off.valid);
  EXPECT_TRUE(off.lease_over);
  EXPECT_EQ(off.value[1], 0.0);
  EXPECT_FALSE(link->setpoints_at(kMotors, Time{9999}).valid);
  EXPECT_EQ(link->stats().lease_expiries, 1u) << "counted when it happens, not at every step";
}

TEST(PlantLink, NewestCommandNotAfterTheStepWins) {
  auto link = Script()
                  .start()
                  .command(Time{10}, thrust(0.1, 1ms))
                  .command(Time{20}, thrust(0.2, 1ms))
                  .command(Time{30}, thrust(0.3, 1ms))
                  .done(Time{30})
                  .meet();
  ASSERT_TRUE(link->wait_start());
  ASSERT_TRUE(link->grant(Time{30}));
  EXPECT_EQ(link->setpoints_at(kMotors, Time{25}).value[0], 0.2);
  EXPECT_EQ(link->setpoints_at(kMotors, Time{30}).value[0], 0.3);
}

TEST(PlantLink, StopHoldsUntilTheNextCommand) {
  auto link = Script()
                  .start()
                  .command(Time{10}, thrust(0.1, 1s))
                  .stop(kAllGroups, Time{20})
                  .command(Time{30}, thrust(0.3, 1s))
                  .done(Time{30})
                  .meet();
  ASSERT_TRUE(link->wait_start());
  ASSERT_TRUE(link->grant(Time{30}));
  EXPECT_TRUE(link->setpoints_at(kMotors, Time{19}).valid);
  EXPECT_FALSE(link->setpoints_at(kMotors, Time{20}).valid);
  EXPECT_FALSE(link->setpoints_at(kMotors, Time{20}).lease_over);
  EXPECT_TRUE(link->setpoints_at(kMotors, Time{30}).valid);
  EXPECT_EQ(link->stats().lease_expiries, 0u);
}

TEST(PlantLink, PulledStopLineHoldsWhateverTheRuntimeCommands) {
  auto link =
      Script().start().command(Time{10}, thrust(0.1, 1s)).command(Time{30}, thrust(0.3, 1s)).done(Time{30}).meet();
  ASSERT_TRUE(link->wait_start());
  ASSERT_TRUE(link->grant(Time{30}));
  EXPECT_TRUE(link->setpoints_at(kMotors, Time{19}).valid);
  link->stop_for_good();
  EXPECT_FALSE(link->setpoints_at(kMotors, Time{20}).valid);
  EXPECT_FALSE(link->setpoints_at(kMotors, Time{30}).valid);
}

TEST(PlantLink, DisarmedCommandIsASafeAction) {
  Command c = thrust(0.5, 1s);
  c.setpoints.armed = 0;
  auto link = Script().start().command(Time{0}, c).done(Time{0}).meet();
  ASSERT_TRUE(link->wait_start());
  ASSERT_TRUE(link->grant(Time{0}));
  EXPECT_FALSE(link->setpoints_at(kMotors, Time{0}).valid);
}

TEST(PlantLink, MoreWaitingCommandsThanItKeepsAreCounted) {
  Script script;
  script.start();
  for (int i = 0; i < 20; ++i) script.command(Time{100 + i}, thrust(0.01 * i, 1s));
  auto link = script.done(Time{50}).meet();
  ASSERT_TRUE(link->wait_start());
  ASSERT_TRUE(link->grant(Time{50}));
  EXPECT_EQ(link->stats().commands_overwritten, 20 - PlantLink::kPendingCommands);
  EXPECT_EQ(link->setpoints_at(kMotors, Time{119}).value[0], 0.01 * 19) << "the newest is never the one to go";
}

TEST(PlantLink, VersionMismatchIsToldToBothSides) {
  Hello old;
  old.version = 7;
  Script script(old);
  EXPECT_EQ(script.start().meet(), nullptr);
  EXPECT_EQ(script.why, "runtime speaks version 7 of the simulator protocol, plant 'bench' speaks version 1");
}

TEST(PlantLink, RuntimeThatLeavesIsHeardWithItsWords) {
  auto link = Script().start().bye("mission flown").meet();
  ASSERT_TRUE(link->wait_start());
  const auto status = link->grant(Time{0});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Errc::closed);
  EXPECT_EQ(link->reason(), "mission flown");
  EXPECT_FALSE(link->send(0, msg::ImuSample{}, Time{})) << "every later call says so again";
}

TEST(PlantLink, LostConnectionIsClosedWithoutWords) {
  auto link = Script().start().meet();
  ASSERT_TRUE(link->wait_start());
  const auto status = link->grant(Time{0});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Errc::closed);
  EXPECT_EQ(link->reason(), "connection to the runtime failed: closed: end of script");
}

struct Offence {
  const char* rule;
  void (*commit)(Script&);
};
class PlantLinkRefuses : public testing::TestWithParam<Offence> {};

TEST_P(PlantLinkRefuses, WhatThePageDoesNotAllow) {
  Script script;
  script.start();
  GetParam().commit(script);
  auto link = script.done(Time{5}).meet();
  ASSERT_TRUE(link->wait_start());
  const auto status = link->grant(Time{5});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Errc::bad_data);
  EXPECT_STREQ(status.error().where, GetParam().rule);
  const std::string said(reinterpret_cast<const char*>(script.wire->written.data()), script.wire->written.size());
  EXPECT_NE(said.find(GetParam().rule), std::string::npos) << "the runtime is told why";
}

INSTANTIATE_TEST_SUITE_P(
    All, PlantLinkRefuses,
    testing::Values(Offence{"Done does not answer the last Grant", [](Script& s) { s.done(Time{4}); }},
                    Offence{"message does not belong here", [](Script& s) { s.start(); }},
                    Offence{"message goes in the wrong direction", [](Script& s) { s.plain(Type::grant, 0, Time{1}); }},
                    Offence{"command does not fit the actuator group",
                            [](Script& s) {
                              Command three = thrust(0, 1s);
                              three.setpoints.count = 3;
                              s.command(Time{1}, three);
                            }},
                    Offence{"commit times go backwards",
                            [](Script& s) { s.command(Time{2}, thrust(0, 1s)).command(Time{1}, thrust(0, 1s)); }},
                    Offence{"setpoint is not a finite number",
                            [](Script& s) { s.command(Time{2}, thrust(1.0 / 0.0, 1s)); }}));

}  // namespace
}  // namespace sinew::sim_hil::plant_link_test
