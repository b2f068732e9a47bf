#include "drivers/joints/can_scan.hpp"

#include <gmock/gmock.h>

#include "servo_rig.hpp"
#include "sim_hil/wire/sim_dronecan.hpp"

namespace sinew::drivers::can_scan_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A bus in memory with simulated devices, and the scan at its other end; every frame of the scan is looked at.
class Scanned : public ::testing::Test {
 protected:
  Scanned() { clock.set(Time{1'000'000'000}); }
  template <class Sim, class... Args>
  Sim& add(Args&&... args) {
    auto& joint = *joints.emplace_back(std::make_unique<sim_hil::JointModel>());
    return sims.add<Sim>(joint, sim_hil::SimMount{}, std::forward<Args>(args)...);
  }
  sim_hil::SimCia402& drive(std::uint32_t node) {
    sim_hil::SimCia402::Parameters p;
    p.node_id = node;
    return add<sim_hil::SimCia402>(p);
  }
  sim_hil::SimMitMotor& motor(std::uint32_t id, const char* type, std::uint32_t master) {
    return add<sim_hil::SimMitMotor>(sim_hil::SimMitMotor::Parameters{id, master, *wire::mit_motor_type(type), 0s});
  }
  std::vector<std::string> scan(CanScan::Options options = {}) {
    CanScan scan(port, options);
    begin = clock.now();
    while (!scan.done()) {
      const auto next = scan.step(clock.now());
      EXPECT_TRUE(next) << next.error().where;
      if (!next) return {};
      msg::CanFrame f;
      for (auto got = spy.read(f); got && *got; got = spy.read(f)) seen.push_back(f);
      sims.poll(clock.now());
      clock.set(clock.now() + 1ms);
    }
    std::vector<std::string> texts;
    for (const CanFound& f : scan.found())
      texts.push_back(std::string(to_string(f.family)) + " " + std::to_string(f.id) + ": " + describe(f));
    return texts;
  }

  hal::ManualClock clock;
  sim_hil::MemoryCan wire{1'000'000, &clock};
  sim_hil::MemoryCanPort& port = wire.attach();
  sim_hil::MemoryCanPort& far = wire.attach();
  sim_hil::MemoryCanPort& spy = wire.attach();
  std::vector<std::unique_ptr<sim_hil::JointModel>> joints;
  sim_hil::SimServos sims{far};
  std::vector<msg::CanFrame> seen;
  Time begin{};
};

TEST_F(Scanned, EveryFamilyIsFoundWithWhatItSaysOfItself) {
  drive(1), drive(127);
  motor(2, "ak80_9", 0), motor(18, "ak80_9", 0), motor(3, "dm4310", 0x111);
  add<sim_hil::SimCyberGear>(sim_hil::SimCyberGear::Parameters{.motor = 3});
  sim_hil::SimDronecanServo::Parameters esc;
  esc.node_id = 42;
  add<sim_hil::SimDronecanServo>(esc);
  EXPECT_THAT(scan(),
              ElementsAre(HasSubstr("canopen 1: type 0x00020192 (CiA 402), vendor 0x00000051, product 0x00000402"),
                          HasSubstr("canopen 127: type"), "mit 2: answers under 0x000", "mit 3: answers under 0x111",
                          "mit 18: answers under 0x000", HasSubstr("cybergear 3: serial "),
                          "dronecan 42: health ok, operational"));
}

TEST_F(Scanned, AnEmptyBusIsSoAfterABoundedTime) {
  EXPECT_THAT(scan(), IsEmpty());
  EXPECT_LE(clock.now() - begin, CanScan::kListen + 1s);
}

TEST_F(Scanned, NothingIsEnabledAndNothingIsWritten) {
  auto& drive_1 = drive(1);
  auto& ak = motor(2, "ak80_9", 0x100);
  auto& gear = add<sim_hil::SimCyberGear>(sim_hil::SimCyberGear::Parameters{.motor = 3});
  scan();
  EXPECT_FALSE(drive_1.live() || ak.live() || gear.live());
  EXPECT_EQ(drive_1.nmt(), wire::NmtState::pre_operational) << "as it came up";
  for (const msg::CanFrame& f : seen) {
    if (f.extended()) {
      const auto kind = wire::split_cybergear_id(f.id).kind;
      EXPECT_EQ(kind, 0u) << "asks who it is, or is an answer to that";
      continue;
    }
    if (wire::canopen_id(f.id).kind == wire::CanopenKind::sdo_request) {
      const auto sdo = wire::decode_sdo_request(f);
      ASSERT_TRUE(sdo);
      EXPECT_EQ(sdo->kind, wire::Sdo::Kind::read);
    }
    if (const auto what = wire::decode_mit_switch(f)) {
      EXPECT_EQ(*what, wire::MitSwitch::disable);
    }
    EXPECT_NE(f.id, wire::kNmtId);
  }
}

TEST_F(Scanned, OnlyTheFamiliesThatAreAskedForAreAsked) {
  drive(1), motor(2, "ak80_9", 0);
  EXPECT_THAT(scan({.families = {CanFamily::canopen}}), ElementsAre(HasSubstr("canopen 1")));
  for (const msg::CanFrame& f : seen) EXPECT_FALSE(wire::decode_mit_switch(f)) << f.id;
  EXPECT_THAT(scan({.families = {CanFamily::mit}}), ElementsAre("mit 2: answers under 0x000"));
}

TEST_F(Scanned, ADeviceThatMissesTheFirstQuestionGetsASecond) {
  drive(5);
  int requests = 0;
  wire.lose(
      [&](const msg::CanFrame& f) { return !f.extended() && f.id == wire::sdo_request_id(5) && requests++ == 0; });
  EXPECT_THAT(scan({.families = {CanFamily::canopen}}), ElementsAre(HasSubstr("canopen 5: type 0x00020192")));
  EXPECT_GE(requests, 2);
}

TEST_F(Scanned, TheBusIsAQuarterFullAtMost) {
  sim_hil::MemoryCan slow{125'000, &clock};
  auto& asks = slow.attach();
  CanScan scan(asks, {.families = {CanFamily::canopen}});
  const Time from = clock.now();
  while (!scan.done()) {
    ASSERT_TRUE(scan.step(clock.now()));
    clock.set(clock.now() + 1ms);
  }
  EXPECT_EQ(scan.questions(), 2u * 127u);
  EXPECT_LT(static_cast<double>(slow.bits()) / 125'000, 0.26 * msg::seconds(clock.now() - from));
}

TEST_F(Scanned, ABusThatIsGoneIsAnError) {
  wire.connect(false);
  CanScan scan(port, {});
  hal::Result<Time> next = clock.now();
  for (int i = 0; i < 3000 && next; ++i) {
    next = scan.step(clock.now());
    clock.set(clock.now() + 1ms);
  }
  EXPECT_FALSE(next);
}

TEST_F(Scanned, ARunningDrivesOwnTrafficIsNobodysAnswer) {
  // PDOs, heartbeats and answers to another master.
  CanScan scan(port, {});
  while (!scan.done()) {
    ASSERT_TRUE(scan.step(clock.now()));
    msg::CanFrame pdo = wire::can_frame(wire::tpdo_id(1, 9), 8);
    pdo.data[0] = 9;
    ASSERT_TRUE(far.send(pdo, hal::kNever));
    ASSERT_TRUE(far.send(wire::encode_heartbeat(9, wire::NmtState::operational), hal::kNever));
    wire::Sdo other;
    other.kind = wire::Sdo::Kind::value;
    other.object = {0x6041, 0};
    other.set_value(0x27, 2);
    ASSERT_TRUE(far.send(wire::encode_sdo_reply(9, other), hal::kNever));
    clock.set(clock.now() + 1ms);
  }
  EXPECT_TRUE(scan.found().empty());
}

}  // namespace
}  // namespace sinew::drivers::can_scan_test
