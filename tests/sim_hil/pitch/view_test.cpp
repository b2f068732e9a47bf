// Pictures of the pitch: what the cameras see is where it is, and each pixel says what it shows.
#include "sim_hil/pitch/view.hpp"

#include <map>

#include "math/hash.hpp"
#include "rig.hpp"
#include "sim_hil/pitch/wheeled.hpp"

namespace sinew::plant::pitch_view_test {
namespace {

using math::Vec3;

/// Two standing robots that look at each other over the ball.
struct Stage {
  std::vector<PitchBody> bodies;
  PitchOptions options;
  std::unique_ptr<Pitch> pitch;
  PitchScene scene;

  explicit Stage(const char* body = "op3") {
    options.kinematic = true;  // nothing moves: no dynamics needed
    for (const double side : {-1.0, 1.0}) {
      PitchBody b{.body = kid_body(body)};
      b.team = side < 0 ? 0 : 1;
      b.start = {.x_m = side * 0.9, .y_m = 0, .heading_rad = side < 0 ? 0 : math::kPi};
      b.start.joints_rad = crouched(b.body, 0.02);
      bodies.push_back(b);
    }
    pitch = pitch_with(options, bodies);
    scene.take(*pitch);
  }
};

std::map<int, int> counted(const raster::Raster& picture) {
  std::map<int, int> count;
  for (const std::uint32_t p : picture.pixels()) ++count[static_cast<int>(p >> 24)];
  return count;
}

TEST(PitchPictures, ShowTheOtherRobotTheBallLinesGoalAndCarpetThroughBothCameras) {
  for (const char* body : {"op3", "nao"}) {
    const Stage stage(body);
    const PitchView view(stage.options, stage.bodies);
    ASSERT_EQ(view.cameras(0), 2u) << body;
    raster::Raster picture(320, 240);
    view.draw(picture, stage.scene, 0, 0);
    auto count = counted(picture);
    EXPECT_GT(count[kShowsCarpet], 10000) << body;
    EXPECT_GT(count[kShowsLine], 300) << body;
    EXPECT_GT(count[kShowsGoal], 100) << body;
    EXPECT_GT(count[kShowsRobot + 1], 500) << body;
    EXPECT_GT(count[kShowsNothing], 1000) << "above the horizon";
    view.draw(picture, stage.scene, 0, 1);
    count = counted(picture);
    EXPECT_GT(count[kShowsBall] + count[kShowsLine], 100) << body << ": the lower camera";
    EXPECT_EQ(count[kShowsNothing], 0) << body << ": it looks down";
  }
}

TEST(PitchPictures, TheBallIsWhereTheCameraProjectsIt) {
  const Stage stage;
  const PitchView view(stage.options, stage.bodies);
  raster::Raster picture(320, 240);
  for (const std::size_t robot : {0u, 1u}) {
    const raster::Camera camera = view.camera(stage.scene, robot, 0, 320, 240);
    const Vec3 at = camera.pose.inverse().of(stage.pitch->ball().p_m);
    ASSERT_GT(at.z, 0.5);
    view.draw(picture, stage.scene, robot, 0);
    double x = 0, y = 0, n = 0;
    for (std::uint32_t row = 0; row < 240; ++row)
      for (std::uint32_t column = 0; column < 320; ++column)
        if (picture.shown(column, row) == kShowsBall) x += column + 0.5, y += row + 0.5, ++n;
    ASSERT_GT(n, 50);
    EXPECT_NEAR(x / n, camera.cx_px + camera.fx_px * at.x / at.z, 1);
    EXPECT_NEAR(y / n, camera.cy_px + camera.fy_px * at.y / at.z, 1);
    const double radius_px = camera.fx_px * kKidBall.radius_m / at.z;
    EXPECT_NEAR(n, math::kPi * radius_px * radius_px, 0.1 * n);
  }
}

TEST(PitchPictures, JerseysHaveTheirTeamsColour) {
  const Stage stage;
  const PitchView view(stage.options, stage.bodies);
  raster::Raster picture(320, 240);
  int blue = 0, red = 0;
  for (const std::size_t robot : {0u, 1u}) {
    view.draw(picture, stage.scene, robot, 0);
    for (std::uint32_t row = 0; row < 240; ++row)
      for (std::uint32_t column = 0; column < 320; ++column) {
        const auto other = static_cast<int>(kShowsRobot + 1 - robot);
        if (picture.shown(column, row) != other) continue;
        const raster::Colour c = picture.rgb(column, row);
        if (c.b > c.r + 60) blue += robot == 1 ? 1 : -1000;
        if (c.r > c.b + 60) red += robot == 0 ? 1 : -1000;
      }
  }
  EXPECT_GT(blue, 100);
  EXPECT_GT(red, 100);
}

TEST(PitchPictures, ARobotFromOutsideIsAsTallAsItIs) {
  const Stage stage;
  const PitchView view(stage.options, stage.bodies);
  raster::Raster picture(640, 480);
  const raster::Camera camera = camera_at({-0.9, -2, 0.25}, {-0.9, 0, 0.25}, 640, 480);
  view.draw(picture, stage.scene, camera);
  std::uint32_t top = 480, bottom = 0;
  for (std::uint32_t row = 0; row < 480; ++row)
    for (std::uint32_t column = 0; column < 640; ++column)
      if (picture.shown(column, row) == kShowsRobot) top = std::min(top, row), bottom = std::max(bottom, row);
  const double tall_m = (bottom - top + 1) / camera.fy_px * 2;
  EXPECT_NEAR(tall_m, 0.47, 0.05);
}

TEST(PitchPictures, HaveTheSameBytesOnEveryMachine) {
  Stage stage;
  stage.bodies.push_back(pioneer_body({.x_m = 0.5, .y_m = 1}));
  stage.pitch = pitch_with(stage.options, stage.bodies);
  stage.scene.take(*stage.pitch);
  const PitchView view(stage.options, stage.bodies);
  raster::Raster picture(160, 120);
  std::uint64_t hash = math::fnv1a64("");
  for (std::size_t robot = 0; robot < 3; ++robot)
    for (std::size_t camera = 0; camera < view.cameras(robot); ++camera) {
      view.draw(picture, stage.scene, robot, camera);
      for (const std::uint32_t p : picture.pixels())
        for (int shift = 0; shift < 32; shift += 8) {
          const char byte = static_cast<char>(p >> shift & 255);
          hash = math::fnv1a64({&byte, 1}, hash);
        }
    }
  EXPECT_EQ(hash, 3821771861900973582u) << "seen on amd64";
}

}  // namespace
}  // namespace sinew::plant::pitch_view_test
