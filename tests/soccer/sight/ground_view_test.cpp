#include "soccer/sight/ground_view.hpp"

#include <gtest/gtest.h>

#include "math/random.hpp"
#include "painted.hpp"

namespace sinew::soccer::ground_view_test {
namespace {

TEST(GroundView, APixelOfAPlaceShowsThisPlace) {
  const test::Painting p{.robot = {1, -0.5, 2}, .look_left_rad = 0.3};
  const GroundView view = p.view();
  for (const GroundXy at : {GroundXy{0.4, 0.1}, {1, 0.5}, {2.5, -0.4}}) {
    const PixelAt px = view.pixel(at);
    ASSERT_GT(px.depth_m, 0);
    const auto back = view.ground(px.u_px, px.v_px);
    ASSERT_TRUE(back);
    EXPECT_NEAR(back->x_m, at.x_m, 1e-9);
    EXPECT_NEAR(back->y_m, at.y_m, 1e-9);
  }
}

TEST(GroundView, NothingAboveTheHorizonIsOnTheGround) {
  const GroundView view = test::Painting{.look_down_rad = 0.1}.view();
  const double horizon = view.horizon_px(100);
  EXPECT_GT(horizon, 0);
  EXPECT_FALSE(view.ground(100, horizon - 1));
  EXPECT_FALSE(view.ground(100, horizon + 0.1)) << "farther than any field";
  EXPECT_TRUE(view.ground(100, horizon + 20));
  EXPECT_FALSE(view.ball_radius_px(100, horizon - 1, 0.07));
}

TEST(GroundView, ABallLooksAsLargeAsItsDistanceSays) {
  const test::Painting p;
  const PixelAt px = p.view().pixel({2, 0, 0.07});
  const double way = math::hypot(2, 0.45 - 0.07);
  const auto radius = p.view().ball_radius_px(px.u_px, px.v_px, 0.07);
  ASSERT_TRUE(radius);
  EXPECT_NEAR(*radius, 210 * 0.07 / way, 0.01);
}

// The covariance against what random errors of tilt, heading and pixel do.
TEST(GroundView, TheCovarianceIsThatOfItsErrors) {
  const test::Painting p{.look_left_rad = 0.4};
  const ViewErrors errors{.tilt_rad = 0.01, .heading_rad = 0.008, .pixel_px = 0.5};
  const GroundView view = p.view(errors);
  const GroundXy truth{1.6, 0.8};
  const PixelAt px = view.pixel(truth);
  math::Random random(3);
  double xx = 0, xy = 0, yy = 0;
  constexpr int kTimes = 4000;
  for (int i = 0; i < kTimes; ++i) {
    test::Painting wrong = p;
    // About the vertical, and about the horizontal axis across the line of sight.
    const double way = math::atan2(truth.y_m, truth.x_m), turn = random.normal(0, errors.heading_rad);
    msg::CameraPose pose = wrong.pose();
    const math::Vec3 across{-math::sin(way), math::cos(way), 0};
    pose.q_world_optical = (math::Quat::from_axis_angle(across, random.normal(0, errors.tilt_rad)) *
                            math::Quat::from_axis_angle({0, 0, 1}, turn) * math::Quat(pose.q_world_optical))
                               .to<msg::Quat>();
    const GroundView other(p.camera(), pose, p.robot, errors);
    const auto at = other.ground(px.u_px + random.normal(0, 0.5), px.v_px + random.normal(0, 0.5));
    ASSERT_TRUE(at);
    const double dx = at->x_m - truth.x_m, dy = at->y_m - truth.y_m;
    xx += dx * dx / kTimes, xy += dx * dy / kTimes, yy += dy * dy / kTimes;
  }
  const msg::GroundPoint said = view.with_covariance(truth);
  EXPECT_NEAR(said.xx_m2 / xx, 1, 0.15);
  EXPECT_NEAR(said.yy_m2 / yy, 1, 0.15);
  EXPECT_NEAR(said.xy_m2 / xy, 1, 0.2);
}

TEST(GroundView, ACameraThatLiesOrIsNowhereIsNotUpright) {
  test::Painting p;
  EXPECT_TRUE(p.view().is_upright());
  p.look_down_rad = 1.6;
  EXPECT_FALSE(p.view().is_upright());
  p.look_down_rad = 0.3, p.camera_high_m = 0.01;
  EXPECT_FALSE(p.view().is_upright());
  p.camera_high_m = math::kNan;
  EXPECT_FALSE(p.view().is_upright());
}

}  // namespace
}  // namespace sinew::soccer::ground_view_test
