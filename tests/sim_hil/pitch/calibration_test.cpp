// What a calibration finds is in the pitch: zeros of joints, soles, lenses, a board.
#include "math/hash.hpp"
#include "rig.hpp"
#include "sim_hil/pitch/lens_film.hpp"
#include "sim_hil/pitch/view.hpp"

namespace sinew::plant::pitch_calibration_test {
namespace {

using math::Vec3;

PitchBody standing(const BodyErrors& errors) {
  PitchBody body{.body = kid_body("op3")};
  body.errors = errors;
  body.gain_per_rad = 30;
  body.start.joints_rad = crouched(body.body, 0.02);
  return body;
}

TEST(JointZeros, AreInWhatTheEncodersSayAndInWhatTheServosObey) {
  BodyErrors errors = BodyErrors::none();
  errors.joint_zero_deg = 2;
  const PitchBody body = standing(errors);
  PitchOptions options;
  options.kinematic = true;
  auto pitch = pitch_with(options, {body}, 3);
  pitch->command(0, body.start.joints_rad);
  run(*pitch, 1);
  double most = 0;
  for (std::size_t j = 0; j < body.body.joints(); ++j) {
    const double zero = pitch->joint_zero_rad(0, j);
    most = std::max(most, math::fabs(zero));
    EXPECT_NEAR(pitch->sensors(0).joint[j].position_rad, pitch->truth(0).joint_rad[j] + zero, 1e-9);
    EXPECT_NEAR(pitch->truth(0).joint_rad[j], body.start.joints_rad[j] - zero, 1e-3) << body.body.links[j + 1].name;
  }
  EXPECT_GT(most, 0.03);
}

TEST(JointZeros, AreNoneUnlessAskedFor) {
  auto pitch = pitch_with({.kinematic = true}, {standing({})}, 3);
  for (std::size_t j = 0; j < pitch->body(0).joints(); ++j) EXPECT_EQ(pitch->joint_zero_rad(0, j), 0);
}

TEST(Soles, ThatAreTiltedAndThickerAreSoForPlaceAndContactAlike) {
  BodyErrors errors = BodyErrors::none();
  errors.sole_tilt_deg = 2, errors.sole_height_mm = 3;
  const PitchBody body = standing(errors);
  auto pitch = pitch_with({.kinematic = true}, {body}, 5);
  for (const char* name : {"l_sole", "r_sole"}) {
    const kinematics::Place &drawn = *body.body.find_place(name), &truth = *pitch->body(0).find_place(name);
    const double tilt = angle_between(drawn.pose.q, truth.pose.q);
    EXPECT_GT(tilt, 1e-3) << name;
    // The nearest box of the link went with it.
    const auto& shapes = pitch->body(0).links[truth.link].shapes;
    bool found = false;
    for (const kinematics::Shape& s : shapes)
      found = found || (s.kind == kinematics::Shape::Kind::box &&
                        angle_between(s.q, body.body.links[truth.link].shapes[0].q) > 0.9 * tilt);
    EXPECT_TRUE(found) << name;
  }
}

TEST(Board, LiesWhereItWasPutWithItsFirstCornerFarthestToTheLeft) {
  const PitchBoard board{0.04, 1, 0.5, 0, 0};
  const kinematics::Pose at = board.pose();
  EXPECT_NEAR(at.of({0, 0, 0}).x, 1 + 7 * 0.04, 1e-12) << "the far row; the near edge is its rim's";
  EXPECT_NEAR(at.of({0, 0, 0}).y, 0.5 + 4 * 0.04, 1e-12);
  EXPECT_NEAR(at.q.rotate({0, 0, 1}).z, -1, 1e-12) << "z goes into the ground";
  const kinematics::Pose stands = PitchBoard{0.04, 1, 0, 0, math::kPi / 2}.pose();
  EXPECT_NEAR(stands.q.rotate({0, 1, 0}).z, -1, 1e-12) << "down its columns";
  EXPECT_NEAR(stands.of({0, 7 * 0.04, 0}).z, 0, 1e-12) << "it stands on its rim";
}

TEST(Board, IsSeenByACamera) {
  PitchOptions options;
  options.has_ball = false;
  options.board = {0.04, 0.36, 0, 0, 0};
  const PitchView view(options, {});
  raster::Raster picture(320, 240);
  view.draw(picture, {.robots = {}, .ball = {}, .has_ball = false}, camera_at({0, 0, 0.45}, {0.5, 0, 0}, 320, 240));
  int board = 0, dark = 0;
  for (std::uint32_t y = 0; y < 240; ++y)
    for (std::uint32_t x = 0; x < 320; ++x)
      if (picture.shown(x, y) == kShowsBoard) ++board, dark += picture.rgb(x, y).r < 60 ? 1 : 0;
  EXPECT_GT(board, 5000);
  EXPECT_NEAR(static_cast<double>(dark) / board, 35.0 / 108, 0.06) << "half of 70 squares, of 108 with the rim";
}

TEST(LensFilm, PutsAPointWhereTheLensPutsIt) {
  const math::LensDistortion lens{-0.2, 0.05, 0, 0, 0};
  LensFilm film(320, 240, 210, lens);
  raster::Camera camera;
  camera.fx_px = camera.fy_px = film.focal_px();
  camera.cx_px = 0.5 * film.raster().width(), camera.cy_px = 0.5 * film.raster().height();
  film.raster().look(camera);
  film.raster().clear({0, 0, 0});
  const double x = 0.5, y = -0.3;
  film.raster().draw(raster::box({0.02, 0.02, 0.001}), {{x, y, 1}, {}}, {255, 255, 255}, 9);
  const auto picture = film.develop();
  double u = 0, v = 0, all = 0;
  for (std::uint32_t j = 0; j < 240; ++j)
    for (std::uint32_t i = 0; i < 320; ++i) {
      const double bright = picture[j * 320 + i] & 0xff;
      u += bright * i, v += bright * j, all += bright;
    }
  const auto at = lens.distorted(x, y);
  ASSERT_GT(all, 255);
  EXPECT_NEAR(u / all, 159.5 + 210 * at.x, 0.3);
  EXPECT_NEAR(v / all, 119.5 + 210 * at.y, 0.3);
}

}  // namespace
}  // namespace sinew::plant::pitch_calibration_test
