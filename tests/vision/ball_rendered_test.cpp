// The ball as sinew-sim draws it, found and measured against where it really is.
#include <gtest/gtest.h>

#include <cmath>

#include "images.hpp"
#include "qemu_user.hpp"
#include "robots/desk_head/world/head_body.hpp"
#include "robots/desk_head/world/head_world.hpp"
#include "robots/desk_head/world/room_xml.hpp"
#include "sim_hil/plant/renderer.hpp"
#include "vision/ball_finder.hpp"
#include "vision/pinhole.hpp"

namespace sinew::vision::ball_rendered_test {
namespace {

constexpr double kFov = 1.0382921838;  // of BallDetector, and of the plant's camera

class RenderedBall : public testing::TestWithParam<std::pair<std::uint32_t, std::uint32_t>> {};

TEST_P(RenderedBall, IsFoundWhereverItIsInSightAndNothingElseIs) {
  const auto [width, height] = GetParam();
  std::string why;
  auto renderer = plant::Renderer::create({width, height, false, robots::room_xml_of_desk_head()}, why);
  if (!renderer) SINEW_SKIP_UNDER_QEMU_USER(why);
  ASSERT_TRUE(renderer) << why;
  const Pinhole camera = Pinhole::from_fov(kFov, width, height);
  BallFinder finder({}, {.colours = 1, .min_area_px = 12});
  test::Pixels image(msg::PixelFormat::yuyv, width, height);
  math::Random random(4);
  int frames = 0, asked = 0, found = 0, wrong = 0;
  double sum2 = 0, worst_range = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    plant::HeadOptions o;
    o.seed = seed;
    plant::HeadWorld world(o);
    // The head looks about by itself; the ball is wherever it is.
    for (int i = 0; i < 60'000; ++i) {
      const double t = i * 2.5e-4;
      const std::array<double, 2> command{0.6 * std::sin(0.9 * t), 0.25 * std::sin(0.7 * t)};
      if (world.step(command).cameras == 0 || ++frames % 5 != 0) continue;
      const plant::Scene scene = world.scene(0);
      (*renderer)->place(scene);
      (*renderer)->camera_view(scene.camera, msg::PixelFormat::yuyv, image.bytes().data());
      for (auto& v : image.bytes())
        v = static_cast<std::uint8_t>(std::clamp(v + static_cast<int>(random.below(7)) - 3, 0, 255));
      const BallImage ball = finder.find(image.view(), camera);
      const math::Vec3 to = math::Quat(scene.camera.q_world_optical)
                                .conjugate()
                                .rotate(world.ball_m() - math::Vec3(scene.camera.p_world_m));
      const double u = camera.cx_px + camera.fx_px * to.x / to.z, v = camera.cy_px + camera.fy_px * to.y / to.z;
      const double r = camera.fx_px * plant::kBallRadius / to.z, r0 = camera.fx_px * plant::kBallRadius / norm(to);
      const bool whole = to.z > 0 && u > r && u < width - 1 - r && v > r && v < height - 1 - r && !world.ball_hidden();
      asked += whole;
      const double off = std::hypot(ball.u_px - u, ball.v_px - v);
      if (ball.found && !(off < 0.7 * r + 2)) ++wrong;
      if (!whole || !ball.found) continue;
      ++found;
      sum2 += off * off / (r * r);
      worst_range = std::max(worst_range, std::fabs(ball.radius_px / r0 - 1));
    }
  }
  std::printf("%u x %u: %d of %d found, %d wrong, off by %.3f radii RMS, radius within %.0f %%\n", width, height, found,
              asked, wrong, std::sqrt(sum2 / found), 100 * worst_range);
  EXPECT_GT(asked, 100);
  EXPECT_GE(found, asked * 99 / 100);
  EXPECT_LE(wrong, asked / 100);
  EXPECT_LT(std::sqrt(sum2 / found), 0.06);
  EXPECT_LT(worst_range, 0.25);
}
INSTANTIATE_TEST_SUITE_P(BallFinder, RenderedBall, testing::Values(std::pair{320u, 240u}, std::pair{640u, 480u}),
                         [](const auto& p) { return std::to_string(p.param.first); });

}  // namespace
}  // namespace sinew::vision::ball_rendered_test
