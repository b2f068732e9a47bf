// MIT frames byte for byte. The golden bytes were computed apart from this code, from the firmware's formula.
#include "wire/mit_motor.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace sinew::wire::mit_motor_test {
namespace {

std::array<std::uint8_t, 8> bytes(const msg::CanFrame& f) {
  std::array<std::uint8_t, 8> out{};
  for (std::size_t i = 0; i < 8; ++i) out[i] = f.data[i];
  return out;
}
using Bytes = std::array<std::uint8_t, 8>;

TEST(MitMotor, CommandLiesInItsBits) {
  const MitMotorType& type = *mit_motor_type("ak80_9");
  const msg::CanFrame frame = encode_mit(3, {1.0, -2.0, 100, 1, 3.0}, type);
  EXPECT_EQ(frame.id, 3u);
  EXPECT_EQ(frame.size, 8u);
  EXPECT_EQ(bytes(frame), (Bytes{0x8A, 0x3D, 0x7A, 0xE3, 0x33, 0x33, 0x39, 0x55}));
}

TEST(MitMotor, SwitchesAreSevenOnesAndACode) {
  EXPECT_EQ(bytes(encode_mit(1, MitSwitch::enable)), (Bytes{255, 255, 255, 255, 255, 255, 255, 0xFC}));
  EXPECT_EQ(bytes(encode_mit(1, MitSwitch::disable)), (Bytes{255, 255, 255, 255, 255, 255, 255, 0xFD}));
  EXPECT_EQ(bytes(encode_mit(1, MitSwitch::zero)), (Bytes{255, 255, 255, 255, 255, 255, 255, 0xFE}));
  EXPECT_EQ(decode_mit_switch(encode_mit(1, MitSwitch::zero)), MitSwitch::zero);
}

TEST(MitMotor, NoSetpointIsASwitch) {
  const MitMotorType& type = *mit_motor_type("ak80_9");
  const msg::CanFrame all = encode_mit(1, {1e9, 1e9, 1e9, 1e9, 1e9}, type);
  EXPECT_FALSE(decode_mit_switch(all));
  const auto command = decode_mit_command(all, type);
  ASSERT_TRUE(command);
  EXPECT_NEAR(command->effort_nm, 18, 18.0 * 2 / 4095 * 17) << "by little less";
}

TEST(MitMotor, ReplyIsUnderstood) {
  const MitMotorType& type = *mit_motor_type("ak80_9");
  const auto reply =
      decode_mit_reply(can_frame(0, {0x03, 0x7A, 0xE1, 0x99, 0x96, 0x00, 75, 2}), type);  // 35 degC, over-current
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->motor, 3u);
  EXPECT_NEAR(reply->position_rad, -0.5, 25.0 / 65535);
  EXPECT_NEAR(reply->velocity_radps, 10, 100.0 / 4095);
  EXPECT_NEAR(reply->effort_nm, -4.5, 36.0 / 4095);
  EXPECT_EQ(reply->temperature_c, 35);
  EXPECT_EQ(reply->faults, std::uint32_t{msg::kJointOverCurrent});
  EXPECT_TRUE(std::isnan(reply->voltage_v));
}

TEST(MitMotor, PlainReplyMayCarryTheVoltage) {
  const MitMotorType& type = *mit_motor_type("cheetah");
  EXPECT_TRUE(decode_mit_reply(can_frame(0, {1, 0x80, 0, 0x80, 0x08, 0x00}), type));
  const auto with = decode_mit_reply(can_frame(0, {1, 0x80, 0, 0x80, 0x08, 0x00, 48}), type);
  ASSERT_TRUE(with);
  EXPECT_EQ(with->voltage_v, 24);
  EXPECT_FALSE(decode_mit_reply(can_frame(0, {1, 0x80, 0, 0x80, 0x08}), type));
}

TEST(MitMotor, StatusOfDamiaoSaysEnabledOrWhy) {
  const MitMotorType& type = *mit_motor_type("dm4310");
  const auto enabled = decode_mit_reply(can_frame(0, {0x12, 0x80, 0, 0x80, 0x08, 0x00, 40, 52}), type);
  ASSERT_TRUE(enabled);
  EXPECT_EQ(enabled->motor, 2u);
  EXPECT_TRUE(enabled->status_known && enabled->enabled);
  EXPECT_EQ(enabled->temperature_c, 52) << "the warmer of the two";
  EXPECT_EQ(enabled->faults, 0u);
  const auto hot = decode_mit_reply(can_frame(0, {0xB2, 0x80, 0, 0x80, 0x08, 0x00, 120, 52}), type);
  ASSERT_TRUE(hot);
  EXPECT_FALSE(hot->enabled);
  EXPECT_EQ(hot->faults, std::uint32_t{msg::kJointOverTemperature});
  EXPECT_EQ(hot->code, 0xBu);
}

TEST(MitMotor, RoundTripIsExactToAStep) {
  constexpr double kHalf = 1.001;  // half a step, and rounding
  for (const MitMotorType& type : mit_motor_types()) {
    for (int i = -10; i <= 10; ++i) {
      const double part = i / 10.0;
      const MitCommand in{part * type.position_rad, part * type.velocity_radps, std::abs(part) * type.kp,
                          std::abs(part) * type.kd, part * type.effort_nm};
      const auto out = decode_mit_command(encode_mit(1, in, type), type);
      ASSERT_TRUE(out) << type.name;
      EXPECT_NEAR(out->position_rad, in.position_rad, type.position_rad / 65535 * kHalf);
      EXPECT_NEAR(out->velocity_radps, in.velocity_radps, type.velocity_radps / 4095 * kHalf);
      EXPECT_NEAR(out->kp, in.kp, type.kp / 4095);
      EXPECT_NEAR(out->kd, in.kd, type.kd / 4095);
      EXPECT_NEAR(out->effort_nm, in.effort_nm, i == 10 ? type.effort_nm * 0.01 : type.effort_nm / 4095 * kHalf);
    }
  }
  EXPECT_EQ(mit_motor_type("ak47"), nullptr);
}

}  // namespace
}  // namespace sinew::wire::mit_motor_test
