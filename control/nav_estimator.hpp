#pragma once
#include "control/inertial_filter.hpp"
#include "control/outdoors.hpp"
#include "control/pose_history.hpp"
#include "control/rest_detector.hpp"
#include "msg/flight.hpp"
#include "msg/ground_motion.hpp"
#include "msg/sensors.hpp"

namespace sinew::control {

/// Numbers of the estimator; the module ErrorStateFilter gives each its unit and range.
struct NavParams {
  InertialNoise noise;
  InertialSpread spread;
  RestDetector::Params rest;
  double level_time_s = 0.25;  // accelerometer average for the first attitude
  double max_gap_s = 0.1;      // after a longer gap without samples it starts anew, keeping the biases
  // Without any aiding: the vehicle neither runs away nor accelerates for long.
  double level_rate_hz = 3.7, level_velocity_mps = 2.75;
  double level_accel_mps2 = 2.0, level_per_deviation = 1.3, level_per_rate = 0.7;
  double gate = 16;  // squared normalised innovation beyond which a measurement is refused
  double gyro_limit_radps = 40, accel_limit_mps2 = 200;  // more than the IMU can measure (2000 deg/s, 16 g): nonsense
  double range_min_m = 0.01, range_max_m = 20;           // likewise
  double range_noise_m = 0.01, range_noise_share = 0.01, range_below_base_m = 0.04;
  double baro_noise_m = 0.5, baro_offset_time_s = 5.0;
  double pad_noise_m = 0.01, pad_noise_share = 0.02;  // share: of the distance
  double pad_range_share = 0.1;  // of the distance by pad size: 5 %, 8 % where the image cuts it; an error that stays
  double pad_min_confidence = 0.5;
  math::Vec3 p_base_camera{0, 0, -0.04};
  math::Quat q_base_optical{0, 0.70710678118654752, -0.70710678118654752, 0};  // looks down, top of image forward
  double valid_tilt_rad = 0.09, valid_v_mps = 0.6, valid_p_m = 3.0, valid_height_age_s = 1.0;
  double range_lost_s = 0.3;  // after so long without a range that fits, barometer and pad size give the height
  OutdoorParams outdoors;
};

/// Attitude, velocity, position and biases from whatever sensors there are: inertial samples alone give the attitude;
/// range finder or barometer add height, sightings of the landing pad the horizontal position. Without a range finder
/// that fits, the size of the pad is the height above it: the barometer alone is off by half a metre within a minute.
/// Outdoors, from the first GNSS or magnetometer sample on, GNSS, magnetometer and the earth's field, optical motion
/// and the drag of the air come on top, and the fields of earth and body and the wind become states. Any of them can
/// come, go and return. Frames:  world z up; origin on the ground below the start, x as the vehicle looked then. The
/// pad does not move.
///          Outdoors x turns to the east as soon as a heading is known (NavReport: heading_valid).
/// A late sighting is compared with the pose of its own instant. The correction is applied to the present pose through
/// its velocity (p(then) = p - v * delay); the turn of the attitude error in between is neglected. For a late GNSS fix
/// it is not: dv(then) = dv + D x dtheta with D what the accelerometer added since then. Heading: the magnetometer
/// gives the first one, or the bank of filters on GNSS velocity once the vehicle has moved.
///          Later the magnetometer is one gated measurement among others: a turned field is refused as long as the
///          heading is surer than the turn. Where GNSS velocities are refused for a second and the bank is sure of
///          another heading, the bank's is taken, and the magnetometer is not used until it has agreed for five
///          seconds.
/// Jumps:   each one is announced with its size (take_report()).
/// Thread:  owner.   RT: yes.
class NavEstimator {
 public:
  struct Counters {
    std::uint32_t refused_imu = 0;  // not finite, beyond what an IMU measures, or older than the last
    std::uint32_t same_imu = 0;     // the same sample again
    std::uint32_t gaps = 0;         // starts anew after a gap
    std::uint32_t gated_range = 0, gated_pad = 0, gated_pad_size = 0, gated_baro = 0;
    std::uint32_t stuck_range = 0;        // the very same value for too long in flight
    std::uint32_t stuck_pad = 0;          // likewise the very same sighting: a frozen picture
    std::uint32_t late_pad = 0;           // older than the history
    std::uint32_t new_ground = 0;         // ground level taken anew after many refused ranges
    std::uint32_t reopened_height = 0;    // height and its speed taken anew: the ground moved again and again
    std::uint32_t reopened_position = 0;  // position taken anew after many refused sightings
  };

  NavParams params;

