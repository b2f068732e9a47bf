#include "wire/dronecan_types.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "wire/dronecan_bits.hpp"

namespace sinew::wire::dronecan_types_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <class T>
Bytes encoded(const T& message) {
  Bytes out(kDronecanMaxPayload, 0xEE);
  out.resize(encode(message, out));
  return out;
}

TEST(DronecanBits, HalvesAreThoseOfTheStandard) {
  for (const auto& [value, half] : {std::pair{0.0f, 0x0000},
                                    {-0.0f, 0x8000},
                                    {0.5f, 0x3800},
                                    {1.0f, 0x3C00},
                                    {-2.0f, 0xC000},
                                    {65504.0f, 0x7BFF},
                                    {0x1p-14f, 0x0400},
                                    {0x1p-24f, 0x0001},
                                    {0.1f, 0x2E66},
                                    {293.15f, 0x5C95}})
    EXPECT_EQ(half_from_float(value), half) << value;
  EXPECT_EQ(half_from_float(1e9f), 0x7BFF) << "saturated";
  EXPECT_EQ(half_from_float(-1e9f), 0xFBFF);
  EXPECT_EQ(half_from_float(0x1p-26f), 0);
  EXPECT_EQ(half_from_float(1.0f + 0x1p-11f), 0x3C00) << "a tie goes to the even one";
  EXPECT_EQ(half_from_float(1.0f + 3 * 0x1p-11f), 0x3C02);
  EXPECT_TRUE(std::isnan(float_from_half(half_from_float(NAN))));
  EXPECT_EQ(float_from_half(half_from_float(INFINITY)), INFINITY);
}

TEST(DronecanBits, EveryHalfComesBack) {
  for (std::uint32_t half = 0; half < 0x10000; ++half) {
    const float value = float_from_half(static_cast<std::uint16_t>(half));
    if (std::isnan(value)) continue;
    ASSERT_EQ(half_from_float(value), half);
  }
}

TEST(DronecanBits, EveryFloatBecomesTheNearestHalf) {
  std::mt19937 random(11);
  for (int i = 0; i < 200000; ++i) {
    const float value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (!(std::fabs(value) <= 65504.0f)) continue;
    const std::uint16_t half = half_from_float(value);
    const double error = std::fabs(double{float_from_half(half)} - value);
    for (const int beside : {-1, 1}) {
      const float other = float_from_half(static_cast<std::uint16_t>(half + beside));
      if (std::isfinite(other)) {
        ASSERT_LE(error, std::fabs(double{other} - value)) << value;
      }
    }
  }
}

TEST(DronecanBits, FieldsOfAnyWidthComeBack) {
  std::mt19937_64 random(12);
  for (int round = 0; round < 2000; ++round) {
    std::vector<std::pair<std::uint64_t, int>> fields;
    Bytes bytes(256);
    BitWriter writer(bytes);
    for (int i = 0; i < 20; ++i) {
      const int bits = 1 + static_cast<int>(random() % 64);
      fields.emplace_back(random() & (bits == 64 ? ~0ull : (1ull << bits) - 1), bits);
      writer.put(fields.back().first, bits);
    }
    bytes.resize(writer.size());
    BitReader reader(bytes);
    for (const auto& [value, bits] : fields) ASSERT_EQ(reader.take(bits), value);
    ASSERT_TRUE(reader.ok());
    ASSERT_LT(reader.bits_left(), 8u);
  }
}

TEST(DronecanBits, NumbersBeyondTheirFieldArePulledIn) {
  Bytes bytes(8);
  BitWriter writer(bytes);
  writer.put_signed(100000, 14), writer.put_signed(-100000, 14), writer.put_unsigned(200, 7), writer.put_signed(-1, 18);
  BitReader reader(bytes);
  EXPECT_EQ(reader.take_signed(14), 8191);
  EXPECT_EQ(reader.take_signed(14), -8192);
  EXPECT_EQ(reader.take(7), 127u);
  EXPECT_EQ(reader.take_signed(18), -1);
  EXPECT_TRUE(reader.ok());
  EXPECT_EQ(reader.take(64), 0u);
  EXPECT_FALSE(reader.ok());
}

TEST(DronecanTypes, NodeStatusFillsOneFrame) {
  DronecanNodeStatus status;
  status.uptime_s = 0x01020304, status.health = DronecanHealth::error, status.mode = 1, status.sub_mode = 5;
  status.vendor_code = 0xABCD;
  EXPECT_EQ(encoded(status), (Bytes{4, 3, 2, 1, 0b10'001'101, 0xCD, 0xAB}));
  DronecanNodeStatus back;
  ASSERT_TRUE(decode(encoded(status), back));
  EXPECT_EQ(back.health, DronecanHealth::error);
  EXPECT_EQ(back.mode, 1);
  EXPECT_EQ(back.sub_mode, 5);
  EXPECT_FALSE(decode(Bytes(6), back));
}

