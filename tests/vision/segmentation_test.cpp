#include "vision/segmentation.hpp"

#include <gtest/gtest.h>

#include <deque>

#include "images.hpp"

namespace sinew::vision::segmentation_test {
namespace {

using msg::PixelFormat;
using test::Pixels;

constexpr ColourBox kBright{{128, 0, 0}, {255, 255, 255}};

/// A yuyv picture from text: '#' is bright, '.' dark.
Pixels picture(const std::vector<std::string>& rows) {
  Pixels p(PixelFormat::yuyv, static_cast<std::uint32_t>(rows[0].size()), static_cast<std::uint32_t>(rows.size()), 6);
  for (std::uint32_t y = 0; y < rows.size(); ++y)
    for (std::uint32_t x = 0; x < rows[0].size(); ++x) {
      p.row(y)[2 * x] = rows[y][x] == '#' ? 200 : 16;
      p.row(y)[2 * x + 1] = 128;
    }
  return p;
}

struct Region {
  std::uint32_t area = 0, x0 = 99999, y0 = 99999, x1 = 0, y1 = 0;
  std::int64_t sum_x = 0, sum_y = 0;
  auto operator<=>(const Region&) const = default;
};

Region region_of(const Blob& b) { return {b.area_px, b.x0, b.y0, b.x1, b.y1, b.sum_x, b.sum_y}; }

/// The definition, by flood fill: connected sets of equal colour, 8 neighbours.
std::vector<Region> flood(const std::vector<std::uint8_t>& colour, std::uint32_t width, std::uint32_t height,
                          std::uint8_t wanted) {
  std::vector<Region> out;
  std::vector<bool> seen(colour.size());
  for (std::uint32_t start = 0; start < colour.size(); ++start) {
    if (seen[start] || colour[start] != wanted) continue;
    Region r;
    std::deque<std::uint32_t> open{start};
    seen[start] = true;
    while (!open.empty()) {
      const std::uint32_t i = open.front(), x = i % width, y = i / width;
      open.pop_front();
      ++r.area, r.sum_x += x, r.sum_y += y;
      r.x0 = std::min(r.x0, x), r.x1 = std::max(r.x1, x), r.y0 = std::min(r.y0, y), r.y1 = std::max(r.y1, y);
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const std::int64_t nx = std::int64_t{x} + dx, ny = std::int64_t{y} + dy;
          if (nx < 0 || ny < 0 || nx >= width || ny >= height) continue;
          const auto n = static_cast<std::uint32_t>(ny * width + nx);
          if (seen[n] || colour[n] != wanted) continue;
          seen[n] = true;
          open.push_back(n);
        }
    }
    out.push_back(r);
  }
  return out;
}

std::vector<Region> regions(const Segmentation& s, std::uint32_t colour) {
  std::vector<Region> out;
  for (const Blob& b : s.blobs())
    if (b.colour == colour) out.push_back(region_of(b));
  return out;
}

std::vector<Simd> kinds() {
  std::vector<Simd> k{Simd::scalar};
  if (best_simd() != Simd::scalar) k.push_back(best_simd());
  return k;
}

TEST(Segmentation, CornersConnectAndGapsDoNot) {
  const Pixels p = picture({"#.......#.", ".#.....#..", "..#...#...", "..........", "##........"});
  Segmentation s;
  for (const Simd simd : kinds()) {
    ASSERT_TRUE(s.by_boxes(p.view(), std::array{kBright}, simd));
    ASSERT_EQ(s.blobs().size(), 3u);
    EXPECT_EQ(region_of(s.blobs()[0]), (Region{3, 0, 0, 2, 2, 3, 3}));
    EXPECT_EQ(region_of(s.blobs()[1]), (Region{3, 6, 0, 8, 2, 21, 3}));
    EXPECT_EQ(region_of(s.blobs()[2]), (Region{2, 0, 4, 1, 4, 1, 8}));
    EXPECT_EQ(s.blobs()[0].centre_x(), 1.0);
  }
}

TEST(Segmentation, ArmsOfAUAreOneRegion) {
  const Pixels p = picture({"##....##..", "##....##..", "##....##..", "########..", "..........", "....#....."});
  Segmentation s;
  ASSERT_TRUE(s.by_boxes(p.view(), std::array{kBright}));
  ASSERT_EQ(s.blobs().size(), 2u);
  EXPECT_EQ(s.blobs()[0].area_px, 20u);
  for (const auto& r : s.runs(1)) EXPECT_EQ(r.label, r.y < 4 ? 0u : 1u);
}

TEST(Segmentation, RunsReachTheRightBorderAndDoNotWrap) {
  const Pixels p = picture({std::string(70, '.').replace(40, 30, 30, '#'), "#" + std::string(69, '.')});
  Segmentation s;
  for (const Simd simd : kinds()) {
    ASSERT_TRUE(s.by_boxes(p.view(), std::array{kBright}, simd));
    ASSERT_EQ(s.blobs().size(), 2u);
    EXPECT_EQ(region_of(s.blobs()[0]), (Region{30, 40, 0, 69, 0, 40 * 30 + 435, 0}));
    EXPECT_EQ(s.blobs()[1].area_px, 1u);
  }
}

TEST(Segmentation, TableFindsWhatAFloodFillFinds) {
  ColourTable table;
  table.add(ColourBox{{0, 0, 0}, {95, 255, 255}});
  table.add(ColourBox{{160, 0, 0}, {255, 255, 255}});
  math::Random random(7);
  Segmentation s({.max_blobs = 20000});
  for (const std::uint32_t width : {2u, 30u, 32u, 34u, 64u, 98u, 160u}) {
    Pixels p(PixelFormat::yuyv, width, 41);
    std::vector<std::uint8_t> colour(width * 41);
    for (std::uint32_t y = 0; y < 41; ++y)
      for (std::uint32_t x = 0; x < width; ++x) {
        const std::uint32_t c = random.below(5);  // two in five of each colour
        colour[y * width + x] = static_cast<std::uint8_t>(c < 2 ? 1 : c < 4 ? 2 : 0);
        p.row(y)[2 * x] = static_cast<std::uint8_t>(c < 2 ? 50 : c < 4 ? 200 : 128);
        p.row(y)[2 * x + 1] = static_cast<std::uint8_t>(random.below(256));
      }
    ASSERT_TRUE(s.by_table(p.view(), table));
    for (std::uint8_t c = 1; c <= 2; ++c) EXPECT_EQ(regions(s, c), flood(colour, width, 41, c)) << width;
  }
}

TEST(Segmentation, RgbAndBgrGiveTheSameBlobs) {
  ColourTable table;
  table.add(HueSector{.hue_from_deg = 345, .hue_to_deg = 45, .saturation_min = 0.5, .value_min = 0.25});
  Pixels rgb(PixelFormat::rgb8, 61, 33, 5), bgr(PixelFormat::bgr8, 61, 33);
  for (std::uint32_t y = 0; y < 33; ++y)
    for (std::uint32_t x = 0; x < 61; ++x) {
      const bool in = (x - 30) * (x - 30) + (y - 16) * (y - 16) < 100;
      const std::uint8_t c[3] = {std::uint8_t(in ? 230 : 90), std::uint8_t(in ? 80 : 95), std::uint8_t(in ? 20 : 99)};
      for (int k = 0; k < 3; ++k) rgb.row(y)[3 * x + k] = c[k], bgr.row(y)[3 * x + k] = c[2 - k];
    }
  Segmentation s;
  ASSERT_TRUE(s.by_table(rgb.view(), table));
  ASSERT_EQ(s.blobs().size(), 1u);
  const Region first = region_of(s.blobs()[0]);
  ASSERT_TRUE(s.by_table(bgr.view(), table));
  EXPECT_EQ(regions(s, 1), std::vector{first});
  EXPECT_NEAR(s.blobs()[0].centre_x(), 30, 0.01);
}

TEST(Segmentation, SimdGivesExactlyTheRunsOfTheScalarKernel) {
  if (best_simd() == Simd::scalar) GTEST_SKIP() << "this processor has no SIMD kernel";
  math::Random random(11);
  Segmentation a({.max_runs = 3000, .max_blobs = 4000}), b({.max_runs = 3000, .max_blobs = 4000});
  for (int round = 0; round < 60; ++round) {
    const std::uint32_t width = 2 * (1 + random.below(100)), height = 1 + random.below(60);
    Pixels p(PixelFormat::yuyv, width, height, 2 * random.below(4));
    test::fill_noise(p.bytes().data(), p.bytes().size(), 100 + static_cast<std::uint64_t>(round));
    std::vector<ColourBox> boxes(random.below(kMaxColours + 1));
    for (ColourBox& box : boxes)
      for (int k = 0; k < 3; ++k) {  // also empty ones (lo > hi), and whole ranges
        box.lo[k] = static_cast<std::uint8_t>(random.below(3) ? random.below(128) : 0);
        box.hi[k] = static_cast<std::uint8_t>(random.below(3) ? random.below(256) : 255);
      }
    ASSERT_TRUE(a.by_boxes(p.view(), boxes, Simd::scalar));
    ASSERT_TRUE(b.by_boxes(p.view(), boxes, best_simd()));
    ASSERT_EQ(a.blobs().size(), b.blobs().size());
    for (std::uint32_t c = 1; c <= boxes.size(); ++c) {
      ASSERT_EQ(regions(a, c), regions(b, c)) << "width " << width;
      ASSERT_EQ(a.dropped_runs(c), b.dropped_runs(c));
      ASSERT_EQ(a.runs(c).size(), b.runs(c).size());
      for (std::size_t i = 0; i < a.runs(c).size(); ++i) {
        const auto &p1 = a.runs(c)[i], &p2 = b.runs(c)[i];
        ASSERT_TRUE(p1.y == p2.y && p1.x0 == p2.x0 && p1.x1 == p2.x1 && p1.label == p2.label);
      }
    }
  }
}

// Every second pixel of every row: the largest number of runs there can be.
TEST(Segmentation, WorstCaseImageDropsAndCountsRunsAndKeepsTheUpperPart) {
  Pixels p(PixelFormat::yuyv, 640, 480);
  for (std::uint32_t y = 0; y < 480; ++y)
    for (std::uint32_t x = 0; x < 640; ++x) p.row(y)[2 * x] = (x + 2 * (y & 1)) % 4 == 0 ? 255 : 0;
  Segmentation s({.max_runs = 1600, .max_blobs = 100, .min_area_px = 1});
  for (const Simd simd : kinds()) {
    ASSERT_TRUE(s.by_boxes(p.view(), std::array{kBright}, simd));
    EXPECT_EQ(s.runs(1).size(), 1600u);
    EXPECT_EQ(s.dropped_runs(), 160u * 480 - 1600);
    EXPECT_EQ(s.blobs().size(), 100u);
    EXPECT_EQ(s.dropped_blobs(), 1500u);
  }
  ColourTable table;
  table.add(kBright);
  ASSERT_TRUE(s.by_table(p.view(), table));
  EXPECT_EQ(s.dropped_runs(), 160u * 480 - 1600);
}

TEST(Segmentation, SmallRegionsAreLeftOut) {
  const Pixels p = picture({"##..#..###", "##.....###"});
  Segmentation s({.min_area_px = 4});
  ASSERT_TRUE(s.by_boxes(p.view(), std::array{kBright}));
  ASSERT_EQ(s.blobs().size(), 2u);
  EXPECT_EQ(s.blobs()[1].area_px, 6u);
  EXPECT_EQ(s.blobs()[1].region, 2u);  // its runs' label, although a region before it was left out
  EXPECT_EQ(s.dropped_blobs(), 0u);
}

TEST(Segmentation, OtherFormatsAreRefusedAndLeaveNoBlobs) {
  Segmentation s;
  ColourTable table;
  table.add(kBright);
  ASSERT_TRUE(s.by_boxes(picture({"####"}).view(), std::array{kBright}));
  ASSERT_EQ(s.blobs().size(), 1u);
  EXPECT_FALSE(s.by_boxes(Pixels(PixelFormat::rgb8, 4, 4).view(), std::array{kBright}));
  EXPECT_EQ(s.blobs().size(), 0u);
  EXPECT_FALSE(s.by_table(Pixels(PixelFormat::mono8, 4, 4).view(), table));
  EXPECT_FALSE(s.by_table(ImageView{}, table));
  EXPECT_EQ(s.blobs().size(), 0u);
}

TEST(ImageView, HostileHeadersGiveNoView) {
  test::Message m(PixelFormat::yuyv, 64, 48);
  EXPECT_TRUE(view(*m));
  const auto refused = [&](auto change) {
    test::Message bad(PixelFormat::yuyv, 64, 48);
    change(*bad);
    return !view(*bad);
  };
  EXPECT_TRUE(refused([](msg::Image& i) { i.height = 49; }));
  EXPECT_TRUE(refused([](msg::Image& i) { i.height = 0; }));
  EXPECT_TRUE(refused([](msg::Image& i) { i.height = 0xFFFFFFFF; }));
  EXPECT_TRUE(refused([](msg::Image& i) { i.width = 66; }));
  EXPECT_TRUE(refused([](msg::Image& i) { i.width = 63; }));  // half a pixel pair
  EXPECT_TRUE(refused([](msg::Image& i) { i.width = 0; }));
  EXPECT_TRUE(refused([](msg::Image& i) { i.stride = 127; }));
  EXPECT_TRUE(refused([](msg::Image& i) { i.stride = 0xFFFFFFF0; }));
  EXPECT_TRUE(refused([](msg::Image& i) { i.format = PixelFormat::rgb8; }));
  EXPECT_TRUE(refused([](msg::Image& i) { i.format = PixelFormat{77}; }));
}

}  // namespace
}  // namespace sinew::vision::segmentation_test
