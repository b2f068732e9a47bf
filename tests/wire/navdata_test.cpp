#include "wire/text/navdata.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace sinew::wire::navdata_test {
namespace {

/// Header and demo option as a drone sent them (a landed one on its feet, 50 % battery), with the sum behind.
std::vector<std::uint8_t> captured() {
  std::vector<std::uint8_t> bytes{0x88, 0x77, 0x66, 0x55, 0xd0, 0x00, 0x80, 0x4f, 0xa7, 0x96, 0x04, 0x00, 0x01,
                                  0x00, 0x00, 0x00, 0x00, 0x00, 0x94, 0x00, 0x00, 0x00, 0x02, 0x00, 0x32, 0x00,
                                  0x00, 0x00, 0x00, 0xe0, 0x39, 0x45, 0x00, 0x80, 0x09, 0x44, 0x00, 0xa0, 0xf1,
                                  0x44, 0x00, 0x00, 0x00, 0x00, 0xf7, 0xbd, 0x6f, 0x3d, 0x82, 0xbd, 0x61, 0xbf};
  bytes.resize(16 + 148);
  const std::uint32_t sum = std::accumulate(bytes.begin(), bytes.end(), std::uint32_t{0});
  for (const std::uint32_t byte : {0xffu, 0xffu, 8u, 0u, sum, sum >> 8, sum >> 16, sum >> 24})
    bytes.push_back(static_cast<std::uint8_t>(byte));
  return bytes;
}

TEST(Navdata, ADronesDatagramIsDecoded) {
  Navdata data;
  ASSERT_EQ(decode_navdata(captured(), data), NavdataError::none);
  EXPECT_EQ(data.sequence, 300711u);
  EXPECT_EQ(navdata_value(data, "state", "flying", 0), 0.0);
  EXPECT_EQ(navdata_value(data, "state", "com_watchdog", 0), 1.0);
  EXPECT_EQ(navdata_value(data, "demo", "control_state", 0), 2.0);
  EXPECT_EQ(navdata_value(data, "demo", "battery", 0), 50.0);
  EXPECT_NEAR(*navdata_value(data, "demo", "pitch", 0), 2.974, 1e-6);
  EXPECT_NEAR(*navdata_value(data, "demo", "roll", 0), 0.55, 1e-6);
  EXPECT_NEAR(*navdata_value(data, "demo", "yaw", 0), 1.933, 1e-6);
  EXPECT_NEAR(*navdata_value(data, "demo", "velocity", 1), -0.8818e-3, 1e-7);
  EXPECT_EQ(navdata_value(data, "demo", "velocity", 3), std::nullopt);
  EXPECT_EQ(navdata_value(data, "raw", "voltage", 0), std::nullopt) << "this datagram has none";
  EXPECT_TRUE(is_navdata_value("raw", "voltage", 0));
  EXPECT_FALSE(is_navdata_value("demo", "altidude", 0));
}

TEST(Navdata, EveryCutAndEveryChangedByteIsRefused) {
  const std::vector<std::uint8_t> whole = captured();
  Navdata data;
  for (std::size_t n = 0; n < whole.size(); ++n)
    EXPECT_NE(decode_navdata(std::span(whole).first(n), data), NavdataError::none) << n;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::vector<std::uint8_t> changed = whole;
    changed[i] = static_cast<std::uint8_t>(changed[i] + 1);
    EXPECT_NE(decode_navdata(changed, data), NavdataError::none) << i;
  }
}

TEST(Navdata, WhatIsWrittenIsReadAgain) {
  Navdata data{.state = 1, .sequence = 5, .has_demo = true, .control_state = 4, .battery_percent = 80, .yaw_deg = -90};
  data.altitude_m = 1.25f, data.vx_mps = 0.5f, data.has_raw = true, data.battery_v = 11.5f;
  std::array<std::uint8_t, 512> bytes{};
  const std::size_t n = encode_navdata(data, bytes);
  Navdata back;
  ASSERT_EQ(decode_navdata({bytes.data(), n}, back), NavdataError::none);
  EXPECT_EQ(back.sequence, 5u);
  EXPECT_FLOAT_EQ(back.altitude_m, 1.25f);
  EXPECT_FLOAT_EQ(back.vx_mps, 0.5f);
  EXPECT_FLOAT_EQ(back.yaw_deg, -90);
  EXPECT_FLOAT_EQ(back.battery_v, 11.5f);
  EXPECT_EQ(encode_navdata(data, std::span(bytes).first(n - 1)), 0u);
}

TEST(Navdata, WhatNoIntegerHoldsIsWrittenAsTheNearestOne) {
  std::array<std::uint8_t, 512> bytes{};
  for (const float altitude_m : {4e6f, -4e6f}) {
    const Navdata data{.has_demo = true, .altitude_m = altitude_m, .has_raw = true, .battery_v = 5e6f};
    Navdata back;
    ASSERT_EQ(decode_navdata({bytes.data(), encode_navdata(data, bytes)}, back), NavdataError::none);
    EXPECT_FLOAT_EQ(back.altitude_m, altitude_m > 0 ? 2147483.648f : -2147483.648f);
    EXPECT_FLOAT_EQ(back.battery_v, 4294967.295f);
  }
}

}  // namespace
}  // namespace sinew::wire::navdata_test
