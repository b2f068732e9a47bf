#pragma once
#include <array>

#include "control/ball_track.hpp"
#include "control/pose_history.hpp"
#include "math/linear.hpp"
#include "msg/flight.hpp"
#include "msg/head.hpp"
#include "msg/joints.hpp"
#include "msg/safety.hpp"

namespace sinew::control {

/// Numbers of a pan/tilt head; the module HeadFollower gives each its range.
struct HeadParams {
  double pan_least_rad = -1.35, pan_most_rad = 1.35, tilt_least_rad = -0.95, tilt_most_rad = 0.85;
  double speed_radps = 5.0;                         // largest change of a setpoint
  double lag_s = 0.042;                             // of a servo behind a setpoint that moves, its bus included
  double rate_smooth_s = 0.015;                     // of the base's angular rate
  double coast_s = 3.0;                             // unseen for longer: search
  double blind_s = 0.3;                             // no picture for longer: hold
  double scan_radps = 0.7, scan_reach_rad = 0.8;    // of the search: speed, and how far to both sides at most
  double view_rad = 0.55;                           // half the picture's width, with the whole ball in it
  double scan_elevation_rad = 0;                    // where it looks when it sweeps all that it may see
  double turn_radps = 2.0;                          // of the aim, when it does not follow the ball
  double joints_lag_s = 0;                          // not 0: joints that tell where they are only now and then
  std::int64_t imu_on_base = 0;                     // 1: the estimate is that of the base, not of the head
  math::Quat q_head_optical{0.5, -0.5, 0.5, -0.5};  // optical frame to head: z to x, x to -y, y to -z
};

/// Keeps a camera on two joints level, and looks where a ball is.
///
/// With the IMU on the head the estimate gives the head's attitude, and the joints' positions then the base's; with the
/// IMU on the base it is the other way round, and whatever rate the estimate comes at, the head's attitude is known for
/// each step. Joints that do not tell their speeds have those of their last two positions; with `joints_lag_s`
/// they are taken to follow their setpoints, and what they tell now and then corrects that. The wanted direction is
/// given in a level frame (azimuth and elevation). Seen from the base as it will be one servo lag ahead, this direction
/// gives pan and tilt: the base's pitch and yaw are taken out, whatever their cause. Two joints cannot take out the
/// roll about the direction in which they look: the picture's horizon leans as the base does across it.
///
/// A ball that is lost within the picture is behind something, and comes out beside it: where it went in, or where its
/// speed was taking it. The search swings about the middle of these two places, for some seconds so little that both
/// stay well within the picture, then wider by half a picture each time, until it sweeps all that the head may see.
///
/// A head whose tilt goes past straight down may have the ball pass below it: pan then turns no faster than it can, and
/// tilt takes the ball into the picture from there, also beyond the vertical. Nothing flips round.
/// Frames:  head: x the way it looks, y left, z up at joint angles 0, as base; pan about z, then tilt about y (down is
///          positive). Level frame: the estimate's world.
/// Thread:  owner.   RT: yes.
class HeadLaw {
 public:
  HeadParams params;
  BallTrack track;

  void reset();
  /// A sighting is used with the attitude at its stamp; a sighting from before the history of 0.3 s is not used.
  void add(const msg::BallSighting& sighting);
  void set_safety(const msg::SafetyState& safety);
  /// Pan and tilt wanted at `now`. Inputs are fresh.
  void step(msg::Time now, const msg::NavState& nav, const msg::JointState& joints, double dt_s);
  const std::array<double, 2>& setpoint_rad() const { return setpoint_; }
  bool armed() const { return armed_ != 0; }
  const msg::HeadState& state() const { return state_; }

 private:
  struct Aim {
    double azimuth_rad = 0, elevation_rad = 0;
  };
  void choose_mode(msg::Time now);
  void enter(msg::HeadMode mode, msg::Time now);
  void move_aim(msg::Time at, double forward_rad, double dt_s);
  void begin_search(msg::Time now);
  void search(double forward_rad, double dt_s);
  struct Pose {
    math::Quat q_level_base, q_level_head;
    math::Vec3 base_rate_radps;  // base
    double pan_rad = 0, tilt_rad = 0;
  };
  Pose pose_by_head(const msg::NavState& nav, const msg::JointState& joints) const;
  Pose pose_by_base(msg::Time now, const msg::NavState& nav, const msg::JointState& joints) const;
  void take_joints(const msg::JointState& joints, double dt_s);
  void model_joints(const msg::JointState& joints, double dt_s);
  void point(const math::Quat& q_level_base, double dt_s);

  PoseHistory history_;
  msg::HeadState state_;
  Aim aim_;
  std::array<double, 2> setpoint_{};
  math::Vec3 base_rate_radps_;
  std::array<double, 2> joint_rad_{}, joint_radps_{};  // of the newest joints
  msg::Time joint_stamp_;
  msg::Time last_picture_;
  Aim scan_centre_;
  double scan_side_ = 1, scan_swing_ = 0;  // the side it turns to; how far from the centre it turns round
  msg::FailsafeAction action_ = msg::FailsafeAction::none;
  std::uint32_t permitted_ = 1, armed_ = 0;
  std::uint32_t scan_turns_ = 0;
};

}  // namespace sinew::control
