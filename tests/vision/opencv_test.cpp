// The bridge to OpenCV and the module that shows it.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "msg/image_buffer.hpp"
#include "rt/exec/module_rig.hpp"
#include "vision/opencv/contour_finder.hpp"
#include "vision/opencv/mat_view.hpp"

namespace sinew::vision::opencv_test {
namespace {

using msg::ImageBuffer;
using msg::PixelFormat;
using msg::Time;
using namespace std::chrono_literals;

TEST(MatView, SeesEveryFormatWithoutACopy) {
  for (const auto& [format, channels] :
       {std::pair{PixelFormat::mono8, 1}, {PixelFormat::yuyv, 2}, {PixelFormat::rgb8, 3}, {PixelFormat::bgr8, 3}}) {
    ImageBuffer image(format, 32, 20);
    const cv::Mat mat = mat_view(*image);
    EXPECT_EQ(mat.data, image->pixels());
    EXPECT_EQ(mat.rows, 20);
    EXPECT_EQ(mat.cols, 32);
    EXPECT_EQ(mat.channels(), channels);
    EXPECT_EQ(mat.step[0], image->stride);
    const ReadOnlyMat read(*image);
    EXPECT_EQ(read->data, image->pixels());
  }
}

TEST(MatView, WritesOfOpenCvLandInTheImage) {
  ImageBuffer colour(PixelFormat::bgr8, 40, 30), grey(PixelFormat::mono8, 40, 30);
  mat_view(*colour).setTo(cv::Scalar(10, 200, 30));
  cv::Mat out = mat_view(*grey);
  cv::cvtColor(*ReadOnlyMat(*colour), out, cv::COLOR_BGR2GRAY);
  EXPECT_EQ(out.data, grey->pixels());
  EXPECT_EQ(grey->pixels()[0], 128);  // 0.114 * 10 + 0.587 * 200 + 0.299 * 30
  EXPECT_EQ(grey->row(29)[39], 128);
}

TEST(MatView, AHeaderThatLiesGivesAnEmptyMat) {
  ImageBuffer image(PixelFormat::mono8, 32, 20);
  image->height = 21;
  EXPECT_TRUE(mat_view(*image).empty());
  EXPECT_TRUE(ReadOnlyMat(*image).empty());
}

TEST(MatView, AnExceptionOfOpenCvIsAFault) {
  const auto status = without_exceptions([] {
    cv::Mat empty, out;
    cv::cvtColor(empty, out, cv::COLOR_BGR2GRAY);  // throws
    return rt::StepStatus::ok;
  });
  EXPECT_EQ(status, rt::StepStatus::fault);
}

/// Dark, with a bright disc and a smaller bright square.
ImageBuffer scene(PixelFormat format, double u, double v, double radius) {
  ImageBuffer image(format, 320, 240);
  for (std::uint32_t y = 0; y < 240; ++y)
    for (std::uint32_t x = 0; x < 320; ++x) {
      const bool disc = (x - u) * (x - u) + (y - v) * (y - v) < radius * radius;
      const bool square = x >= 280 && x < 296 && y >= 200 && y < 216;
      const std::uint32_t n = bytes_per_pixel(format);
      std::uint8_t* p = image->row(y) + x * n;
      p[0] = disc || square ? 220 : 30;
      if (format == PixelFormat::yuyv) p[1] = 128;
      if (n == 3) p[1] = p[2] = p[0];
    }
  return image;
}

TEST(ContourFinder, FindsTheLargestRegionAndWritesTheSmallImageIntoItsSlot) {
  for (const auto format : {PixelFormat::mono8, PixelFormat::yuyv, PixelFormat::rgb8, PixelFormat::bgr8}) {
    ContourFinder finder;
    rt::ModuleRig rig(finder, {.image_bytes = 320 * 240 * 3});
    ImageBuffer image = scene(format, 120, 90, 40);
    image->stamp = Time{7'000'000};
    rig.put_image("image", image);
    ASSERT_EQ(rig.step(Time{8'000'000}, 33ms), rt::StepStatus::ok);
    const auto* report = rig.get<ContourReport>("report");
    ASSERT_NE(report, nullptr);
    EXPECT_EQ(report->contours, 2u);
    EXPECT_EQ(report->stamp, Time{7'000'000});
    EXPECT_NEAR(report->largest_u_px, 120, 1.5);
    EXPECT_NEAR(report->largest_v_px, 90, 1.5);
    EXPECT_NEAR(report->largest_area_px, 3.14159 * 1600, 400);
    const auto* small = rig.get<msg::Image>("small");
    ASSERT_NE(small, nullptr);
    EXPECT_EQ(small->format, PixelFormat::mono8);
    EXPECT_EQ(small->width, 160u);
    EXPECT_EQ(small->height, 120u);
    EXPECT_NEAR(small->row(45)[60], 220, 2);
    EXPECT_NEAR(small->row(5)[5], 30, 2);
  }
}

TEST(ContourFinder, TakesTheDistortionOfTheLensOut) {
  // A point at x = 0.5, y = 0 (optical) appears at radius 0.5 (1 - 0.2 * 0.25) = 0.475.
  constexpr double kF = 200, kC = 159.5;
  ContourFinder finder;
  rt::ModuleRig rig(finder, {.image_bytes = 320 * 240});
  rig.set("fx_px", kF), rig.set("fy_px", kF), rig.set("cx_px", kC), rig.set("cy_px", 119.5), rig.set("k1", -0.2);
  rig.put_image("image", scene(PixelFormat::mono8, kC + kF * 0.475, 119.5, 20));
  ASSERT_EQ(rig.step(Time{1'000'000}, 33ms), rt::StepStatus::ok);
  EXPECT_NEAR(rig.get<ContourReport>("report")->largest_u_px, kC + kF * 0.5, 2);
}

TEST(ContourFinder, PublishesNothingWhenItCannotWork) {
  ContourFinder finder;
  rt::ModuleRig rig(finder, {.image_bytes = 320 * 240});
  rig.image_capacity("small", 100);
  EXPECT_EQ(rig.step(Time{1'000'000}, 33ms), rt::StepStatus::stale);  // no image yet
  rig.put_image("image", scene(PixelFormat::mono8, 100, 100, 20));
  EXPECT_EQ(rig.step(Time{2'000'000}, 33ms), rt::StepStatus::fault);  // the small image does not fit
  EXPECT_EQ(rig.get<ContourReport>("report"), nullptr);
  EXPECT_EQ(rig.get<msg::Image>("small"), nullptr);
  EXPECT_EQ(rig.step(Time{3'000'000}, 33ms), rt::StepStatus::stale);  // the same image again
}

TEST(ContourFinder, IsDeclaredBestEffort) {
  ContourFinder finder;
  rt::Declaration d;
  finder.declare(d);
  EXPECT_TRUE(d.is_best_effort);
}

}  // namespace
}  // namespace sinew::vision::opencv_test
