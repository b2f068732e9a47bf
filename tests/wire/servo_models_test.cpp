#include "wire/servos/servo_models.hpp"

#include <gtest/gtest.h>

#include <set>

#include "bytes.hpp"
#include "msg/joints.hpp"

namespace sinew::wire::servo_models_test {
namespace {

using test::Bytes;

TEST(ServoModels, EachHasANameANumberAndAllThatACycleNeeds) {
  std::set<std::string_view> names;
  for (const ServoModel& m : servo_models()) {
    EXPECT_TRUE(names.insert(m.name).second) << m.name;
    EXPECT_EQ(servo_model(m.name), &m);
    EXPECT_EQ(servo_model(m.version, m.number), &m) << m.name;
    EXPECT_FALSE(m.source.empty()) << m.name;
    for (const ServoRegister& r : {m.model_number, m.id, m.return_delay, m.torque_enable, m.goal_position,
                                   m.present_position, m.present_velocity, m.present_voltage, m.present_temperature})
      EXPECT_TRUE(static_cast<bool>(r)) << m.name;
    EXPECT_GT(m.radps_per_count, 0) << m.name;
    EXPECT_LT(m.least, m.centre) << m.name;
    EXPECT_GT(m.most, m.centre) << m.name;
    EXPECT_EQ(m.has_effort_mode, static_cast<bool>(m.goal_effort)) << m.name;
  }
  EXPECT_EQ(servo_model("xm999"), nullptr);
  EXPECT_EQ(servo_model(DxlVersion::one, 1020), nullptr);
}

TEST(ServoModels, ACycleOfAnXm430IsTenBytes) {
  const ServoRegister cycle = servo_model("xm430_w350")->cycle();
  EXPECT_EQ(cycle.address, 126);
  EXPECT_EQ(cycle.size, 10);
  EXPECT_EQ(servo_model("mx28")->cycle().size, 6);
}

TEST(ServoModels, NegativeNumbersAreTheModels) {
  const ServoModel &x = *servo_model("xm430_w350"), &mx = *servo_model("mx28"), &sts = *servo_model("sts3215");
  const Bytes minus_one{0xFF, 0xFF, 0xFF, 0xFF};
  EXPECT_EQ(servo_number(x, x.present_position, 132, minus_one), -1);
  EXPECT_EQ(servo_number(x, x.present_effort, 126, minus_one), -1);
  EXPECT_EQ(servo_number(mx, mx.present_velocity, 38, Bytes{0x2C, 0x05}), -300) << "bit 10: clockwise";
  EXPECT_EQ(servo_number(sts, sts.present_position, 56, Bytes{0x01, 0x80}), -1) << "bit 15";
  EXPECT_EQ(servo_number(mx, mx.present_position, 36, Bytes{0xFF, 0x0F}), 4095);
}

TEST(ServoModels, ScsPutsTheHighByteFirst) {
  const ServoModel& scs = *servo_model("scs0009");
  EXPECT_EQ(servo_number(scs, scs.present_position, 56, Bytes{0x02, 0x05}), 0x0205);
  const ServoBytes bytes = servo_bytes(scs, scs.goal_position, 0x0123);
  EXPECT_EQ(bytes.data[0], 0x01);
  EXPECT_EQ(bytes.data[1], 0x23);
}

TEST(ServoModels, WhatIsWrittenIsReadBack) {
  for (const ServoModel& m : servo_models())
    for (const ServoRegister& r : {m.goal_position, m.goal_velocity, m.present_velocity, m.present_effort})
      for (const std::int32_t value : {0, 1, 300, 1023}) {
        for (const std::int32_t sign : {1, -1}) {
          if (sign < 0 && r.sign_bit == 0 && m.version == DxlVersion::one) continue;  // never negative
          Bytes table(8);
          ASSERT_TRUE(put_servo_number(m, r, static_cast<std::uint16_t>(r.address - 2), sign * value, table)) << m.name;
          EXPECT_EQ(servo_number(m, r, static_cast<std::uint16_t>(r.address - 2), table), sign * value) << m.name;
        }
      }
}

TEST(ServoModels, ValuesThatDoNotFitArePulledIn) {
  const ServoModel &x = *servo_model("xm430_w350"), &mx = *servo_model("mx28");
  EXPECT_EQ(servo_bytes(x, x.bus_watchdog, 300).data[0], 255);
  const ServoBytes load = servo_bytes(mx, mx.present_effort, -5000);
  EXPECT_EQ(load.data[0], 0xFF);
  EXPECT_EQ(load.data[1], 0x07) << "1023, clockwise";
  EXPECT_EQ(servo_bytes(mx, mx.goal_position, -3).data[0], 0);
}

TEST(ServoModels, ARegisterOutsideOfWhatWasReadIsNothing) {
  const ServoModel& x = *servo_model("xm430_w350");
  EXPECT_EQ(servo_number(x, x.present_position, 126, Bytes(9)), std::nullopt) << "one byte is missing";
  EXPECT_EQ(servo_number(x, x.present_position, 133, Bytes(20)), std::nullopt);
  EXPECT_EQ(servo_number(x, ServoRegister{}, 0, Bytes(20)), std::nullopt);
  Bytes table(9);
  EXPECT_FALSE(put_servo_number(x, x.present_position, 126, 1, table));
}

TEST(ServoModels, FaultBitsHaveWords) {
  EXPECT_EQ(servo_faults(*servo_model("xm430_w350"), 1u << 5), msg::kJointOverload);
  EXPECT_EQ(servo_faults(*servo_model("xm430_w350"), 1u << 3 | 1u << 2),
            msg::kJointEncoder | msg::kJointOverTemperature);
  EXPECT_EQ(servo_faults(*servo_model("mx28"), kDxl1Overload | kDxl1Range | kDxl1Checksum), msg::kJointOverload)
      << "errors of a packet are no faults of the servo";
  EXPECT_EQ(servo_faults(*servo_model("sts3215"), 1u << 3), msg::kJointOverCurrent);
}

TEST(ServoModels, BitRatesHaveTheCodesOfTheirTables) {
  EXPECT_EQ(servo_rate_code(*servo_model("xm430_w350"), 1'000'000), 3);
  EXPECT_EQ(servo_rate_code(*servo_model("xl430_w250"), 57'600), 1);
  EXPECT_EQ(servo_rate_code(*servo_model("ax12"), 1'000'000), 1);
  EXPECT_EQ(servo_rate_code(*servo_model("mx28"), 57'600), 34);
  EXPECT_EQ(servo_rate_code(*servo_model("sts3215"), 1'000'000), 0);
  EXPECT_EQ(servo_rate_code(*servo_model("scs0009"), 115'200), 4);
  EXPECT_FALSE(servo_rate_code(*servo_model("sts3215"), 2'000'000));
  // Protocol 1.0: 2 Mbit/s by the code and one more, near enough for a UART.
  for (const ServoRate& rate : servo_model("mx28")->rates)
    EXPECT_NEAR(2e6 / (rate.code + 1.0) / rate.bit_rate, 1, 0.025) << rate.bit_rate;
  for (const ServoModel& m : servo_models()) {
    EXPECT_TRUE(m.bit_rate) << m.name;
    EXPECT_TRUE(servo_rate_code(m, 57'600)) << m.name;
  }
}

}  // namespace
}  // namespace sinew::wire::servo_models_test
