#pragma once
// The head looks where it is told to, however the body moves below it.
#include "motion/figure.hpp"
#include "motion/param.hpp"

namespace sinew::motion {

struct GazeParams {
  double lag_s = 0.08;
  double speed_radps = 4;
  double rate_smooth_s = 0.015;
  double camera_down_rad = 0;
};

inline constexpr Param<GazeParams> kGazeParams[] = {
    {"lag_s", &GazeParams::lag_s, "s", 0, 0.3, "from a target to the head's being there: that much is looked ahead"},
    {"speed_radps", &GazeParams::speed_radps, "rad/s", 0.1, 20, "fastest change of a target"},
    {"rate_smooth_s", &GazeParams::rate_smooth_s, "s", 0, 0.2, "low pass of the torso's rate"},
    {"camera_down_rad", &GazeParams::camera_down_rad, "rad", -1, 1,
     "how much further down the camera looks than its place in the body says"},
};

/// Pan and tilt that hold a direction or a point in view. The torso's attitude, advanced by its rate to the time at
/// which the head will be there, is taken out; the neck's place is the chain's. What two joints cannot do: the roll
/// about the direction of view. The camera is the first place on the head whose name begins with "camera"; without one
/// it is the head's own x. The head's axes are pan about z, then tilt about y, down positive; either may have a sign.
/// Frames:  world: z up, of the attitude that is given.
/// Thread:  owner.   RT: yes, after the constructor.
class Gaze {
 public:
  GazeParams params;

  explicit Gaze(const Figure& figure);

  /// Begins anew, from where the head is; what it looks at stays.
  void reset();

  /// `ahead_world`: a direction, of any length.
  void look_along(const math::Vec3& ahead_world);
  /// A point in the frame of the place that step() is given.
  void look_at(const math::Vec3& point_world_m);
  /// To angles of the neck, the torso's motion not taken out.
  void look_level();  // straight ahead of the torso, at the horizon

  /// `torso`: where link 0 is in the world, measured now; `joints_rad`: as measured. Writes the targets of pan and
  /// tilt.
  void step(const kinematics::Pose& torso, const math::Vec3& rate_radps, std::span<const double> joints_rad,
            double dt_s, std::span<double> targets_rad);
  /// The wanted direction is beyond what the neck can do.
  bool limited() const { return limited_; }
  /// Of the camera's axis from where it is to look, in the last step, as measured.
  double error_rad() const { return error_rad_; }
  /// State (kept_numbers.hpp): all that a step leaves for later ones.
  template <class Visit>
  void each_part(Visit&& visit) {
    visit(aim_, to_, rate_, set_rad_, begun_, limited_, error_rad_);
  }

 private:
  enum class Aim : std::uint8_t { level, direction, point };
  const Figure* figure_;
  kinematics::BodyPose pose_;
  kinematics::Pose camera_;  // in the head's link
  double own_down_rad_ = 0;  // of the camera when the head is level
  Aim aim_ = Aim::level;
  math::Vec3 to_{1, 0, 0};
  math::Vec3 rate_;
  std::array<double, 2> set_rad_{};
  bool begun_ = false, limited_ = false;
  double error_rad_ = 0;
};

}  // namespace sinew::motion
