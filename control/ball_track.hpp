#pragma once
#include "math/linear.hpp"
#include "msg/time.hpp"

namespace sinew::control {

struct BallTrackParams {
  double accel_radps2 = 3.0;  // of the ball's direction, 1 sigma: how fast its motion changes
  double noise_rad = 0.003;   // of a sighting, 1 sigma
  double gate = 25;           // largest squared normalised innovation
  std::int64_t refuse = 3;    // so many sightings in a row beyond the gate are another ball or a jump: begin anew
  /// After a longer time unseen, the change of place says little about the speed, and a wrong sighting would say much.
  double anew_s = 0.09;
  double settle_s = 0.4;   // time in which the speed fades once the ball is unseen for more than a moment
  std::int64_t below = 0;  // 1: the ball may pass straight below (a bool would leave padding in a state)
};

/// Azimuth and elevation of a ball in a level frame, with their speeds, each by a Kalman filter of constant velocity.
/// Sightings count for the instant at which they were taken. For a ball that may pass straight below, where there is no
/// azimuth, the same filter runs on the direction as a vector.
/// Frames:  level: z up; azimuth counter-clockwise, elevation up.
/// Source:  Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with Applications to Tracking and Navigation (2001),
///          section 6.3.2: discrete white noise acceleration.
/// Thread:  owner.   RT: yes.
class BallTrack {
 public:
  struct Aim {
    double azimuth_rad = 0, elevation_rad = 0, azimuth_radps = 0, elevation_radps = 0;
  };
  BallTrackParams params;

  void reset();
  /// False: refused, or not newer than the last one. `doubt_rad`: 1 sigma on top of the noise, for a ball that is half
  /// hidden.
  bool add(msg::Time stamp, const math::Vec3& direction_level, double doubt_rad = 0);
  bool exists() const { return exists_ != 0; }
  /// Instant of the newest sighting that was used.
  msg::Time stamp() const { return stamp_; }
  /// The aim expected at t; t is not before stamp().
  Aim at(msg::Time t) const;
  double innovation_rad() const { return innovation_rad_; }
  std::uint32_t used() const { return used_; }

 private:
  struct Axis {
    double x = 0, v = 0, xx = 0, xv = 0, vv = 0;
    void begin(double at, double noise);
    void predict(double dt, double accel);
    double normalised(double innovation, double noise) const;
    void update(double innovation, double noise);
  };
  void begin(msg::Time stamp, double azimuth, double elevation, double noise_rad);
  void begin_direction(msg::Time stamp, const math::Vec3& d, const math::Vec3& rate, double noise);
  bool add_direction(msg::Time stamp, const math::Vec3& d, double noise);
  static Aim aim_of(const math::Vec3& d, const math::Vec3& rate);
  double kept(double unseen_s) const;

  Axis azimuth_, elevation_;
  math::Vec3 direction_, rate_;  // with `below`; their covariance is azimuth_'s
  msg::Time stamp_;
  double innovation_rad_ = 0;
  std::int64_t refused_ = 0;
  std::uint32_t exists_ = 0, used_ = 0;
};

}  // namespace sinew::control
