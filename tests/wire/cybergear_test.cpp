// CyberGear frames byte for byte. The golden bytes were computed apart from this code, from the manual's ranges.
#include "wire/cybergear.hpp"

#include <gtest/gtest.h>

#include <array>

namespace sinew::wire::cybergear_test {
namespace {

using Bytes = std::array<std::uint8_t, 8>;
Bytes bytes(const msg::CanFrame& f) {
  Bytes out{};
  for (std::size_t i = 0; i < 8; ++i) out[i] = f.data[i];
  return out;
}

TEST(CyberGear, MotionCarriesTheTorqueInItsIdentifier) {
  const msg::CanFrame frame = encode_cybergear_motion(7, {1.0, -2.0, 100, 1, 3.0});
  EXPECT_TRUE(frame.extended());
  EXPECT_EQ(frame.id, 0x019FFF07u);
  EXPECT_EQ(bytes(frame), (Bytes{0x8A, 0x3D, 0x77, 0x77, 0x33, 0x33, 0x33, 0x33}));
  const auto back = decode_cybergear_motion(frame);
  ASSERT_TRUE(back);
  EXPECT_NEAR(back->effort_nm, 3, 24.0 / 65535);
  EXPECT_NEAR(back->kp, 100, 500.0 / 65535);
}

TEST(CyberGear, FeedbackIsUnderstood) {
  msg::CanFrame frame = can_frame(0x02840700, {0x8A, 0x3D, 0x77, 0x77, 0x9F, 0xFF, 0x01, 0x9C});
  frame.id = 0x0284'07FDu;  // running, bit 2: over-temperature, motor 7 to host FD
  frame.flags = msg::kCanExtended;
  const auto f = decode_cybergear_feedback(frame);
  ASSERT_TRUE(f);
  EXPECT_EQ(f->motor, 7u);
  EXPECT_EQ(f->host, 0xFDu);
  EXPECT_EQ(f->mode, CyberGearFeedback::Mode::running);
  EXPECT_EQ(f->faults, std::uint32_t{msg::kJointOverTemperature});
  EXPECT_NEAR(f->position_rad, 1, 25.0 / 65535);
  EXPECT_NEAR(f->velocity_radps, -2, 60.0 / 65535);
  EXPECT_NEAR(f->effort_nm, 3, 24.0 / 65535);
  EXPECT_NEAR(f->temperature_c, 41.2, 1e-9);
  frame.id |= 0xC00000;  // a mode that there is not
  EXPECT_FALSE(decode_cybergear_feedback(frame));
}

TEST(CyberGear, SwitchesAndParametersAreTheManuals) {
  EXPECT_EQ(encode_cybergear(CyberGearKind::enable, 0xFD, 7).id, 0x0300FD07u);
  const msg::CanFrame stop = encode_cybergear(CyberGearKind::stop, 0xFD, 7, true);
  EXPECT_EQ(stop.id, 0x0400FD07u);
  EXPECT_EQ(stop.data[0], 1) << "clears faults";
  CyberGearParameter p{kCyberGearLimitTorque, 0};
  p.set_real(2.5F);
  const msg::CanFrame write = encode_cybergear_parameter(CyberGearKind::write, 0xFD, 7, p);
  EXPECT_EQ(write.id, 0x1200FD07u);
  EXPECT_EQ(bytes(write), (Bytes{0x0B, 0x70, 0, 0, 0x00, 0x00, 0x20, 0x40}));
  const auto back = decode_cybergear_parameter(write);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->real(), 2.5F);
}

TEST(CyberGear, IdentityAndFaultReport) {
  const msg::CanFrame me = encode_cybergear_identity(7, 0x1122334455667788);
  EXPECT_EQ(me.id, 0x000007FEu);
  EXPECT_EQ(decode_cybergear_identity(me), 0x1122334455667788u);
  EXPECT_EQ(decode_cybergear_fault(encode_cybergear_fault(7, 0xFD, 4)), 4u);
  EXPECT_EQ(joint_faults_of_report(4), std::uint32_t{msg::kJointUnderVoltage});
  EXPECT_EQ(joint_faults_of_report(1u << 31), std::uint32_t{msg::kJointOther});
}

TEST(CyberGear, StandardFramesAndOtherSizesAreNone) {
  msg::CanFrame frame = encode_cybergear_feedback({});
  EXPECT_TRUE(decode_cybergear_feedback(frame));
  frame.size = 7;
  EXPECT_FALSE(decode_cybergear_feedback(frame));
  frame.size = 8;
  frame.flags = 0;
  EXPECT_FALSE(decode_cybergear_feedback(frame));
}

}  // namespace
}  // namespace sinew::wire::cybergear_test
