// Plots, tilt errors, the plant's report, and the parts that a dataset without a camera leaves out.
#include <gmock/gmock.h>

#include <cmath>

#include "apps/robot/without_camera.hpp"
#include "apps/robot_file/world_report.hpp"
#include "apps/run/tilt_error.hpp"
#include "apps/view/graph_text.hpp"
#include "apps/view/plot.hpp"

namespace sinew::app::report_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

TEST(TiltError, IsTheAngleBetweenTheUpVectorsWhateverTheYaw) {
  const double half = 0.5 * 0.1;  // 0.1 rad about x
  const msg::Quat level{1, 0, 0, 0}, tilted{std::cos(half), std::sin(half), 0, 0}, turned{0.6, 0, 0, 0.8};
  EXPECT_NEAR(tilt_error_rad(level, tilted), 0.1, 1e-12);
  EXPECT_NEAR(tilt_error_rad(level, turned), 0, 1e-12) << "yaw cannot be seen";
}

TEST(TiltError, RmsAndMaximumCountFromSettlingOn) {
  const TiltErrors e = summarise({{0, 50}, {4.9, 40}, {5, 3}, {6, -4}}, 5);
  EXPECT_EQ(e.compared, 2u);
  EXPECT_NEAR(e.rms_deg, std::sqrt(12.5), 1e-12);
  EXPECT_EQ(e.max_deg, 3);
  EXPECT_EQ(e.over_time.size(), 4u);
}

TEST(Plot, MarksAreRoundAndInside) {
  EXPECT_THAT(axis_marks(0, 10, 5), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(axis_marks(-0.03, 0.03, 3), ElementsAre(-0.02, 0, 0.02));
}

TEST(Plot, PeakOfALongSeriesSurvivesThinning) {
  Plot plot{"t", "x", "y", {{"s", {}}}};
  for (int i = 0; i < 100'000; ++i) plot.series[0].points.emplace_back(i, i == 77'777 ? 9.0 : 0.0);
  const std::string svg = to_svg(plot);
  EXPECT_LT(svg.size(), 100'000u);
  EXPECT_THAT(svg, HasSubstr(" 63.1L")) << "the peak is drawn, near the upper edge";
}

TEST(Plot, NamesAreEscapedAndGapsLiftThePen) {
  const std::string svg = to_svg({"a<b & c", "x", "y", {{"s", {{0, 0}, {1, NAN}, {2, 1}}}}});
  EXPECT_THAT(svg, HasSubstr("a&lt;b &amp; c"));
  EXPECT_THAT(svg, testing::Not(HasSubstr("nan")));
}

TEST(WorldReport, FaultsOfThePlantAreNamed) {
  const auto report = parse_report(
      R"({"valid":true,"faults":[{"fault":"imu:off@1","device":"imu","kind":"off","from_s":1,"first_s":1.5,"affected":7}, 3, {"fault":1,"affected":-1}]})");
  ASSERT_TRUE(report);
  EXPECT_EQ(report->faults.at(0).text, "imu:off@1");
  EXPECT_EQ(report->faults.at(0).affected, 7u);
  EXPECT_EQ(report->faults.at(0).first_s, 1.5);
  EXPECT_TRUE(report->is_faulty("imu"));
  EXPECT_FALSE(report->is_faulty("range"));
}

TEST(WorldReport, HoldsTheVerdictOfTheWorldWithItsMeasures) {
  const auto report = parse_report(
      R"({"valid":true,"still":false,"height_m":1.5,"touched_down":true,"verdict":{"outcome":"landed hard","good":false,"measures":[
          {"key":"speed_mps","label":"speed","unit":"m/s","value":0.7,"at_most":0.5},
          {"key":"share","label":"share","unit":"","value":0.9,"at_least":0.8},
          {"key":"time_s","label":"time","unit":"s","value":12.5}, {"label":"without a key"}, 7]}})");
  ASSERT_TRUE(report && report->verdict);
  EXPECT_EQ(report->verdict->outcome, "landed hard");
  EXPECT_FALSE(report->verdict->good);
  EXPECT_TRUE(report->verdict->begun) << "unless the world says otherwise";
  EXPECT_FALSE(report->still);
  ASSERT_EQ(report->verdict->measures.size(), 3u);
  EXPECT_EQ(to_string(report->verdict->measures[0]), "0.700 m/s   (limit 0.5 m/s)");
  EXPECT_EQ(to_string(report->verdict->measures[1]), "0.900   (at least 0.8)");
  EXPECT_EQ(to_string(report->verdict->measures[2]), "12.500 s");
  EXPECT_EQ(in_words(report->verdict->measures[0]), "speed 0.7 m/s (at most 0.5)");
  EXPECT_EQ(in_words(report->verdict->measures[1]), "share 0.9 (at least 0.8)");
  EXPECT_EQ(in_words({.key = "t", .label = "time", .unit = "s", .value = 4321.4}), "time 4321 s");
  EXPECT_DOUBLE_EQ(over_limit(report->verdict->measures[0]), 1.4);
  EXPECT_LT(over_limit(report->verdict->measures[1]), 1);
  EXPECT_EQ(over_limit(report->verdict->measures[2]), 0);
  EXPECT_EQ(report->number("height_m"), 1.5);
  EXPECT_EQ(report->number("touched_down"), 1);
  EXPECT_EQ(report->number("nothing"), 0);
}

TEST(WorldReport, OfASimulatorThatSaysLittleIsWhatItSays) {
  const auto report = parse_report(R"({"valid":true,"verdict":5,"still":"yes","faults":{}})");
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->verdict);
  EXPECT_TRUE(report->still);
}

TEST(WorldReport, TextThatIsNoReportIsNone) {
  EXPECT_FALSE(parse_report(""));
  EXPECT_FALSE(parse_report("[1,2]"));
  EXPECT_FALSE(parse_report("{\"valid\":"));
}

TEST(DatasetRun, WithoutImagesCameraAndWhatNeedsItAreLeftOut) {
  rt::GraphSpec g;
  g.modules = {{.name = "cam", .type = "drivers::CameraSource"},
               {.name = "see", .type = "V", .in = {{"image", {"cam.raw"}}}},
               {.name = "think", .type = "T", .in = {{"seen", {"see.out"}}}},
               {.name = "imu", .type = "drivers::ImuSource"}};
  g.threads = {{.name = "a", .order = {{"cam"}, {"see"}}}, {.name = "b", .order = {{"imu"}, {"think"}}}};
  g.topics = {{.name = "cam.raw"}};
  EXPECT_THAT(leave_out_camera(g), ElementsAre("cam", "see", "think"));
  ASSERT_EQ(g.threads.size(), 1u);
  EXPECT_EQ(g.threads[0].order.size(), 1u);
  EXPECT_THAT(g.topics, IsEmpty());
}

TEST(GraphText, DurationsAreForPeople) {
  EXPECT_EQ(human(1ms), "1 ms");
  EXPECT_EQ(human(33'333us), "33.3 ms");
  EXPECT_EQ(human(5us), "5 us");
  EXPECT_EQ(human(-2s), "-2 s");
  EXPECT_EQ(human(999'499ns), "999 us");
  EXPECT_EQ(human(999'600ns), "1 ms") << "not 1e+03 us";
}

}  // namespace
}  // namespace sinew::app::report_test
