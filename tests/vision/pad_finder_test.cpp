#include "vision/pad_finder.hpp"

#include <gtest/gtest.h>

#include "pad_scene.hpp"

namespace sinew::vision::pad_finder_test {
namespace {

using msg::PixelFormat;
using test::CameraPose;
using test::PadScene;
using test::Pixels;

struct Outcome {
  PadCircle pad;
  double angle_error_rad = 0, range_error = 0;  // of the range: relative
};

Outcome look(const CameraPose& pose, std::uint32_t width, std::uint32_t height, double noise = 3, double light = 1) {
  const PadScene scene(pose, width, height);
  Pixels p(PixelFormat::yuyv, width, height);
  scene.render(p.bytes().data(), width, height, noise, light);
  PadFinder finder({}, {.min_area_px = 12});
  Outcome o{finder.find(p.view())};
  if (!o.pad.found) return o;
  const msg::Vec3 d = scene.camera().direction(o.pad.circle.x, o.pad.circle.y), t = scene.true_direction();
  o.angle_error_rad = std::sqrt((d.x - t.x) * (d.x - t.x) + (d.y - t.y) * (d.y - t.y) + (d.z - t.z) * (d.z - t.z));
  const double range = scene.camera().fx_px * o.pad.radius_m / o.pad.circle.radius / d.z;
  o.range_error = range / scene.true_range_m() - 1;
  return o;
}

/// Offset of the centre that an angle error means on the ground.
double ground_error_m(const Outcome& o, const CameraPose& pose) { return o.angle_error_rad * pose.height_m; }

class Heights : public testing::TestWithParam<std::pair<std::uint32_t, std::uint32_t>> {};

TEST_P(Heights, PadIsMeasuredFromTwentyCentimetresToFourMetres) {
  const auto [width, height] = GetParam();
  for (const double h : {0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0}) {
    const CameraPose pose{.height_m = h, .right_m = 0.02, .down_m = -0.03};
    const Outcome o = look(pose, width, height);
    ASSERT_TRUE(o.pad.found) << h;
    EXPECT_LT(ground_error_m(o, pose), 0.01) << h;
    EXPECT_NEAR(o.range_error, 0, 0.05) << h;
    EXPECT_GT(o.pad.confidence, 0.4) << h;
    if (h <= 0.3 || h >= 0.5) {  // below, the edge is out of sight
      EXPECT_EQ(o.pad.is_mark, h <= 0.3) << h;
    }
    RecordProperty("range_error_" + std::to_string(int(h * 100)), std::to_string(o.range_error));
  }
}
INSTANTIATE_TEST_SUITE_P(PadFinder, Heights, testing::Values(std::pair{320u, 240u}, std::pair{640u, 480u}),
                         [](const auto& p) { return std::to_string(p.param.first); });

TEST(PadFinder, CentreIsRightWhenTheImageCutsThePadOnAnySide) {
  for (const double h : {0.6, 1.0, 2.0})
    for (const double x : {-0.55, 0.0, 0.55})
      for (const double y : {-0.55, 0.0, 0.55}) {
        // Along each axis the centre lies near the border: half of the pad or less is in the image.
        const CameraPose pose{.height_m = h, .right_m = x / 0.55 * 0.72 * h, .down_m = y / 0.55 * 0.52 * h};
        const Outcome o = look(pose, 320, 240);
        ASSERT_TRUE(o.pad.found) << h << ' ' << x << ' ' << y;
        EXPECT_LT(ground_error_m(o, pose), 0.03) << h << ' ' << x << ' ' << y;
        EXPECT_NEAR(o.range_error, 0, 0.08) << h << ' ' << x << ' ' << y;
      }
}

TEST(PadFinder, CentreOutsideOfTheImageIsStillMeasured) {
  const CameraPose pose{.height_m = 1.0, .right_m = 0.85};  // the image ends at 0.76 m
  const Outcome o = look(pose, 640, 480);
  ASSERT_TRUE(o.pad.found);
  EXPECT_GT(-o.pad.circle.x, 0);
  EXPECT_LT(ground_error_m(o, pose), 0.04);
}

TEST(PadFinder, TiltOfTenDegreesCostsLittle) {
  for (const double h : {0.5, 1.0, 3.0})
    for (const double tilt : {-0.17, 0.17}) {
      const CameraPose pose{.height_m = h, .tilt_x_rad = tilt, .tilt_y_rad = 0.5 * tilt};
      const Outcome o = look(pose, 320, 240);
      ASSERT_TRUE(o.pad.found) << h;
      EXPECT_LT(ground_error_m(o, pose), 0.02 + 0.01 * h) << h << ' ' << tilt;
      EXPECT_NEAR(o.range_error, 0, 0.06) << h;
    }
}

TEST(PadFinder, LightFromAThirdToFullChangesLittle) {
  for (const double light : {0.33, 0.6, 1.0}) {
    const CameraPose pose{.height_m = 1.2, .right_m = 0.1};
    const Outcome o = look(pose, 320, 240, 3, light);
    ASSERT_TRUE(o.pad.found) << light;
    EXPECT_LT(ground_error_m(o, pose), 0.01) << light;
  }
}

TEST(PadFinder, NoPadIsFoundOnAnEmptyFloorNorInNoise) {
  const Outcome o = look({.height_m = 1.5, .right_m = 3}, 320, 240);
  EXPECT_FALSE(o.pad.found);
  EXPECT_EQ(o.pad.confidence, 0);
  PadFinder finder({}, {.max_runs = 4096, .min_area_px = 12});
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Pixels p(PixelFormat::yuyv, 320, 240);
    test::fill_noise(p.bytes().data(), p.bytes().size(), seed);
    EXPECT_FALSE(finder.find(p.view()).found) << seed;
  }
}

TEST(PadFinder, AnOrangeBoxIsNotAPad) {
  Pixels p(PixelFormat::yuyv, 320, 240);
  test::paint_yuyv(p.bytes().data(), 320, 240, [](std::uint32_t x, std::uint32_t y) {
    return x > 100 && x < 220 && y > 90 && y < 150 ? Rgb{236, 66, 18} : Rgb{90, 90, 88};
  });
  PadFinder finder({}, {.min_area_px = 12});
  EXPECT_LT(finder.find(p.view()).confidence, 0.2);
}

TEST(PadFinder, ASmallOrangeThingBesideThePadDoesNotMatter) {
  const CameraPose pose{.height_m = 1.5, .right_m = 0.3};
  const PadScene scene(pose, 320, 240);
  Pixels p(PixelFormat::yuyv, 320, 240);
  math::Random random(3);
  test::paint_yuyv(p.bytes().data(), 320, 240, [&](std::uint32_t x, std::uint32_t y) {
    return x > 250 && x < 275 && y > 30 && y < 60 ? Rgb{236, 66, 18} : scene.pixel(x, y, random, 2, 1);
  });
  PadFinder finder({}, {.min_area_px = 12});
  const PadCircle pad = finder.find(p.view());
  ASSERT_TRUE(pad.found);
  EXPECT_NEAR(pad.circle.x, scene.camera().cx_px - 0.3 / 1.5 * scene.camera().fx_px, 1.0);
  EXPECT_GE(pad.blobs, 2u);
}

TEST(PadFinder, RgbAndYuyvAgree) {
  const PadScene scene({.height_m = 1.0, .right_m = 0.2, .down_m = 0.1}, 320, 240);
  Pixels yuyv(PixelFormat::yuyv, 320, 240), rgb(PixelFormat::rgb8, 320, 240);
  math::Random random(5);
  scene.render(yuyv.bytes().data(), 320, 240);
  for (std::uint32_t y = 0; y < 240; ++y)
    for (std::uint32_t x = 0; x < 320; ++x) {
      const Rgb c = scene.pixel(x, y, random, 3, 1);
      rgb.row(y)[3 * x] = std::uint8_t(c.r), rgb.row(y)[3 * x + 1] = std::uint8_t(c.g);
      rgb.row(y)[3 * x + 2] = std::uint8_t(c.b);
    }
  PadFinder finder({}, {.min_area_px = 12});
  const PadCircle a = finder.find(yuyv.view()), b = finder.find(rgb.view());
  ASSERT_TRUE(a.found && b.found);
  EXPECT_NEAR(a.circle.x, b.circle.x, 0.7);
  EXPECT_NEAR(a.circle.y, b.circle.y, 0.7);
  EXPECT_NEAR(a.circle.radius, b.circle.radius, 0.7);
}

}  // namespace
}  // namespace sinew::vision::pad_finder_test
