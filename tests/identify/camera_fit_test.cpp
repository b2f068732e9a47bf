// Cameras whose numbers the fit does not know, by exact points with noise.
#include "identify/camera_fit.hpp"

#include <gtest/gtest.h>

#include "board_picture.hpp"

namespace sinew::identify::camera_fit_test {
namespace {

constexpr double kWidth = 640, kHeight = 480, kSquare = 0.025;
constexpr vision::BoardSize kBoard{9, 6};

std::array<double, kCameraNumbers> truth_of(const LensCamera& c) {
  return {c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.lens.k1, c.lens.k2, c.lens.p1, c.lens.p2};
}

struct Secret {
  LensCamera camera;
  std::vector<PlaneView> views;
};

Secret secret(std::uint64_t seed, std::size_t views, double noise_px, double tilt_rad) {
  math::Random random(seed, 5);
  Secret s{test::secret_camera(random, kWidth, kHeight), {}};
  const test::BoardPictures board(s.camera, kBoard, kSquare, {.width = 1, .height = 1});
  while (s.views.size() < views) {
    kinematics::Pose p;
    p.q = math::Quat::exp(
        {random.uniform(-tilt_rad, tilt_rad), random.uniform(-tilt_rad, tilt_rad), random.uniform(-0.5, 0.5)});
    p.p_m = {random.uniform(-0.25, 0.15), random.uniform(-0.2, 0.1), random.uniform(0.3, 0.7)};
    PlaneView view;
    for (std::size_t i = 0; const vision::BoardCorner& c : board.corners(p)) {
      if (c.u_px > 3 && c.v_px > 3 && c.u_px < kWidth - 4 && c.v_px < kHeight - 4)
        view.push_back({static_cast<double>(i % 9) * kSquare, static_cast<double>(i / 9) * kSquare,
                        c.u_px + random.normal(0, noise_px), c.v_px + random.normal(0, noise_px)});
      ++i;
    }
    if (view.size() == 54) s.views.push_back(view);
  }
  return s;
}

TEST(LensDistortion, StraightensWhatItBent) {
  const math::LensDistortion lens{-0.28, 0.08, 0.001, -0.002, 0.01};
  for (const double x : {-0.6, 0.0, 0.5})
    for (const double y : {-0.45, 0.1, 0.4}) {
      math::LensDistortion::Xy p = lens.distorted(x, y);
      ASSERT_TRUE(lens.straighten(p));
      EXPECT_NEAR(p.x, x, 1e-11);
      EXPECT_NEAR(p.y, y, 1e-11);
      const auto d = lens.derivative(x, y);
      EXPECT_NEAR(d(0, 1), (lens.distorted(x, y + 1e-6).x - lens.distorted(x, y - 1e-6).x) / 2e-6, 1e-8);
      EXPECT_NEAR(d(1, 1), (lens.distorted(x, y + 1e-6).y - lens.distorted(x, y - 1e-6).y) / 2e-6, 1e-8);
    }
}

TEST(LensDistortion, BeyondTheEdgeOfABarrelThereIsNothing) {
  const math::LensDistortion lens{-0.3, 0, 0, 0, 0};  // no radius is put farther out than 0.70
  math::LensDistortion::Xy p{0.9, 0};
  EXPECT_FALSE(lens.straighten(p));
  EXPECT_EQ(p.x, 0.9);
}

TEST(CameraFit, IsExactWithoutNoise) {
  const Secret s = secret(1, 12, 0, 0.6);
  const CameraFit fit = fit_camera(s.views);
  ASSERT_EQ(fit.problem, "");
  const auto truth = truth_of(s.camera);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(fit.estimates[i].value, truth[i], 1e-3) << camera_numbers()[i].name;
  for (std::size_t i = 4; i < 8; ++i) EXPECT_NEAR(fit.estimates[i].value, truth[i], 1e-5) << camera_numbers()[i].name;
  EXPECT_LT(fit.rms_px, 1e-4);
}

TEST(CameraFit, ItsIntervalsHold) {
  int held = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 25; ++seed) {
    const Secret s = secret(seed, 15, 0.15, 0.6);
    const CameraFit fit = fit_camera(s.views, {.held_out_each = 0});
    ASSERT_EQ(fit.problem, "");
    const auto truth = truth_of(s.camera);
    for (std::size_t i = 0; i < kCameraNumbers; ++i, ++all)
      held += math::fabs(fit.estimates[i].value - truth[i]) <= fit.estimates[i].half_width ? 1 : 0;
    EXPECT_NEAR(fit.sigma_px, 0.15, 0.02);
    EXPECT_LT(fit.estimates[0].half_width, 12) << seed;
  }
  EXPECT_GE(held * 100, 89 * all);
  EXPECT_LE(held * 100, 99 * all);
}

TEST(CameraFit, PredictsViewsThatItDidNotFit) {
  const CameraFit fit = fit_camera(secret(3, 20, 0.2, 0.6).views);
  ASSERT_EQ(fit.problem, "");
  EXPECT_NEAR(fit.rms_px, 0.2 * math::sqrt(2.0), 0.02);
  EXPECT_NEAR(fit.held_out_rms_px, 0.2 * math::sqrt(2.0), 0.04);
  EXPECT_TRUE(fit.unknown.empty() || fit.reach < 0.75);
}

TEST(CameraFit, NamesTheFocalLengthWhereAllViewsAreFromTheFront) {
  const CameraFit fit = fit_camera(secret(4, 10, 0.2, 0.01).views, {.held_out_each = 0});
  ASSERT_EQ(fit.problem, "");
  EXPECT_FALSE(fit.estimates[0].shown);
  ASSERT_FALSE(fit.unknown.empty());
  EXPECT_NE(fit.unknown[0].find("fx, fy: a focal length and the distance stand for each other"), std::string::npos);
  EXPECT_NE(fit.unknown[0].find("tilt it by 20 degrees"), std::string::npos) << fit.unknown[0];
}

TEST(CameraFit, HoldsALensThatTheViewsDoNotReach) {
  // All corners in the middle fifth of the picture.
  Secret s = secret(5, 3, 0, 0.5);
  const LensCamera c{500, 500, 319.5, 239.5, {}};
  math::Random random(6);
  for (PlaneView& view : s.views) {
    const kinematics::Pose p{{-0.1, -0.06, 2.5},
                             math::Quat::exp({random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), 0})};
    for (PlanePoint& point : view) {
      const auto at = c.pixel(p.of({point.x_m, point.y_m, 0}));
      point.u_px = at.u_px + random.normal(0, 0.2), point.v_px = at.v_px + random.normal(0, 0.2);
    }
  }
  const CameraFit fit = fit_camera(s.views, {.held_out_each = 0});
  ASSERT_EQ(fit.problem, "");
  EXPECT_LT(fit.reach, 0.45);
  ASSERT_FALSE(fit.unknown.empty());
  EXPECT_NE(fit.unknown.back().find("the lens beyond what was seen"), std::string::npos);
}

