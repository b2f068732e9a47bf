#pragma once
// Pictures of the pitch, by sim_hil/raster: what each robot's cameras see, or a viewer from outside; and which pixel
// shows what.
#include <cstdint>
#include <span>
#include <vector>

#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/raster/raster.hpp"

namespace sinew::plant {

/// Raster::shown() of a pixel: what it is of.
enum PitchThing : std::uint8_t {
  kShowsNothing = 0,
  kShowsCarpet = 1,
  kShowsLine = 2,
  kShowsGoal = 3,
  kShowsBall = 4,
  kShowsBoard = 5,
  kShowsWall = 6,
  kShowsRobot = 16,  // and its number
};

/// Everything moving, copied out of a pitch: another thread may draw while the pitch goes on.
struct PitchScene {
  struct Robot {
    std::array<kinematics::Pose, kinematics::kMaxLinks> link{};
  };
  std::vector<Robot> robots{};
  kinematics::Pose ball{};
  bool has_ball = true;

  /// Allocates only the first time.
  void take(const Pitch& pitch);
};

/// Meshes are built once; a picture allocates nothing after the first of its size.
/// Thread:  owner; several views may draw at once.
class PitchView {
 public:
  /// Bodies as given to Pitch::create().
  PitchView(const PitchOptions& options, std::span<const PitchBody> bodies);

  /// The body's places whose names begin with "camera", in the order of its file.
  std::size_t cameras(std::size_t robot) const { return robot_[robot].camera.size(); }
  const std::string& camera_name(std::size_t robot, std::size_t camera) const;
  /// Its pose is in the world, optical: x right, y down, z ahead. Focal length: PitchBody::focal_per_height.
  raster::Camera camera(const PitchScene& scene, std::size_t robot, std::size_t camera, std::uint32_t width,
                        std::uint32_t height) const;
  /// Through a robot's camera, or any other one.
  void draw(raster::Raster& picture, const PitchScene& scene, std::size_t robot, std::size_t camera) const;
  void draw(raster::Raster& picture, const PitchScene& scene, const raster::Camera& camera) const;

 private:
  struct Part {
    raster::Mesh mesh;
    raster::Colour colour;
    std::uint8_t shows = 0;
    bool on_surface = false;
  };
  struct LinkPart {
    std::size_t link = 0;
    raster::Mesh near, far;  // far: with fewer faces
    raster::Colour colour;
  };
  struct Robot {
    std::vector<LinkPart> parts{};
    std::vector<kinematics::Place> camera{};
    double radius_m = 0;  // of a sphere around link 0 that holds all of it in any posture
    double focal_per_height = 0.875;
  };
  std::vector<Part> still_{};
  std::vector<Part> ball_{};
  std::vector<Robot> robot_{};
};

/// A camera at `eye` that looks at `target`, upright; `focal_per_height` as a share of the picture's height.
raster::Camera camera_at(const math::Vec3& eye_m, const math::Vec3& target_m, std::uint32_t width, std::uint32_t height,
                         double focal_per_height = 0.875);

}  // namespace sinew::plant
