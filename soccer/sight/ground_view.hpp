#pragma once
// The ground as a camera sees it: from pixels to places on the ground and back, and how sure such a place is.
// Frames:  "robot" of msg/soccer.hpp: on the ground below the torso, x ahead, y left, z up.
// Thread:  any.   RT: yes.
#include <optional>

#include "math/linear.hpp"
#include "msg/camera_pose.hpp"
#include "msg/soccer.hpp"
#include "vision/pinhole.hpp"

namespace sinew::soccer {

struct GroundXy {
  double x_m = 0, y_m = 0;
};

struct PixelAt {
  double u_px = 0, v_px = 0;
  double depth_m = 0;  // along the camera's axis; not positive: behind the camera, and u, v mean nothing
};

/// Where the frame "robot" is in the odometry's frame.
struct RobotAt {
  double x_m = 0, y_m = 0, heading_rad = 0;
};

/// Standard deviations of what a camera's pose and an edge in its picture are wrong by.
struct ViewErrors {
  /// Of the chain from the ground to the camera: play of gears, the IMU's pitch, the mount. Across the line of sight.
  double tilt_rad = 0.017;
  double heading_rad = 0.012;  // of the camera against the frame "robot"
  double pixel_px = 0.8;
};

class GroundView {
 public:
  GroundView(const vision::Pinhole& camera, const msg::CameraPose& pose, const RobotAt& robot,
             const ViewErrors& errors);

  /// Of the camera over the ground.
  double height_m() const { return at_.z; }
  const math::Vec3& camera_m() const { return at_; }
  const vision::Pinhole& camera() const { return camera_; }

  /// The place at this height over the ground that a pixel shows. None: the ray does not come down to it, or only
  /// beyond `kFarthest_m` from the camera.
  std::optional<GroundXy> at_height(double u_px, double v_px, double z_m) const;
  std::optional<GroundXy> ground(double u_px, double v_px) const { return at_height(u_px, v_px, 0); }
  PixelAt pixel(const math::Vec3& p_robot_m) const;
  PixelAt pixel(const GroundXy& p) const { return pixel({p.x_m, p.y_m, 0}); }

  /// The row of the horizon in this column; what shows the ground is below it. Only if is_upright().
  double horizon_px(double u_px) const;
  /// The picture's rows go downwards in the world, so that scans of columns meet the horizon first: it looks down by at
  /// most 81 degrees and is rolled by at most 37. False also where the camera is not above the ground, or a number is
  /// none.
  bool is_upright() const { return upright_; }

  /// The radius in the picture of a ball of this radius whose centre the pixel shows and that lies on the ground.
  /// None: as at_height().
  std::optional<double> ball_radius_px(double u_px, double v_px, double radius_m) const;

  /// Of a place that a pixel showed, known to `pixel_px` there.
  /// Source:  derivation: a ray that meets the plane at distance d below the camera's height h moves by
  ///          (d^2 + h^2) / h for each radian of tilt along the line of sight, and by sqrt(d^2 + h^2) across it.
  msg::GroundPoint with_covariance(const GroundXy& p, double pixel_px, double z_m = 0) const;
  msg::GroundPoint with_covariance(const GroundXy& p) const { return with_covariance(p, errors_.pixel_px); }
  const ViewErrors& errors() const { return errors_; }

  static constexpr double kFarthest_m = 14;

 private:
  vision::Pinhole camera_;
  ViewErrors errors_;
  math::Mat3 turn_;  // camera_optical to robot
  math::Vec3 at_;
  bool upright_ = false;
};

}  // namespace sinew::soccer