TEST(CameraFit, SaysWhatIsWrongWithViews) {
  Secret s = secret(7, 4, 0.1, 0.5);
  EXPECT_EQ(fit_camera({s.views.data(), 2}).problem, "only 2 views, at least 3 are needed");
  auto views = s.views;
  views[1][3].u_px = math::kNan;
  EXPECT_EQ(fit_camera(views).problem, "view 1 has a number that is not finite");
  views = s.views;
  views[2].resize(9);  // one row of the board
  EXPECT_EQ(fit_camera(views).problem, "view 2 has fewer than 4 points, or all in a line: nothing can be said from it");
  EXPECT_EQ(fit_camera(s.views, {.width_px = 0}).problem, "the picture's size is not known");
}

TEST(PlanePose, IsWhereThePlaneIs) {
  const LensCamera c{420, 425, 310, 250, {-0.2, 0.05, 0.001, 0, 0}};
  const kinematics::Pose truth{{-0.05, 0.02, 0.6}, math::Quat::exp({0.4, -0.3, 0.2})};
  PlaneView view;
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i < 9; ++i) {
      const auto at = c.pixel(truth.of({i * 0.02, j * 0.02, 0}));
      view.push_back({i * 0.02, j * 0.02, at.u_px, at.v_px});
    }
  const auto pose = plane_pose(c, view);
  ASSERT_TRUE(pose);
  EXPECT_LT(norm(pose->p_m - truth.p_m), 1e-6);
  EXPECT_LT(angle_between(pose->q, truth.q), 1e-6);
  view.resize(3);
  EXPECT_FALSE(plane_pose(c, view));
}

}  // namespace
}  // namespace sinew::identify::camera_fit_test
