// Plots: what is drawn, and that texts do not lie over each other.
#include "apps/view/plot.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <regex>

#include "apps/view/canvas.hpp"
#include "dataset/png_image.hpp"

namespace sinew::app::plot_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Plot line(std::vector<std::pair<double, double>> points) {
  Plot plot;
  plot.series.push_back({"height", std::move(points)});
  return plot;
}

struct Shown {
  double x, y, size;
  std::string text;
};

/// The texts that begin where they say.
std::vector<Shown> texts_of(const std::string& svg) {
  static const std::regex kText(
      R"re(<text x="([\d.-]+)" y="([\d.-]+)" font-size="([\d.]+)"[^>]*"start"[^>]*>([^<]*)<)re");
  std::vector<Shown> all;
  for (auto at = std::sregex_iterator(svg.begin(), svg.end(), kText); at != std::sregex_iterator(); ++at)
    all.push_back({std::stod((*at)[1]), std::stod((*at)[2]), std::stod((*at)[3]), (*at)[4]});
  return all;
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(Plots, MarksAndNamesNeverLieOverEachOther) {
  Plot plot = line({{0, 0}, {10, 1}});
  for (int i = 0; i < 6; ++i) plot.series.push_back({"a_rather_long_topic.with_a_field_of_it_" + std::to_string(i)});
  for (int i = 0; i < 40; ++i) plot.marks.push_back({0.25 * i, "something " + std::to_string(i)});
  const auto texts = texts_of(to_svg(plot));
  ASSERT_THAT(texts, SizeIs(::testing::Gt(20u)));
  for (std::size_t i = 0; i < texts.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const Shown &a = texts[k], &b = texts[i];
      if (std::abs(a.y - b.y) >= std::max(a.size, b.size)) continue;
      const bool apart = a.x + text_width_px(a.text, a.size) <= b.x || b.x + text_width_px(b.text, b.size) <= a.x;
      EXPECT_TRUE(apart) << a.text << " and " << b.text;
    }
}

TEST(Plots, EveryMarkHasItsLineAlsoWithoutRoomForItsText) {
  Plot plot = line({{0, 0}, {10, 1}});
  for (int i = 0; i < 30; ++i) plot.marks.push_back({5, "at once"});
  const std::string svg = to_svg(plot);
  EXPECT_EQ(count_of(svg, "stroke-dasharray"), 30u);
  EXPECT_EQ(count_of(svg, "at once"), 4u);
}

TEST(Plots, AGapIsNotBridged) {
  EXPECT_EQ(count_of(to_svg(line({{0, 1}, {1, 2}, {2, 1}, {3, 2}})), "stroke-width=\"1.4\""), 1u);
  EXPECT_EQ(count_of(to_svg(line({{0, 1}, {1, 2}, {2, kNaN}, {3, 2}, {4, 2}})), "stroke-width=\"1.4\""), 2u);
}

TEST(Plots, OfManyPointsThePeakStays) {
  Plot plot = line({});
  for (int i = 0; i < 100000; ++i) plot.series[0].points.emplace_back(i, i == 54321 ? 7.0 : 0.0);
  const std::string svg = to_svg(plot);
  EXPECT_LT(svg.size(), 60000u);
  const std::regex point(R"re(L[\d.]+ ([\d.]+))re");
  double highest = 1000;
  for (auto at =
           std::sregex_iterator(svg.begin() + static_cast<std::ptrdiff_t>(svg.find("M76.0 340")), svg.end(), point);
       at != std::sregex_iterator(); ++at)
    if (const std::string y = (*at)[1]; y != "30.0") highest = std::min(highest, std::stod(y));  // the frame
  EXPECT_LT(highest, 50);
}

TEST(Plots, ASteppedSeriesKeepsItsValueUntilTheNext) {
  Plot plot = line({{0, 0}, {1, 1}});
  plot.series[0].stepped = true;
  const std::regex path(
      R"re(<path d="M([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)"[^>]*stroke-width="1.4")re");
  std::smatch corner;
  const std::string svg = to_svg(plot);
  ASSERT_TRUE(std::regex_search(svg, corner, path)) << svg;
  EXPECT_EQ(corner[2], corner[4]) << "first to the right,";
  EXPECT_EQ(corner[3], corner[5]) << "then up";
}

TEST(Plots, ValuesWithNamesShowThem) {
  Plot plot = line({{0, 0}, {1, 2}});
  plot.y_names = {{0, "standby"}, {1, "armed"}, {9, "beyond"}};
  const std::string svg = to_svg(plot);
  EXPECT_THAT(svg, HasSubstr(">standby<"));
  EXPECT_THAT(svg, HasSubstr(">armed<"));
  EXPECT_THAT(svg, Not(HasSubstr("beyond")));
}

TEST(Plots, TextIsNoMarkup) {
  Plot plot = line({{0, 0}});
  plot.title = "<a & b>\x01";
  EXPECT_THAT(to_svg(plot), HasSubstr("&lt;a &amp; b&gt;<"));
}

TEST(Plots, APngHasWhatTheSvgHas) {
  Plot plot = line({{0, 0}, {1, 1}});
  plot.title = "height";
  std::string why;
  const std::string png = to_png(std::span(&plot, 1), why);
  dataset::DecodedImage image;
  image.width = 0;
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(png.data());
  // Larger than a camera's picture, so it is read by its header only.
  EXPECT_FALSE(dataset::decode_png({bytes, png.size()}, image, why));
  EXPECT_THAT(why, HasSubstr("1800 x "));
  EXPECT_GT(png.size(), 4000u) << "it is not empty";
}

}  // namespace
}  // namespace sinew::app::plot_test
