#include "vision/colour_table.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::vision::colour_table_test {
namespace {

TEST(ColourTable, ConversionThereAndBackStaysWithinTwoGreyLevels) {
  for (int r = 0; r < 256; r += 15)
    for (int g = 0; g < 256; g += 15)
      for (int b = 0; b < 256; b += 15) {
        const Rgb back = to_rgb(to_yuv({r, g, b}));
        EXPECT_NEAR(back.r, r, 2);
        EXPECT_NEAR(back.g, g, 2);
        EXPECT_NEAR(back.b, b, 2);
      }
}

TEST(ColourTable, BoxPaintsTheCellsWhoseCentresItHolds) {
  ColourTable table;
  ASSERT_EQ(table.add(ColourBox{{64, 32, 128}, {127, 63, 191}}), 1u);
  EXPECT_EQ(table.yuv()[ColourTable::yuv_index(64, 32, 128)], 1);
  EXPECT_EQ(table.yuv()[ColourTable::yuv_index(127, 63, 191)], 1);
  EXPECT_EQ(table.yuv()[ColourTable::yuv_index(63, 40, 150)], 0);
  EXPECT_EQ(table.yuv()[ColourTable::yuv_index(128, 40, 150)], 0);
  EXPECT_EQ(table.yuv()[ColourTable::yuv_index(100, 31, 150)], 0);
  EXPECT_EQ(table.yuv()[ColourTable::yuv_index(100, 40, 192)], 0);
}

TEST(ColourTable, HueSectorThroughRedTakesOrangeAndLeavesItsNeighbours) {
  ColourTable table;
  table.add(HueSector{.hue_from_deg = 350, .hue_to_deg = 40, .saturation_min = 0.5, .value_min = 0.2});
  const auto at = [&](unsigned r, unsigned g, unsigned b) { return table.rgb()[ColourTable::rgb_index(r, g, b)]; };
  EXPECT_EQ(at(230, 77, 26), 1);    // orange
  EXPECT_EQ(at(90, 30, 10), 1);     // the same in the shade
  EXPECT_EQ(at(220, 10, 20), 1);    // red
  EXPECT_EQ(at(220, 215, 30), 0);   // yellow
  EXPECT_EQ(at(120, 60, 140), 0);   // violet
  EXPECT_EQ(at(150, 130, 120), 0);  // hardly a colour
  EXPECT_EQ(at(20, 4, 1), 0);       // too dark
}

TEST(ColourTable, RgbAndYuvTablesAgreeOnTheSameColour) {
  ColourTable table;
  table.add(HueSector{.hue_from_deg = 0, .hue_to_deg = 40, .saturation_min = 0.55, .value_min = 0.3});
  int same = 0, all = 0;
  for (int r = 4; r < 256; r += 8)
    for (int g = 4; g < 256; g += 8)
      for (int b = 4; b < 256; b += 8) {
        const Yuv c = to_yuv({r, g, b});
        const int by_rgb = table.rgb()[ColourTable::rgb_index(unsigned(r), unsigned(g), unsigned(b))];
        const int by_yuv = table.yuv()[ColourTable::yuv_index(unsigned(c.y), unsigned(c.u), unsigned(c.v))];
        ++all;
        same += by_rgb == by_yuv;
      }
  EXPECT_GT(same, all * 97 / 100) << same << " of " << all;  // they differ only at the borders of cells
}

TEST(ColourTable, TheFirstColourThatFitsWinsAndTheNinthIsRefused) {
  ColourTable table;
  EXPECT_EQ(table.add(ColourBox{{0, 0, 0}, {255, 255, 255}}), 1u);
  EXPECT_EQ(table.add(ColourBox{{0, 0, 0}, {255, 255, 255}}), 2u);
  EXPECT_EQ(table.yuv()[ColourTable::yuv_index(100, 100, 100)], 1);
  for (std::uint32_t c = 3; c <= kMaxColours; ++c) EXPECT_EQ(table.add(ColourBox{}), c);
  EXPECT_EQ(table.add(ColourBox{}), 0u);
  table.clear();
  EXPECT_EQ(table.colours(), 0u);
  EXPECT_EQ(table.yuv()[ColourTable::yuv_index(100, 100, 100)], 0);
}

}  // namespace
}  // namespace sinew::vision::colour_table_test
