// The modules of vision/ on the rig: ports, parameters, statuses; their arithmetic is tested elsewhere.
#include <gtest/gtest.h>

#include "msg/image_buffer.hpp"
#include "pad_scene.hpp"
#include "rt/exec/module_rig.hpp"
#include "vision/motion_field.hpp"
#include "vision/pad_detector.hpp"

namespace sinew::vision::modules_test {
namespace {

using msg::ImageBuffer;
using msg::PixelFormat;
using msg::Time;
using namespace std::chrono_literals;

ImageBuffer pad_image(const test::CameraPose& pose, Time stamp) {
  ImageBuffer image(PixelFormat::yuyv, 320, 240);
  test::PadScene(pose, 320, 240).render(image->pixels(), 320, 240);
  image->stamp = stamp;
  return image;
}

TEST(PadDetector, SaysWhereThePadIs) {
  PadDetector detector;
  rt::ModuleRig rig(detector);
  const test::CameraPose pose{.height_m = 1.5, .right_m = -0.3, .down_m = 0.2};
  rig.put_image("image", pad_image(pose, Time{5'000'000}));
  ASSERT_EQ(rig.step(Time{9'000'000}, 33ms), rt::StepStatus::ok);
  const auto* s = rig.get<msg::PadSighting>("sighting");
  ASSERT_NE(s, nullptr);
  const test::PadScene scene(pose, 320, 240);
  EXPECT_EQ(s->found, 1u);
  EXPECT_EQ(s->stamp, Time{5'000'000});
  EXPECT_NEAR(s->direction_optical.x, scene.true_direction().x, 0.005);
  EXPECT_NEAR(s->direction_optical.y, scene.true_direction().y, 0.005);
  EXPECT_NEAR(s->direction_optical.z, scene.true_direction().z, 0.005);
  EXPECT_NEAR(s->range_m, scene.true_range_m(), 0.05);
  EXPECT_NEAR(s->radius_px, 210 * 0.3 / 1.5, 1);
  EXPECT_GT(s->confidence, 0.8);
}

TEST(PadDetector, AnImageWithoutAPadIsASightingOfNothing) {
  PadDetector detector;
  rt::ModuleRig rig(detector);
  rig.put_image("image", pad_image({.height_m = 1, .right_m = 4}, Time{1}));
  ASSERT_EQ(rig.step(Time{2}, 33ms), rt::StepStatus::ok);
  const auto* s = rig.get<msg::PadSighting>("sighting");
  ASSERT_NE(s, nullptr);
  EXPECT_EQ(s->found, 0u);
  EXPECT_EQ(s->confidence, 0);
  EXPECT_TRUE(math::is_nan(s->range_m));
}

TEST(PadDetector, OldAndUselessImagesGiveNoMessage) {
  PadDetector detector;
  rt::ModuleRig rig(detector);
  EXPECT_EQ(rig.step(Time{1}, 33ms), rt::StepStatus::stale);
  const ImageBuffer image = pad_image({}, Time{1});
  rig.put_image("image", image);
  EXPECT_EQ(rig.step(Time{2}, 33ms), rt::StepStatus::ok);
  EXPECT_EQ(rig.step(Time{3}, 33ms), rt::StepStatus::stale);  // the same image
  EXPECT_EQ(rig.get<msg::PadSighting>("sighting"), nullptr);
  rig.put_image("image", ImageBuffer(PixelFormat::mono8, 64, 48));
  EXPECT_EQ(rig.step(Time{4}, 33ms), rt::StepStatus::fault);
  ImageBuffer liar(PixelFormat::yuyv, 64, 48);
  liar->stride = 1;
  rig.put_image("image", liar);
  EXPECT_EQ(rig.step(Time{5}, 33ms), rt::StepStatus::fault);
}

TEST(PadDetector, TheFocalLengthMayBeGivenInsteadOfTheFieldOfView) {
  PadDetector detector;
  rt::ModuleRig rig(detector);
  rig.set("fx_px", 420.0), rig.set("fy_px", 420.0), rig.set("cx_px", 100.0), rig.set("cy_px", 119.5);
  rig.put_image("image", pad_image({.height_m = 1}, Time{1}));
  ASSERT_EQ(rig.step(Time{2}, 33ms), rt::StepStatus::ok);
  const auto* s = rig.get<msg::PadSighting>("sighting");
  EXPECT_NEAR(s->direction_optical.x / s->direction_optical.z, 59.5 / 420, 0.005);
  EXPECT_GT(s->range_m, 1.9);  // twice the focal length of the scene
}

/// A texture of squares, shifted.
ImageBuffer squares(int shift, Time stamp, PixelFormat format = PixelFormat::yuyv, std::uint32_t width = 320) {
  ImageBuffer image(format, width, 240);
  const std::uint32_t n = bytes_per_pixel(format);
  for (std::uint32_t y = 0; y < 240; ++y)
    for (std::uint32_t x = 0; x < width; ++x) {
      // Triangles of period 24 along x, 20 along y: smooth enough for whole pixels of shift.
      const int a = std::abs(int(x + 240 - unsigned(shift)) % 24 - 12), b = std::abs(int(y) % 20 - 10);
      image->row(y)[x * n] = static_cast<std::uint8_t>(60 + 6 * a + 5 * b);
    }
  image->stamp = stamp;
  return image;
}

TEST(MotionField, ReportsSpeedOfTheSecondImageOn) {
  for (const auto format : {PixelFormat::yuyv, PixelFormat::mono8}) {
    MotionField field;
    rt::ModuleRig rig(field);
    rig.put_image("image", squares(0, Time{0}, format));
    EXPECT_EQ(rig.step(Time{1}, 33ms), rt::StepStatus::stale);
    EXPECT_EQ(rig.get<msg::MotionField>("field"), nullptr);
    rig.put_image("image", squares(1, Time{33'000'000}, format));
    ASSERT_EQ(rig.step(Time{33'000'001}, 33ms), rt::StepStatus::ok);
    const auto* m = rig.get<msg::MotionField>("field");
    ASSERT_NE(m, nullptr);
    EXPECT_EQ(m->interval_ns, 33'000'000);
    EXPECT_EQ(m->stamp, Time{33'000'000});
    EXPECT_NEAR(m->speed_x_px, 1, 0.15);
    EXPECT_NEAR(m->speed_y_px, 0, 0.05);
    rig.put_image("image", squares(3, Time{66'000'000}, format));
    ASSERT_EQ(rig.step(Time{66'000'001}, 33ms), rt::StepStatus::ok);
    EXPECT_EQ(rig.get<msg::MotionField>("field")->moving, 1u);
  }
}

TEST(MotionField, BinnedSpeedsAreInPixelsOfTheImage) {
  MotionField field;
  rt::ModuleRig rig(field);
  rig.set("bin", std::int64_t{2});
  rig.put_image("image", squares(0, Time{0}));
  EXPECT_EQ(rig.step(Time{1}, 33ms), rt::StepStatus::stale);
  rig.put_image("image", squares(-2, Time{10}));
  ASSERT_EQ(rig.step(Time{11}, 33ms), rt::StepStatus::ok);
  const auto* m = rig.get<msg::MotionField>("field");
  EXPECT_NEAR(m->speed_x_px, -2, 0.4);
  EXPECT_NEAR(m->x[100], -2, 0.6);
  EXPECT_EQ(m->moving, 1u);
}

TEST(MotionField, StartsAgainAfterResetAndWhenTheSizeChanges) {
  MotionField field;
  rt::ModuleRig rig(field);
  const auto step = [&](const ImageBuffer& image) {
    rig.put_image("image", image);
    return rig.step(image->stamp, 33ms);
  };
  EXPECT_EQ(step(squares(0, Time{1})), rt::StepStatus::stale);
  EXPECT_EQ(step(squares(0, Time{2})), rt::StepStatus::ok);
  rig.reset();
  EXPECT_EQ(step(squares(0, Time{3})), rt::StepStatus::stale);
  EXPECT_EQ(step(squares(0, Time{4}, PixelFormat::yuyv, 256)), rt::StepStatus::stale);
  EXPECT_EQ(step(squares(0, Time{5}, PixelFormat::yuyv, 256)), rt::StepStatus::ok);
  EXPECT_EQ(step(squares(0, Time{5}, PixelFormat::yuyv, 256)), rt::StepStatus::fault);  // no time has passed
  EXPECT_EQ(step(ImageBuffer(PixelFormat::rgb8, 64, 48)), rt::StepStatus::fault);
}

TEST(MotionField, ABinOfThreeIsRefusedInWords) {
  MotionField field;
  rt::ModuleRig rig(field);
  rig.set("bin", std::int64_t{3});
  EXPECT_FALSE(rig.configure());
  std::string all;
  for (const auto& p : rig.problems()) all += rt::to_string(p, "f");
  EXPECT_NE(all.find("bin: 1, 2 or 4"), std::string::npos) << all;
}

}  // namespace
}  // namespace sinew::vision::modules_test