  void reset();
  /// False when the sample cannot be used (not finite, beyond what an IMU measures, older than the last one). A
  /// repeated sample is ignored and no error: a bus that repeats itself must not end a flight.
  bool add_imu(const msg::ImuSample& s);
  void add_range(const msg::RangeSample& s);
  void add_baro(const msg::BaroSample& s);
  void add_pad(const msg::PadSighting& s);
  /// Fixes of fewer than three dimensions, and less sure ones than gnss_worst_..., count as rejected.
  void add_gnss(const msg::GnssSample& s);
  void add_mag(const msg::MagSample& s);
  /// Velocity over ground divided by the height: needs a height.
  void add_motion(const msg::GroundMotion& s);
  static constexpr msg::Duration kReportEvery = std::chrono::milliseconds(100);
  /// True when a report is due: something jumped, or kReportEvery has gone by outdoors. Call it after the messages of a
  /// step.
  bool take_report(msg::NavReport& report);
  /// How well the forecasts fit the outdoor sources: mean of their newest test ratios; 0 while there are none.
  double fit() const;
  /// From now on this estimate is published in place of the other's: announces the difference.
  void announce_imu(std::uint32_t imu, const NavEstimator& before);
  /// What the last report said, and how sure the heading is: also between reports.
  const msg::NavReport& report() const { return out_.report; }
  double heading_std_rad() const;
  /// The estimate as it was (0.3 s at most), corrected by what is known now.
  std::optional<PoseHistory::Pose> pose_at(msg::Time t) const { return history_.at(t); }
  /// Where on the earth the world's origin is, once a fix came.
  const LocalFrame& frame() const { return out_.frame; }
  /// True: the motors are known to stand. Only then does rest mean zero velocity of an aided vehicle.
  void set_motors_stopped(bool stopped) { motors_stopped_ = stopped; }

  bool started() const { return started_; }
  /// The estimate at the last inertial sample; nothing useful before started().
  msg::NavState output() const;
  const InertialFilter& filter() const { return filter_; }
  const Counters& counters() const { return counters_; }

 private:
  void level(const math::Vec3& accel_mps2, msg::Time stamp);
  void use_rest();
  void use_prior(double dt_s);
  bool ground_seen() const;
  void use_pad_size(const msg::PadSighting& s, double camera_height_m, double down);
  void anchor_pad(const math::Vec3& seen);
  bool is_stuck(const msg::RangeSample& s);
  bool is_stuck(const msg::PadSighting& s);
  void refuse_range(msg::Time stamp, double height_m);
  void correct(std::span<const Measurement> rows, std::uint32_t* refused, double gate);
  Measurement gravity_row(int axis, const math::Vec3& f_world_mps2, double sigma) const;
  // nav_estimator_outdoors.cpp
  void go_outdoors();
  void restart_outdoors();
  void add_imu_outdoors(const math::Vec3& gyro_radps, const math::Vec3& accel_mps2, double dt_s);
  bool fuse(msg::NavSource source, std::span<const Measurement> rows);
  void reject(msg::NavSource source) { ++state_of(source).rejected; }
  msg::NavSourceState& state_of(msg::NavSource s) { return out_.report.source[static_cast<std::size_t>(s)]; }
  bool lost(msg::NavSource s, double after_s) const;
  void announce(msg::NavResetCause cause, double yaw_rad, const math::Vec3& dp, const math::Vec3& dv);
  void note_step(const InertialState& before, msg::NavSource source);
  void align_heading(double turn_rad, double sigma_rad, msg::NavResetCause cause);
  void first_heading_by_mag();
  bool mag_unusable() const;
  void note_motion(const math::Vec3& v_mps, double v_sigma);
  bool is_carried() const;  // quiet inertial samples are no rest: satellites say that it moves
  void use_fix(const msg::GnssSample& s, msg::Time stamp);
  void use_fix_height(const msg::GnssSample& s, const math::Vec3& p_world_m, const PoseHistory::Pose& then);
  bool take_bank_heading(const math::Vec3& v_mps, const math::Vec3& p_m, double v_sigma, double p_sigma);
  void restart_horizontal(const math::Vec3& p_m, double p_sigma, const math::Vec3& v_mps, double v_sigma);
  void use_drag();
  Measurement velocity_row(int axis, const PoseHistory::Pose& then, const math::Vec3& arm_rate) const;
  Measurement position_row(int axis, const PoseHistory::Pose& then, const math::Vec3& arm) const;
  std::array<Measurement, 3> field_rows(const math::Vec3& field_t, const math::Quat& q) const;

  InertialFilter filter_;
  PoseHistory history_;
  RestDetector rest_;
  Counters counters_;
  bool started_ = false, height_aided_ = false, motors_stopped_ = true, pad_known_ = false;
  msg::Time last_imu_, last_range_, pad_stamp_;
  math::Vec3 gyro_radps_;
  math::Vec3 level_sum_, prior_f_sum_;
  double level_count_ = 0, level_span_s_ = 0, prior_span_s_ = 0, prior_count_ = 0, prior_rate_ = 0;
  double ground_z_m_ = 0;
  double baro_offset_m_ = 0;
  msg::Time last_baro_;
  math::Vec3 pad_world_m_;
  std::uint32_t pad_sightings_ = 0, pad_refused_in_row_ = 0, range_refused_in_row_ = 0;
  std::uint32_t baro_known_ = 0;  // a bool would leave padding in a state
  double refused_height_m_ = 0;   // the first refused height of that row
  msg::Time last_ground_, ground_before_last_;
  double last_range_m_ = 0;
  msg::Time range_changed_;
  msg::Vec3 last_pad_direction_;
  msg::Time pad_changed_;
  OutdoorState out_;
};

}  // namespace sinew::control
