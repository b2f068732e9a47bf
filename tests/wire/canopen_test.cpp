// Frames of CiA 301 and CiA 402 byte for byte, and back.
#include "wire/canopen.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "wire/cia402.hpp"

namespace sinew::wire::canopen_test {
namespace {

std::string text(const msg::CanFrame& frame) {
  char part[8];
  std::snprintf(part, sizeof part, "%03X#", frame.id);
  std::string out = part;
  for (const std::uint8_t b : frame.bytes()) {
    std::snprintf(part, sizeof part, "%02X", b);
    out += part;
  }
  return out;
}

TEST(Canopen, FramesAreThoseOfTheStandard) {
  EXPECT_EQ(text(encode_nmt(NmtCommand::start, 5)), "000#0105");
  EXPECT_EQ(text(encode_nmt(NmtCommand::pre_operational, 0)), "000#8000");
  EXPECT_EQ(text(encode_sync()), "080#");
  EXPECT_EQ(text(encode_heartbeat(5, NmtState::operational)), "705#05");
  EXPECT_EQ(text(encode_emergency(5, {0x3210, 0x05, {1, 2, 3, 4, 5}})), "085#1032050102030405");
  EXPECT_EQ(text(encode_sdo_request(5, sdo_write(kControlword, 0x0006, 2))), "605#2B40600006000000");
  EXPECT_EQ(text(encode_sdo_request(5, sdo_write(kModeOfOperation, 8, 1))), "605#2F60600008000000");
  EXPECT_EQ(text(encode_sdo_request(5, sdo_write(kTargetPosition, 0x01020304, 4))), "605#237A600004030201");
  EXPECT_EQ(text(encode_sdo_request(5, sdo_read(kVendorId))), "605#4018100100000000");
}

TEST(Canopen, RepliesOfTheStandardAreUnderstood) {
  const auto value = decode_sdo_reply(can_frame(0x585, {0x43, 0x18, 0x10, 0x01, 0x78, 0x56, 0x34, 0x12}));
  ASSERT_TRUE(value);
  EXPECT_EQ(value->kind, Sdo::Kind::value);
  EXPECT_EQ(value->object, kVendorId);
  EXPECT_EQ(value->size, 4);
  EXPECT_EQ(value->value(), 0x12345678u);
  const auto word = decode_sdo_reply(can_frame(0x585, {0x4B, 0x41, 0x60, 0x00, 0x37, 0x06, 0xAA, 0xBB}));
  ASSERT_TRUE(word);
  EXPECT_EQ(word->value(), 0x0637u) << "bytes beyond the size do not count";
  const auto written = decode_sdo_reply(can_frame(0x585, {0x60, 0x40, 0x60, 0x00, 0, 0, 0, 0}));
  ASSERT_TRUE(written);
  EXPECT_EQ(written->kind, Sdo::Kind::written);
  const auto abort = decode_sdo_reply(can_frame(0x585, {0x80, 0x40, 0x60, 0x00, 0x00, 0x00, 0x02, 0x06}));
  ASSERT_TRUE(abort);
  EXPECT_EQ(static_cast<SdoAbort>(abort->abort_code), SdoAbort::no_object);
  EXPECT_STREQ(to_string(SdoAbort::no_object), "no such object");
  EXPECT_STREQ(to_string(static_cast<SdoAbort>(1)), "unknown abort code");
}

TEST(Canopen, StringComesInSegments) {
  const auto begin = decode_sdo_reply(can_frame(0x585, {0x41, 0x08, 0x10, 0x00, 9, 0, 0, 0}));
  ASSERT_TRUE(begin);
  EXPECT_EQ(begin->kind, Sdo::Kind::begin_segments);
  EXPECT_EQ(begin->total, 9u);
  Sdo more;
  more.kind = Sdo::Kind::read_segment;
  EXPECT_EQ(text(encode_sdo_request(5, more)), "605#6000000000000000");
  more.toggle = true;
  EXPECT_EQ(text(encode_sdo_request(5, more)), "605#7000000000000000");
  const auto first = decode_sdo_reply(can_frame(0x585, {0x00, 'a', 'b', 'c', 'd', 'e', 'f', 'g'}));
  const auto last = decode_sdo_reply(can_frame(0x585, {0x1B, 'h', 'i', 0, 0, 0, 0, 0}));
  ASSERT_TRUE(first && last);
  EXPECT_EQ(first->size, 7);
  EXPECT_FALSE(first->last || first->toggle);
  EXPECT_EQ(last->size, 2);
  EXPECT_TRUE(last->last && last->toggle);
}

TEST(Canopen, IdentifiersMeanWhatThePredefinedConnectionSetSays) {
  const auto is = [](std::uint32_t id, CanopenKind kind, std::uint32_t node, std::uint32_t number) {
    const CanopenId c = canopen_id(id);
    return c.kind == kind && c.node == node && c.number == number;
  };
  EXPECT_TRUE(is(0x000, CanopenKind::nmt, 0, 0));
  EXPECT_TRUE(is(0x080, CanopenKind::sync, 0, 0));
  EXPECT_TRUE(is(0x0FF, CanopenKind::emergency, 127, 0));
  EXPECT_TRUE(is(0x185, CanopenKind::tpdo, 5, 1));
  EXPECT_TRUE(is(0x485, CanopenKind::tpdo, 5, 4));
  EXPECT_TRUE(is(0x205, CanopenKind::rpdo, 5, 1));
  EXPECT_TRUE(is(0x505, CanopenKind::rpdo, 5, 4));
  EXPECT_TRUE(is(0x585, CanopenKind::sdo_reply, 5, 0));
  EXPECT_TRUE(is(0x605, CanopenKind::sdo_request, 5, 0));
  EXPECT_TRUE(is(0x705, CanopenKind::heartbeat, 5, 0));
  EXPECT_TRUE(is(0x7E5, CanopenKind::other, 0, 0));
  EXPECT_TRUE(is(0x12345, CanopenKind::other, 0, 0));
  for (std::uint32_t n = 1; n <= 4; ++n) {
    EXPECT_TRUE(is(tpdo_id(n, 9), CanopenKind::tpdo, 9, n));
    EXPECT_TRUE(is(rpdo_id(n, 9), CanopenKind::rpdo, 9, n));
  }
}

TEST(Canopen, OtherSizesAndKindsAreNoFrames) {
  msg::CanFrame frame = encode_emergency(5, {});
  EXPECT_TRUE(decode_emergency(frame));
  frame.size = 7;
  EXPECT_FALSE(decode_emergency(frame));
  frame = encode_heartbeat(5, NmtState::operational);
  frame.flags = msg::kCanRemote;
  EXPECT_FALSE(decode_heartbeat(frame)) << "node guarding's question is no heartbeat";
  frame.flags = 0;
  frame.data[0] = 3;
  EXPECT_FALSE(decode_heartbeat(frame));
  frame = encode_sdo_reply(5, {});
  frame.flags = msg::kCanFd;
  EXPECT_FALSE(decode_sdo_reply(frame));
  EXPECT_FALSE(decode_sdo_request(can_frame(0x605, {0x21, 0, 0, 0, 0, 0, 0, 0}))) << "segmented writing is not part";
}

TEST(Cia402, StatusWordsAreTheStatesOfTheStandard) {
  EXPECT_EQ(drive_state(0x0000), DriveState::not_ready);
  EXPECT_EQ(drive_state(0x0250), DriveState::switch_on_disabled);
  EXPECT_EQ(drive_state(0x0231), DriveState::ready_to_switch_on);
  EXPECT_EQ(drive_state(0x0233), DriveState::switched_on);
  EXPECT_EQ(drive_state(0x0637), DriveState::operation_enabled);
  EXPECT_EQ(drive_state(0x0617), DriveState::quick_stop_active);
  EXPECT_EQ(drive_state(0x021F), DriveState::fault_reaction);
  EXPECT_EQ(drive_state(0x0218), DriveState::fault);
  EXPECT_FALSE(drive_state(0x0001)) << "no state has these bits";
}

TEST(Cia402, EveryStateReachesEveryGoal) {
  for (int s = 0; s <= static_cast<int>(DriveState::fault); ++s) {
    for (const DriveGoal goal : {DriveGoal::enabled, DriveGoal::off}) {
      auto state = static_cast<DriveState>(s);
      if (state == DriveState::not_ready || state == DriveState::fault_reaction) continue;  // left by the drive itself
      std::uint16_t before = 0;
      for (int step = 0; step < 6; ++step) {
        std::uint16_t word = next_controlword(state, goal);
        if (state == DriveState::fault) word = before == 0 ? kControlFaultReset : 0;
        state = next_state(state, word, before);
        before = word;
      }
      EXPECT_EQ(state, goal == DriveGoal::enabled ? DriveState::operation_enabled : DriveState::switch_on_disabled)
          << to_string(static_cast<DriveState>(s));
    }
  }
}

TEST(Cia402, FaultIsLeftByTheEdgeOfTheResetBitOnly) {
  EXPECT_EQ(next_state(DriveState::fault, kControlEnable, 0), DriveState::fault);
  EXPECT_EQ(next_state(DriveState::fault, kControlFaultReset, kControlFaultReset), DriveState::fault);
  EXPECT_EQ(next_state(DriveState::fault, kControlFaultReset, 0), DriveState::switch_on_disabled);
}

TEST(Cia402, QuickStopEndsInNoTorque) {
  const auto stopping = next_state(DriveState::operation_enabled, kControlQuickStop, kControlEnable);
  EXPECT_EQ(stopping, DriveState::quick_stop_active);
  EXPECT_EQ(next_state(stopping, kControlDisableVoltage, kControlQuickStop), DriveState::switch_on_disabled);
}

TEST(Cia402, ErrorCodesBecomeFaultsOfTheJoint) {
  EXPECT_EQ(joint_faults(0), 0u);
  EXPECT_EQ(joint_faults(0x2310), std::uint32_t{msg::kJointOverCurrent});
  EXPECT_EQ(joint_faults(0x3210), std::uint32_t{msg::kJointOverVoltage});
  EXPECT_EQ(joint_faults(0x3220), std::uint32_t{msg::kJointUnderVoltage});
  EXPECT_EQ(joint_faults(0x4310), std::uint32_t{msg::kJointOverTemperature});
  EXPECT_EQ(joint_faults(0x7305), std::uint32_t{msg::kJointEncoder});
  EXPECT_EQ(joint_faults(0x7121), std::uint32_t{msg::kJointOverload});
  EXPECT_EQ(joint_faults(0x8611), std::uint32_t{msg::kJointOverload});
  EXPECT_EQ(joint_faults(0x8130), std::uint32_t{msg::kJointLost});
  EXPECT_EQ(joint_faults(0xFF01), std::uint32_t{msg::kJointOther});
}

}  // namespace
}  // namespace sinew::wire::canopen_test
