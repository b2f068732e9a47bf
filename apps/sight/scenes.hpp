#pragma once
// Pictures of the pitch with their truth, as a robot's camera would take them: somebody looks from anywhere, others
// stand or lie about, the light is bad, the head moves, the camera's pose is not quite what the robot believes.
#include <cstdint>
#include <optional>
#include <vector>

#include "math/random.hpp"
#include "sim_hil/pitch/view.hpp"
#include "soccer/field.hpp"
#include "soccer/sight/field_sight.hpp"

namespace sinew::sight {

enum class Lighting : std::uint8_t {
  clean,   // as sinew-sim draws it
  tuning,  // what the classifier is trained in
  unseen   // wider, and of other kinds: gamma, vignette, coloured shadows; never trained or tuned in
};

struct SceneOptions {
  std::uint32_t width = 320, height = 240;
  Lighting lighting = Lighting::tuning;
  std::uint64_t seed = 1;
  std::uint64_t same_light = 4;  // pictures in a row
  bool seek_ball = false;        // a ball that is beyond the picture is put elsewhere, up to five times
};

struct Scene {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> yuyv;
  std::vector<std::uint8_t> shows;  // plant::PitchThing of each pixel

  msg::CameraPose true_pose, believed_pose;  // in the frame of the field
  vision::Pinhole camera;
  soccer::RobotAt robot;  // the looking one

  struct Ball {
    math::Vec3 p_m;  // robot
    double u_px = 0, v_px = 0, radius_px = 0;
    double visible = 0;  // share of its disc that the picture shows
    bool spotted = true;
  };
  std::optional<Ball> ball;  // none: there is none on the field
  double blur_px = 0;        // way that the picture moved while the shutter was open
  struct Other {
    double x_m = 0, y_m = 0;  // robot: below its torso
    bool upright = true, red = false;
    int pixels = 0;  // that show it
  };
  std::vector<Other> others;

  vision::ImageView view() const { return {yuyv.data(), width, height, width * 2, msg::PixelFormat::yuyv}; }
  soccer::GroundView ground(bool truly, const soccer::ViewErrors& errors = {}) const {
    return {camera, truly ? true_pose : believed_pose, robot, errors};
  }
  std::uint8_t shown(int x, int y) const {
    return shows[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)];
  }
  /// A place of the field in the frame "robot".
  soccer::GroundXy in_robot(double x_m, double y_m) const;
};

/// Thread:  owner.
class SceneMaker {
 public:
  SceneMaker(const kinematics::Body& body, const SceneOptions& options);
  /// The scene with this number: a function of it and of the options.
  void make(std::uint64_t number, Scene& out);

 private:
  struct Light;
  Light light_of(math::Random& random) const;
  void place_robots(math::Random& random, Scene& out);
  void paint_background(math::Random& random);
  void degrade(const Light& light, math::Random& random, const raster::Raster& picture, const raster::Camera& camera,
               Scene& out);

  const kinematics::Body& body_;
  SceneOptions o_;
  std::vector<plant::PitchBody> bodies_;
  plant::PitchOptions pitch_;
  plant::PitchView view_;
  plant::PitchScene scene_;
  raster::Raster one_, two_;
  std::vector<float> rgb_, other_;
};

}  // namespace sinew::sight