TEST(DronecanTypes, NodeInfoKeepsItsNameAndSkipsCertificates) {
  DronecanNodeInfo info;
  info.software_major = 1, info.software_minor = 2, info.vcs_commit = 0xDEADBEEF, info.image_crc = 0x1122334455667788;
  info.hardware_major = 3;
  for (std::uint8_t i = 0; i < 16; ++i) info.unique_id[i] = i;
  info.set_name("org.sinew.robot");
  Bytes bytes = encoded(info);
  EXPECT_EQ(bytes.size(), 7u + 15 + 19 + 15);
  DronecanNodeInfo back;
  ASSERT_TRUE(decode(bytes, back));
  EXPECT_EQ(back.name(), "org.sinew.robot");
  EXPECT_EQ(back.vcs_commit, 0xDEADBEEFu);
  EXPECT_EQ(back.image_crc, 0x1122334455667788u);
  EXPECT_EQ(back.unique_id, info.unique_id);

  bytes[40] = 3;  // a certificate of three bytes
  bytes.insert(bytes.begin() + 41, {9, 9, 9});
  ASSERT_TRUE(decode(bytes, back));
  EXPECT_EQ(back.name(), "org.sinew.robot");
  bytes[40] = 200;
  EXPECT_FALSE(decode(bytes, back)) << "cut in the certificate";
  bytes[40] = 3;
  bytes.resize(44 + 81);
  EXPECT_FALSE(decode(bytes, back)) << "a name of 81";
  info.set_name(std::string(100, 'x'));
  ASSERT_TRUE(decode(encoded(info), back));
  EXPECT_EQ(back.name().size(), 80u);
}

TEST(DronecanTypes, OnlyFullyArmedIsArmed) {
  EXPECT_EQ(encoded(DronecanArmingStatus{true}), (Bytes{255}));
  EXPECT_EQ(encoded(DronecanArmingStatus{}), (Bytes{0}));
  DronecanArmingStatus back;
  ASSERT_TRUE(decode(Bytes{255}, back));
  EXPECT_TRUE(back.armed);
  ASSERT_TRUE(decode(Bytes{254}, back));
  EXPECT_FALSE(back.armed);
  EXPECT_FALSE(decode(Bytes{}, back));
}

TEST(DronecanTypes, AllocationHasItsFlagBelowTheNodeId) {
  DronecanAllocation a;
  a.node_id = 100, a.first_part = true, a.size = 6;
  a.unique_id = {1, 2, 3, 4, 5, 6};
  EXPECT_EQ(encoded(a), (Bytes{201, 1, 2, 3, 4, 5, 6}));
  DronecanAllocation back;
  ASSERT_TRUE(decode(encoded(a), back));
  EXPECT_EQ(back.node_id, 100);
  EXPECT_TRUE(back.first_part);
  EXPECT_EQ(back.size, 6);
  EXPECT_FALSE(decode(Bytes{}, back));
  EXPECT_FALSE(decode(Bytes(18), back));
}

TEST(DronecanTypes, RawCommandsOfEveryCountComeBack) {
  std::mt19937 random(13);
  for (std::uint8_t count = 0; count <= 20; ++count) {
    DronecanEscRawCommand command, back;
    command.count = count;
    for (std::size_t i = 0; i < count; ++i)
      command.command[i] = static_cast<std::int16_t>(static_cast<int>(random() % 16384) - 8192);
    ASSERT_TRUE(decode(encoded(command), back));
    EXPECT_EQ(back.count, count);
    EXPECT_EQ(back.command, command.command);
  }
  DronecanEscRawCommand back;
  EXPECT_FALSE(decode(Bytes(1), back));
  EXPECT_FALSE(decode(Bytes(3), back)) << "ten bits too many";
  EXPECT_FALSE(decode(Bytes(36), back));
  DronecanEscRawCommand wrong;
  wrong.count = 21;
  EXPECT_TRUE(encoded(wrong).empty());
}

TEST(DronecanTypes, StatusOfEscAndActuatorComeBack) {
  DronecanEscStatus esc, esc_back;
  esc.error_count = 7, esc.voltage_v = 12.5, esc.current_a = -3.25, esc.temperature_k = NAN;
  esc.rpm = -54321, esc.power_pct = 55, esc.esc_index = 3;
  EXPECT_EQ(encoded(esc).size(), 14u);
  ASSERT_TRUE(decode(encoded(esc), esc_back));
  EXPECT_EQ(esc_back.error_count, 7u);
  EXPECT_EQ(esc_back.voltage_v, 12.5);
  EXPECT_EQ(esc_back.current_a, -3.25);
  EXPECT_TRUE(std::isnan(esc_back.temperature_k));
  EXPECT_EQ(esc_back.rpm, -54321);
  EXPECT_EQ(esc_back.power_pct, 55);
  EXPECT_EQ(esc_back.esc_index, 3);
  EXPECT_FALSE(decode(Bytes(13), esc_back));

  DronecanActuatorStatus actuator, actuator_back;
  actuator.actuator_id = 4, actuator.position = 0.5, actuator.force = -1, actuator.speed = 2, actuator.power_pct = 100;
  EXPECT_EQ(encoded(actuator), (Bytes{4, 0x00, 0x38, 0x00, 0xBC, 0x00, 0x40, 100}));
  ASSERT_TRUE(decode(encoded(actuator), actuator_back));
  EXPECT_EQ(actuator_back.position, 0.5);
  EXPECT_EQ(actuator_back.force, -1);
  EXPECT_EQ(actuator_back.speed, 2);
  EXPECT_EQ(actuator_back.power_pct, 100);
  EXPECT_FALSE(decode(Bytes(7), actuator_back));
}

TEST(DronecanTypes, ActuatorCommandsAreWholeOnes) {
  DronecanActuatorCommand command, back;
  command.count = 15;
  for (std::uint8_t i = 0; i < 15; ++i)
    command.command[i] = {i, static_cast<std::uint8_t>(DronecanCommandType::speed), i * 0.25};
  ASSERT_TRUE(decode(encoded(command), back));
  EXPECT_EQ(back.count, 15);
  EXPECT_EQ(back.command[14].value, 3.5);
  EXPECT_FALSE(decode(Bytes(5), back));
  EXPECT_FALSE(decode(Bytes(64), back));
}

}  // namespace
}  // namespace sinew::wire::dronecan_types_test
