// The pad as sinew-sim draws it, found and measured against where it really is.
#include <gtest/gtest.h>

#include <cmath>

#include "images.hpp"
#include "qemu_user.hpp"
#include "robots/quad/world/room_xml.hpp"
#include "robots/quad/world/vehicle.hpp"
#include "sim_hil/plant/renderer.hpp"
#include "sim_hil/worlds/vec.hpp"
#include "vision/pad_finder.hpp"
#include "vision/pinhole.hpp"

namespace sinew::vision::pad_rendered_test {
namespace {

using plant::CameraPose;
using plant::Renderer;

constexpr double kFov = 1.0382921838;  // of PadDetector, and of the plant's camera

msg::Quat about(const msg::Vec3& axis, double angle_rad) {
  const double s = std::sin(angle_rad / 2);
  return {std::cos(angle_rad / 2), s * axis.x, s * axis.y, s * axis.z};
}

/// Uniform over seven levels: a deviation of 2.
std::uint8_t noisy(int v, math::Random& random) {
  return static_cast<std::uint8_t>(std::clamp(v + static_cast<int>(random.below(7)) - 3, 0, 255));
}

/// Largest errors over many poses of one height.
struct Worst {
  double ground_m = 0, range = 0, confidence = 1;
  int found = 0, asked = 0;
};

class RenderedPad : public testing::TestWithParam<std::pair<std::uint32_t, std::uint32_t>> {
 protected:
  void SetUp() override {
    std::string why;
    auto made = Renderer::create({GetParam().first, GetParam().second, false, robots::room_xml_of_quad()}, why);
    if (!made) SINEW_SKIP_UNDER_QEMU_USER(why);
    ASSERT_TRUE(made) << why;
    renderer_ = std::move(*made);
  }

  /// The camera `height_m` above the pad, the pad `off_x`, `off_y` beside the axis (share of the half image at that
  /// height), any heading, tilted about a level axis.
  void look(double height_m, double off_x, double off_y, double tilt_rad, math::Random& random, Worst& worst) {
    const auto [width, height] = GetParam();
    const Pinhole camera = Pinhole::from_fov(kFov, width, height);
    const msg::Quat turn = plant::mul(about({0, 0, 1}, random.uniform(0, 6.28)),
                                      about({std::cos(off_x * 7), std::sin(off_x * 7), 0}, tilt_rad));
    const msg::Quat q = plant::mul(turn, plant::kCameraQBaseOptical);
    // From the pad back along the ray on which it shall be seen.
    const msg::Vec3 ray =
        plant::Rotation(q).apply(camera.direction(camera.cx_px * (1 + off_x), camera.cy_px * (1 + off_y)));
    const double range = -height_m / ray.z;
    const CameraPose pose{{-range * ray.x, -range * ray.y, 0.003 + height_m}, q};
    test::Pixels image(msg::PixelFormat::yuyv, width, height);
    renderer_->camera_view(pose, msg::PixelFormat::yuyv, image.bytes().data());
    for (auto& v : image.bytes()) v = noisy(v, random);

    const PadCircle pad = finder_.find(image.view());
    ++worst.asked;
    if (!pad.found || pad.confidence < 0.3) return;
    ++worst.found;
    const msg::Vec3 d = camera.direction(pad.circle.x, pad.circle.y);
    const msg::Vec3 t = camera.direction(camera.cx_px * (1 + off_x), camera.cy_px * (1 + off_y));
    const double angle = std::hypot(d.x - t.x, d.y - t.y, d.z - t.z);
    worst.ground_m = std::max(worst.ground_m, angle * range);
    worst.range = std::max(worst.range, std::fabs(camera.fx_px * pad.radius_m / pad.circle.radius / d.z / range - 1));
    worst.confidence = std::min(worst.confidence, pad.confidence);
  }

  std::unique_ptr<Renderer> renderer_;
  PadFinder finder_{{}, {.colours = 1, .min_area_px = 12}};
};

TEST_P(RenderedPad, IsMeasuredFromTwentyCentimetresToFourMetres) {
  math::Random random(1);
  for (const double h : {0.2, 0.3, 0.4, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0}) {
    Worst level, tilted;
    // Near touch-down the pad is below; from above anywhere in the image.
    const double reach = h < 0.35 ? 0.15 : 0.6;
    for (const double x : {-reach, 0.0, reach})
      for (const double y : {-reach, 0.0, reach}) {
        look(h, x, y, 0, random, level);
        if (h >= 0.5) look(h, x, y, 0.12, random, tilted);
      }
    std::printf("%4.1f m: %2d of %2d found, centre within %5.1f mm, range within %4.1f %%, confidence from %.2f", h,
                level.found, level.asked, 1e3 * level.ground_m, 100 * level.range, level.confidence);
    if (tilted.asked > 0)
      std::printf("; tilted by 7 deg %2d of %2d, %5.1f mm, %4.1f %%", tilted.found, tilted.asked, 1e3 * tilted.ground_m,
                  100 * tilted.range);
    std::printf("\n");
    EXPECT_EQ(level.found, level.asked) << h;
    EXPECT_EQ(tilted.found, tilted.asked) << h;
    EXPECT_LT(level.ground_m, 0.015 + 0.01 * h) << h;
    EXPECT_LT(tilted.ground_m, 0.03 + 0.02 * h) << h;
    EXPECT_LT(level.range, 0.05) << h;
  }
}

TEST_P(RenderedPad, IsNotSeenWhereThereIsNone) {
  const auto [width, height] = GetParam();
  math::Random random(2);
  test::Pixels image(msg::PixelFormat::yuyv, width, height);
  for (int i = 0; i < 60; ++i) {
    const double x = random.uniform(-3.5, 3.5), y = random.uniform(-3.5, 3.5), h = random.uniform(0.3, 1.2);
    if (std::hypot(x, y) < 1.9) continue;  // the half diagonal of the image is 0.95 heights
    const msg::Quat q = plant::mul(about({0, 0, 1}, random.uniform(0, 6.28)), plant::kCameraQBaseOptical);
    renderer_->camera_view({{x, y, h}, q}, msg::PixelFormat::yuyv, image.bytes().data());
    const PadCircle pad = finder_.find(image.view());
    EXPECT_LT(pad.found ? pad.confidence : 0, 0.1) << x << ' ' << y << ' ' << h;
  }
}

INSTANTIATE_TEST_SUITE_P(PadFinder, RenderedPad, testing::Values(std::pair{320u, 240u}, std::pair{640u, 480u}),
                         [](const auto& p) { return std::to_string(p.param.first); });

}  // namespace
}  // namespace sinew::vision::pad_rendered_test
