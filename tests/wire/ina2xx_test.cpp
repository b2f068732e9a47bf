#include "wire/ina2xx.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::wire::ina2xx::ina2xx_test {
namespace {

TEST(Ina2xx, SetUpIsTheRegisterMapsBits) {
  // SBOS448G, configuration register: 32 V, PGA / 8, BADC and SADC 1101, mode 111.
  EXPECT_EQ(facts(Chip::ina219).measuring, 1 << 13 | 3 << 11 | 0xD << 7 | 0xD << 3 | 7);
  // SBOS547A, configuration register: bit 14 is set, AVG 010, VBUSCT and VSHCT 100, mode 111.
  EXPECT_EQ(facts(Chip::ina226).measuring, 1 << 14 | 2 << 9 | 4 << 6 | 4 << 3 | 7);
  EXPECT_DOUBLE_EQ(facts(Chip::ina219).window_ms, 2 * 17.02);
  EXPECT_DOUBLE_EQ(facts(Chip::ina226).window_ms, 2 * 16 * 1.1);
}

TEST(Ina2xx, WordsBecomeVolts) {
  EXPECT_DOUBLE_EQ(bus_v(0x2570, Chip::ina226), 11.98) << "the worked example of SBOS547A: 9584 * 1.25 mV";
  EXPECT_DOUBLE_EQ(shunt_v(0x1F40, Chip::ina226), 0.02) << "the same: 8000 * 2.5 uV";
  EXPECT_DOUBLE_EQ(bus_v(0x5D98, Chip::ina219), 11.98) << "the worked example of SBOS448G: 2995 * 4 mV";
  EXPECT_DOUBLE_EQ(shunt_v(0x07D0, Chip::ina219), 0.02) << "the same: 2000 * 10 uV";
  EXPECT_DOUBLE_EQ(bus_v(0x5D98 | 0x0003, Chip::ina219), 11.98) << "flags are no voltage";
  EXPECT_DOUBLE_EQ(shunt_v(0xF830, Chip::ina219), -0.02) << "into the battery";
  EXPECT_DOUBLE_EQ(shunt_v(0xFFFF, Chip::ina226), -2.5e-6);
}

TEST(Ina2xx, AFullShuntIsNoCurrent) {
  for (const std::uint16_t full : {std::uint16_t{0x7FFF}, std::uint16_t{0x8000}})
    EXPECT_TRUE(std::isnan(shunt_v(full, Chip::ina226)));
  for (const std::uint16_t full : {std::uint16_t{0x7D00}, std::uint16_t{0x8300}, std::uint16_t{0x7FFF}})
    EXPECT_TRUE(std::isnan(shunt_v(full, Chip::ina219)));
  EXPECT_FALSE(std::isnan(shunt_v(0x7CFF, Chip::ina219)));
  EXPECT_FALSE(std::isnan(shunt_v(0x7FFE, Chip::ina226)));
}

TEST(Ina2xx, IsKnownByItsDieWhateverItsRevision) {
  EXPECT_TRUE(is_ina226(0x2260));
  EXPECT_TRUE(is_ina226(0x2261));
  EXPECT_FALSE(is_ina226(0x2270));
  EXPECT_FALSE(is_ina226(0xFFFF));
}

}  // namespace
}  // namespace sinew::wire::ina2xx::ina2xx_test
