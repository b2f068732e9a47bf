// NavEstimator's part for GNSS, magnetometer, optical motion and drag.
#include "control/limits.hpp"
#include "control/nav_estimator.hpp"

namespace sinew::control {
namespace {

using msg::NavResetCause;
using msg::NavSource;

// A vehicle that is carried: the mean of its fixes is faster than a receiver's noise, each fix counting so much.
constexpr double kMotion_mps = 0.2, kMotionShare = 0.3, kMotionFor_s = 1;
constexpr double kLargeStep_m = 0.5, kLargeStep_mps = 0.5, kLargeStep_rad = 0.1;
constexpr double kFirstMag_s = 0.3;         // averaged for the first heading
constexpr double kStrangeField = 0.35;      // of the model's strength: iron nearby, no first heading from it
constexpr double kStrangeDip_rad = 0.35;    // likewise
constexpr double kLinearHeading_rad = 0.5;  // one sigma that a linear correction still stands
constexpr double kMagAgreesFor_s = 5;       // until a refused magnetometer is used again
constexpr double kDragEvery_s = 0.1;
constexpr double kLeastHeight_m = 0.3;                    // for optical motion
constexpr double kNothingKnown_rad = 1.8137993642342178;  // pi / sqrt(3): any heading

double larger(double a, double b) { return b > a ? b : a; }  // also for an unknown (NaN) b

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool is_fix(const msg::GnssSample& s) {
  return (s.fix == msg::GnssFix::full || s.fix == msg::GnssFix::rtk_float || s.fix == msg::GnssFix::rtk_fixed) &&
         math::fabs(s.latitude_deg) < 89.9 && math::fabs(s.longitude_deg) <= 360 && math::fabs(s.altitude_m) < 1e5;
}

}  // namespace

/// Called for the first sample of an outdoor sensor, and after each new start of the inertial filter.
void NavEstimator::go_outdoors() {
  const OutdoorParams& p = params.outdoors;
  if (out_.active == 0) {
    out_.report.origin_latitude_deg = out_.report.origin_longitude_deg = math::kNan;
    out_.report.heading_std_rad = out_.report.bank_heading_std_rad = kNothingKnown_rad;
  }
  out_.active = 1;
  if (!started_ && filter_.covariance().has_surroundings()) return;
  InertialState fields = filter_.state();
  filter_.open_surroundings(fields, p.mag_earth_field_t, p.mag_body_field_t, p.wind_mps);
}

/// After a gap in the inertial samples: the axes and the place of the world are new ones.
void NavEstimator::restart_outdoors() {
  out_.frame = {};
  out_.bank.reset();
  out_.pull.reset();
  out_.heading_valid = out_.heading_without_place = out_.fresh_start = out_.model_known = 0;
  out_.mag_sum_t = {};
  out_.mag_count = 0;
  out_.report.heading_valid = 0;
}

bool NavEstimator::lost(NavSource s, double after_s) const {
  return msg::seconds(last_imu_ - out_.report.source[static_cast<std::size_t>(s)].last_fused) > after_s;
}

double NavEstimator::heading_std_rad() const {
  return out_.active != 0 && out_.heading_valid == 0 ? kNothingKnown_rad
                                                     : math::sqrt(filter_.covariance().variance(kErrTheta + 2));
}

void NavEstimator::announce(NavResetCause cause, double yaw_rad, const math::Vec3& dp, const math::Vec3& dv) {
  if (out_.active == 0 && cause != NavResetCause::imu_change) return;
  msg::NavReport& r = out_.report;
  const bool more = out_.report_due != 0;  // several in one step add up
  r.reset_yaw_rad = math::wrap_pi(yaw_rad + (more ? r.reset_yaw_rad : 0));
  r.reset_p_world_m = (dp + (more ? math::Vec3(r.reset_p_world_m) : math::Vec3{})).to<msg::Vec3>();
  r.reset_v_world_mps = (dv + (more ? math::Vec3(r.reset_v_world_mps) : math::Vec3{})).to<msg::Vec3>();
  if (!more || r.reset_cause == NavResetCause::large_step) r.reset_cause = cause;
  ++r.resets;
  out_.report_due = 1;
}

double NavEstimator::fit() const {
  double sum = 0, count = 0;
  for (const msg::NavSourceState& s : out_.report.source) {
    if (s.last_fused.ns == 0 || msg::seconds(last_imu_ - s.last_fused) > 10) continue;
    sum += s.test_ratio;
    count += 1;
  }
  return count > 0 ? sum / count : 0;
}

void NavEstimator::announce_imu(std::uint32_t imu, const NavEstimator& before) {
  const InertialState &now = filter_.state(), &old = before.filter_.state();
  // Its own jumps before were never published; one of the other in this same step was neither, and is a part of this
  // one.
  const msg::NavReport& r = before.out_.report;
  out_.report_due = before.out_.report_due;
  out_.report.reset_yaw_rad = r.reset_yaw_rad;
  out_.report.reset_p_world_m = r.reset_p_world_m;
  out_.report.reset_v_world_mps = r.reset_v_world_mps;
  out_.report.resets = r.resets;
  out_.report.imu = imu;
  out_.report.reset_cause = NavResetCause::large_step;  // gives way
  announce(NavResetCause::imu_change, (now.q_world_base * old.q_world_base.conjugate()).log().z,
           now.p_world_m - old.p_world_m, now.v_world_mps - old.v_world_mps);
}

/// An ordinary correction that is as large as a reset is announced as one.
void NavEstimator::note_step(const InertialState& before, NavSource source) {
  const InertialState& x = filter_.state();
  const math::Vec3 dp = x.p_world_m - before.p_world_m, dv = x.v_world_mps - before.v_world_mps;
  const double yaw = (x.q_world_base * before.q_world_base.conjugate()).log().z;
  if (norm(dp) < kLargeStep_m && norm(dv) < kLargeStep_mps && math::fabs(yaw) < kLargeStep_rad) return;
  const bool fix = source == NavSource::gnss_position || source == NavSource::gnss_velocity;
  announce(fix && lost(source, params.outdoors.gnss_lost_s) ? NavResetCause::gnss_return : NavResetCause::large_step,
           yaw, dp, dv);
}

/// All rows of one measurement, or none of them.
bool NavEstimator::fuse(NavSource source, std::span<const Measurement> rows) {
  msg::NavSourceState& s = state_of(source);
  s.test_ratio = 0;
  ErrorVector gain;
  for (const Measurement& m : rows) {
    const double variance = filter_.covariance().innovation(m, gain);
    const double ratio = m.residual * m.residual / (variance * params.gate);
    if (!(ratio <= s.test_ratio)) s.test_ratio = ratio;
  }
  if (!(s.test_ratio <= 1)) {
    ++s.rejected;
    return false;
  }
  const InertialState before = filter_.state();
  correct(rows, nullptr, kNoGate);
  note_step(before, source);
  ++s.fused;
  s.last_fused = last_imu_;
  return true;
}

void NavEstimator::add_imu_outdoors(const math::Vec3& gyro, const math::Vec3& accel, double dt_s) {
  const InertialState& x = filter_.state();
  out_.bank.add_imu(last_imu_, gyro - x.gyro_bias_radps, accel - x.accel_bias_mps2, dt_s);
  if (params.outdoors.drag_per_s <= 0 || motors_stopped_ || out_.heading_valid == 0) return;
  out_.drag_sum_mps2 += accel;
  out_.drag_count += 1;
  out_.drag_span_s += dt_s;
  if (out_.drag_span_s >= kDragEvery_s) use_drag();
}

/// The force across the rotors' axis is the drag of the air that blows through them: f = -c (v - wind), base x and y.
/// Source:  P. Martin and E. Salaun, The true role of accelerometer feedback in quadrotor control, ICRA 2010.
void NavEstimator::use_drag() {
  const double c = params.outdoors.drag_per_s;
  const InertialState& x = filter_.state();
  const math::Mat3 r = x.q_world_base.matrix();
  const math::Vec3 f = out_.drag_sum_mps2 / out_.drag_count - x.accel_bias_mps2;
  const math::Vec3 air = x.v_world_mps - x.wind_world_mps, air_base = x.q_world_base.conjugate().rotate(air);
  out_.drag_sum_mps2 = {};
  out_.drag_count = out_.drag_span_s = 0;
  std::array<Measurement, 2> rows;
  const math::Mat3 cross_air = math::skew(air);
  for (int i = 0; i < 2; ++i) {
    Measurement& m = rows[at(i)];
    for (int k = 0; k < 3; ++k) {
      m.add(kErrV + k, -c * r(k, i));
      double turn = 0;  // d(R^T u) = R^T (u x dtheta)
      for (int j = 0; j < 3; ++j) turn += r(j, i) * cross_air(j, k);
      m.add(kErrTheta + k, -c * turn);
    }
    for (int k = 0; k < 2; ++k) m.add(kErrWind + k, c * r(k, i));
    m.add(kErrAccelBias + i, 1);
    m.residual = f[i] + c * air_base[i];
    m.variance = square(params.outdoors.drag_noise_mps2);
  }
  fuse(NavSource::drag, rows);
}

// ---- GNSS ----------------------------------------------------------------------------------------------------------

/// With D and S, what the specific force added to velocity and position between `then` and now:
///   dv(then) = dv + D x dtheta + dt R da,   dp(then) = dp - dt dv - dt D x dtheta + S x dtheta.
/// `arm_rate`: velocity of the antenna around the IMU, world, then.
Measurement NavEstimator::velocity_row(int axis, const PoseHistory::Pose& then, const math::Vec3& arm_rate) const {
  const InertialState& x = filter_.state();
  const double dt_s = msg::seconds(last_imu_ - then.stamp);
  const math::Vec3 d = x.v_world_mps - then.v_world_mps + math::Vec3{0, 0, kGravity * dt_s};
  const math::Mat3 turn = math::skew(d - arm_rate), r = x.q_world_base.matrix();
  Measurement m;
  m.add(kErrV + axis, 1);
  for (int k = 0; k < 3; ++k)
    if (k != axis) m.add(kErrTheta + k, turn(axis, k));
  for (int k = 0; k < 3; ++k) m.add(kErrAccelBias + k, dt_s * r(axis, k));
  return m;
}

Measurement NavEstimator::position_row(int axis, const PoseHistory::Pose& then, const math::Vec3& arm) const {
  const InertialState& x = filter_.state();
  const double dt_s = msg::seconds(last_imu_ - then.stamp);
  const math::Vec3 d = x.v_world_mps - then.v_world_mps + math::Vec3{0, 0, kGravity * dt_s};
  const math::Vec3 s =
      x.p_world_m - then.p_world_m - then.v_world_mps * dt_s + math::Vec3{0, 0, 0.5 * kGravity * dt_s * dt_s};
  const math::Mat3 turn = math::skew(s - d * dt_s - arm);
  Measurement m;
  m.add(kErrP + axis, 1);
  m.add(kErrV + axis, -dt_s);
  for (int k = 0; k < 3; ++k)
    if (k != axis) m.add(kErrTheta + k, turn(axis, k));
  return m;
}

void NavEstimator::add_gnss(const msg::GnssSample& s) {
  if (!started_) return;
  if (out_.active == 0) go_outdoors();
  const OutdoorParams& p = params.outdoors;
  if (!is_fix(s) || s.horizontal_accuracy_m > p.gnss_worst_m || s.speed_accuracy_mps > p.gnss_worst_mps) {
    reject(NavSource::gnss_position);
    reject(NavSource::gnss_velocity);
    return;
  }
  use_fix(s, s.stamp - msg::Duration{static_cast<std::int64_t>(p.gnss_delay_s * 1e9)});
}

void NavEstimator::use_fix(const msg::GnssSample& s, msg::Time stamp) {
  const OutdoorParams& p = params.outdoors;
  const std::optional<PoseHistory::Pose> then = history_.at(stamp);
  if (!then) return reject(NavSource::gnss_position);  // older than the history
  const GeodeticPoint place{s.latitude_deg, s.longitude_deg, s.altitude_m};
  const math::Vec3 arm_base = p.p_base_antenna - p.p_base_imu, arm = then->q_world_base.rotate(arm_base);
  if (!out_.frame.known()) {
    out_.frame.set(place, then->p_world_m + arm);
    const GeodeticPoint origin = out_.frame.origin();
    out_.report.origin_latitude_deg = origin.latitude_deg;
    out_.report.origin_longitude_deg = origin.longitude_deg;
    out_.report.origin_altitude_m = origin.height_m;
    if (const auto field = earth_field_t(place, p.date_year)) {
      out_.earth_model_t = *field;
      out_.model_known = 1;
    }
    out_.report.field_model_expired = magnetic_model_expired(p.date_year);
    if (out_.heading_without_place != 0 && out_.model_known != 0) {
      const double turn = math::wrap_pi(-declination_rad(out_.earth_model_t) + p.declination_rad);
      align_heading(turn, heading_std_rad(), NavResetCause::declination);
      filter_.reset_earth_field(out_.earth_model_t, p.mag_earth_field_t);
      out_.heading_without_place = 0;
    }
  }
  const double v_sigma = larger(p.gnss_velocity_mps, s.speed_accuracy_mps);
  const double p_sigma = larger(p.gnss_position_m, s.horizontal_accuracy_m);
  const math::Vec3 v_gnss(s.velocity_mps), p_gnss = out_.frame.to_world(place);
  const bool has_velocity = is_finite(v_gnss);
  if (has_velocity) {
    note_motion(v_gnss, v_sigma);
    out_.bank.add_velocity(stamp, v_gnss.x, v_gnss.y, v_sigma);
    out_.report.gnss_pulled = out_.pull.add(stamp, p_gnss, v_gnss, p_sigma, v_sigma);
  }
  use_fix_height(s, p_gnss, *then);
  if (out_.heading_valid == 0) {
    if (has_velocity && out_.bank.std_rad() < p.bank_most_std_rad && mag_unusable()) {
      align_heading(math::wrap_pi(out_.bank.heading_rad() - filter_.state().q_world_base.yaw()), out_.bank.std_rad(),
                    NavResetCause::first_heading);
      ++state_of(NavSource::heading_bank).fused;
      state_of(NavSource::heading_bank).last_fused = last_imu_;
      restart_horizontal(out_.frame.to_world(place), p_sigma, v_gnss, v_sigma);
    }
    return;
  }
  const math::Vec3 rate = gyro_radps_ - filter_.state().gyro_bias_radps;
  const math::Vec3 arm_rate = then->q_world_base.rotate(cross(rate, arm_base));
  if (out_.fresh_start != 0 && has_velocity) {
    out_.fresh_start = 0;
    restart_horizontal(p_gnss, p_sigma, v_gnss, v_sigma);
    return;
  }
  bool velocity_fits = false;
  if (has_velocity) {
    std::array<Measurement, 3> rows;
    const math::Vec3 residual = v_gnss - then->v_world_mps - arm_rate;
    for (int i = 0; i < 3; ++i) {
      rows[at(i)] = velocity_row(i, *then, arm_rate);
      rows[at(i)].residual = residual[i];
      rows[at(i)].variance = square(i < 2 ? v_sigma : 1.5 * v_sigma);
    }
    velocity_fits = fuse(NavSource::gnss_velocity, rows);
  }
  if (has_velocity && !velocity_fits) {
    if (take_bank_heading(v_gnss, p_gnss, v_sigma, p_sigma)) return;
    if (lost(NavSource::gnss_velocity, p.gnss_lost_s)) {
      restart_horizontal(p_gnss, p_sigma, v_gnss, v_sigma);
      return;
    }
  }
  if (out_.pull.pulled()) return reject(NavSource::gnss_position);
  const std::optional<PoseHistory::Pose> still = history_.at(stamp);  // corrected by the velocity
  std::array<Measurement, 2> rows;
  const math::Vec3 residual = p_gnss - still->p_world_m - arm;
  for (int i = 0; i < 2; ++i) {
    rows[at(i)] = position_row(i, *still, arm);
    rows[at(i)].residual = residual[i];
    rows[at(i)].variance = square(p_sigma);
  }
  if (!fuse(NavSource::gnss_position, rows) && lost(NavSource::gnss_position, p.gnss_lost_s)) {
    math::Vec3 dp{residual.x, residual.y, 0};
    for (int i = 0; i < 2; ++i) filter_.reset_position(i, filter_.state().p_world_m[i] + dp[i], square(p_sigma));
    history_.correct(last_imu_, dp, {}, {});
    ++state_of(NavSource::gnss_position).fused;
    state_of(NavSource::gnss_position).last_fused = last_imu_;
    announce(NavResetCause::gnss_return, 0, dp, {});
  }
}

void NavEstimator::note_motion(const math::Vec3& v_mps, double v_sigma) {
  out_.mean_fix_mps += (v_mps - out_.mean_fix_mps) * kMotionShare;
  if (norm(out_.mean_fix_mps) > kMotion_mps + v_sigma) out_.last_motion = last_imu_;
}

bool NavEstimator::is_carried() const {
  if (out_.last_motion.ns != 0 && msg::seconds(last_imu_ - out_.last_motion) < kMotionFor_s) return true;
  if (out_.active == 0 || lost(NavSource::gnss_velocity, kMotionFor_s)) return false;
  const math::Vec3& v = filter_.state().v_world_mps;
  const Covariance& p = filter_.covariance();
  return norm(v) > kMotion_mps + 3 * math::sqrt(p.variance(kErrV) + p.variance(kErrV + 1) + p.variance(kErrV + 2));
}

/// Without a magnetometer that could give the first heading, or with one that came long ago and could not.
bool NavEstimator::mag_unusable() const {
  return out_.mag_count == 0 || msg::seconds(last_imu_ - out_.first_mag) > params.outdoors.mag_wait_s;
}

void NavEstimator::use_fix_height(const msg::GnssSample& s, const math::Vec3& p_gnss, const PoseHistory::Pose& then) {
  const OutdoorParams& p = params.outdoors;
  height_aided_ = true;
  const math::Vec3 arm = then.q_world_base.rotate(p.p_base_antenna - p.p_base_imu);
  std::array<Measurement, 1> row{position_row(2, then, arm)};
  row[0].residual = p_gnss.z - then.p_world_m.z - arm.z;
  row[0].variance = square(larger(p.gnss_height_m, s.vertical_accuracy_m));
  const double since_s = msg::seconds(last_imu_ - out_.last_height);
  out_.last_height = last_imu_;
  if (baro_known_ != 0 && since_s < 1) baro_offset_m_ -= since_s / (p.baro_gnss_time_s + since_s) * row[0].residual;
  if (fuse(NavSource::gnss_height, row) || !lost(NavSource::gnss_height, p.gnss_lost_s)) return;
  const double dz = row[0].residual;
  filter_.reset_position(2, filter_.state().p_world_m.z + dz, row[0].variance);
  filter_.reopen_velocity(2, 1.0);
  history_.correct(last_imu_, {0, 0, dz}, {}, {});
  baro_offset_m_ -= dz;
  ground_z_m_ += dz;
  state_of(NavSource::gnss_height).last_fused = last_imu_;
  announce(NavResetCause::gnss_return, 0, {0, 0, dz}, {});
}

/// A wrong heading turns each acceleration into a wrong velocity: GNSS velocities are refused, and the bank, which asks
/// nobody, says another heading. Taken only if the bank itself is sure, and surer than the difference is large.
bool NavEstimator::take_bank_heading(const math::Vec3& v, const math::Vec3& p_m, double v_sigma, double p_sigma) {
  const OutdoorParams& p = params.outdoors;
  const double std_rad = out_.bank.std_rad();
  const double turn = math::wrap_pi(out_.bank.heading_rad() - filter_.state().q_world_base.yaw());
  if (!lost(NavSource::gnss_velocity, p.bank_after_s) || !(std_rad < p.bank_most_std_rad) ||
      math::fabs(turn) < p.bank_least_turn_rad || math::fabs(turn) < 3 * std_rad) {
    return false;
  }
  filter_.reset_yaw(turn, square(std_rad));
  history_.clear();
  const InertialState& x = filter_.state();
  history_.add({last_imu_, x.p_world_m, x.q_world_base, x.v_world_mps});
  filter_.reset_body_field({}, p.mag_body_field_t);
  out_.report.mag_refused = 1;
  out_.mag_agrees_since = last_imu_;
  ++state_of(NavSource::heading_bank).fused;
  state_of(NavSource::heading_bank).last_fused = last_imu_;
  announce(NavResetCause::heading, turn, {}, {});
  restart_horizontal(p_m, p_sigma, v, v_sigma);
  return true;
}

/// Position and velocity from one fix: carried on to now by the velocity, which a fix of some tenths of a second ago
/// leaves uncertain by what the vehicle accelerated since.
void NavEstimator::restart_horizontal(const math::Vec3& p_m, double p_sigma, const math::Vec3& v, double v_sigma) {
  const InertialState before = filter_.state();
  const double delay_s = params.outdoors.gnss_delay_s;
  for (int i = 0; i < 2; ++i) {
    filter_.reset_velocity(i, v[i], square(v_sigma + 2 * delay_s));
    filter_.reset_position(i, p_m[i] + v[i] * delay_s, square(p_sigma + 2 * v_sigma * delay_s));
  }
  const math::Vec3 dp = filter_.state().p_world_m - before.p_world_m;
  const math::Vec3 dv = filter_.state().v_world_mps - before.v_world_mps;
  history_.correct(last_imu_, dp, dv, {});
  for (const NavSource s : {NavSource::gnss_position, NavSource::gnss_velocity}) {
    ++state_of(s).fused;
    state_of(s).last_fused = last_imu_;
  }
  announce(NavResetCause::gnss_return, 0, dp, dv);
}

// ---- magnetometer --------------------------------------------------------------------------------------------------

/// Turns the world so that x is east. What was known about position and velocity is known in the new axes, too.
void NavEstimator::align_heading(double turn_rad, double sigma_rad, NavResetCause cause) {
  filter_.turn_world(turn_rad);
  history_.turn_world(turn_rad);
  out_.frame.turn_world(turn_rad);
  pad_world_m_ = math::Quat::from_axis_angle({0, 0, 1}, turn_rad).rotate(pad_world_m_);
  filter_.reset_yaw(0, square(sigma_rad));
  out_.pull.reset();
  out_.heading_valid = 1;
  out_.fresh_start = cause == NavResetCause::first_heading && out_.frame.known() && !rest_.at_rest();
  announce(cause, turn_rad, {}, {});
}

std::array<Measurement, 3> NavEstimator::field_rows(const math::Vec3& field_t, const math::Quat& q) const {
  const InertialState& x = filter_.state();
  const math::Mat3 r = q.matrix(), turn = math::skew(x.earth_field_t);
  const math::Vec3 expected = q.conjugate().rotate(x.earth_field_t) + x.body_field_t;
  std::array<Measurement, 3> rows;
  for (int i = 0; i < 3; ++i) {
    Measurement& m = rows[at(i)];
    for (int k = 0; k < 3; ++k) {
      double c = 0;  // d(R^T B) = R^T (B x dtheta)
      for (int j = 0; j < 3; ++j) c += r(j, i) * turn(j, k);
      m.add(kErrTheta + k, c);
      m.add(kErrEarthField + k, r(k, i));
    }
    m.add(kErrBodyField + i, 1);
    m.residual = field_t[i] - expected[i];
    m.variance = square(params.outdoors.mag_noise_t);
  }
  return rows;
}

void NavEstimator::add_mag(const msg::MagSample& s) {
  const OutdoorParams& p = params.outdoors;
  const math::Vec3 field = p.mag_soft * (math::Vec3(s.field_t) - p.mag_hard_t);
  const double strength = norm(field);
  if (!started_) return;
  if (!(strength > 1e-6) || !(strength < 1e-3)) return reject(NavSource::mag);  // nobody on earth reads this
  if (out_.active == 0) go_outdoors();
  const auto then = history_.at(s.stamp - msg::Duration{static_cast<std::int64_t>(p.mag_delay_s * 1e9)});
  if (!then) return reject(NavSource::mag);
  if (out_.heading_valid == 0) {
    if (out_.mag_count == 0) out_.first_mag = s.stamp;
    out_.mag_sum_t += then->q_world_base.rotate(field);
    out_.mag_count += 1;
    if (msg::seconds(s.stamp - out_.first_mag) >= kFirstMag_s) first_heading_by_mag();
    return;
  }
  std::array<Measurement, 3> rows = field_rows(field, then->q_world_base);
  std::span<Measurement> used(rows);
  if (p.mag_heading_only != 0) {
    const math::Vec3 world = then->q_world_base.rotate(field);
    const double horizontal2 = world.x * world.x + world.y * world.y;
    if (!(horizontal2 > square(2 * p.mag_noise_t))) return reject(NavSource::mag);
    rows[0] = {};
    rows[0].add(kErrTheta + 2, 1);
    rows[0].add(kErrTheta + 0, -world.x * world.z / horizontal2);
    rows[0].add(kErrTheta + 1, -world.y * world.z / horizontal2);
    const math::Vec3& earth = filter_.state().earth_field_t;
    rows[0].residual = math::wrap_pi(math::atan2(earth.y, earth.x) - math::atan2(world.y, world.x));
    rows[0].variance = (square(p.mag_noise_t) + square(p.mag_body_field_t)) / horizontal2;
    used = used.first(1);
  }
  if (out_.report.mag_refused == 0) {
    fuse(NavSource::mag, used);
    return;
  }
  // It was found wrong: it has to agree with the heading of the others for a while before it is believed again.
  const math::Vec3 world = then->q_world_base.rotate(field), &earth = filter_.state().earth_field_t;
  const double off = math::wrap_pi(math::atan2(earth.y, earth.x) - math::atan2(world.y, world.x));
  if (math::fabs(off) > p.bank_most_std_rad) out_.mag_agrees_since = s.stamp;
  if (msg::seconds(s.stamp - out_.mag_agrees_since) > kMagAgreesFor_s) out_.report.mag_refused = 0;
  reject(NavSource::mag);
}

void NavEstimator::first_heading_by_mag() {
  const OutdoorParams& p = params.outdoors;
  const bool waits = msg::seconds(last_imu_ - out_.first_mag) < p.mag_wait_s;
  if (!out_.frame.known() && waits) return;  // the declination is not known before the place is
  const math::Vec3 local = out_.mag_sum_t / out_.mag_count;
  const double horizontal = math::hypot(local.x, local.y);
  math::Vec3 earth;
  if (out_.frame.known() && out_.model_known != 0) {
    earth = out_.earth_model_t;
    const double dip = math::atan2(-local.z, horizontal) - math::atan2(-earth.z, math::hypot(earth.x, earth.y));
    if (math::fabs(norm(local) / norm(earth) - 1) > kStrangeField || math::fabs(dip) > kStrangeDip_rad) {
      reject(NavSource::mag);  // iron nearby: no heading from this
      if (!waits) return;
      out_.mag_sum_t = {};
      out_.mag_count = 0;
      return;
    }
  } else {
    earth = math::Vec3{horizontal * math::sin(p.declination_rad), horizontal * math::cos(p.declination_rad), local.z};
    out_.heading_without_place = 1;
  }
  const double turn = math::wrap_pi(math::atan2(earth.y, earth.x) - math::atan2(local.y, local.x));
  align_heading(turn, kLinearHeading_rad, NavResetCause::first_heading);
  InertialState fields = filter_.state();
  fields.earth_field_t = earth;
  fields.body_field_t = {};
  filter_.open_surroundings(fields, p.mag_earth_field_t, p.mag_body_field_t, p.wind_mps);
  // The mean as a first measurement: from now on heading and the body's field know of each other.
  const math::Vec3 mean = math::Quat::from_axis_angle({0, 0, 1}, turn).rotate(local);
  const math::Quat& q = filter_.state().q_world_base;
  correct(field_rows(q.conjugate().rotate(mean), q), nullptr, kNoGate);
  ++state_of(NavSource::mag).fused;
  state_of(NavSource::mag).last_fused = last_imu_;
}

// ---- optical motion ------------------------------------------------------------------------------------------------

void NavEstimator::add_motion(const msg::GroundMotion& s) {
  if (!started_ || !height_aided_ || s.seen == 0) return;
  const auto then = history_.at(s.stamp - msg::Duration{s.interval_ns / 2});
  const double height_m = filter_.state().p_world_m.z - ground_z_m_;
  if (!then || !(height_m > kLeastHeight_m)) return;
  const OutdoorParams& p = params.outdoors;
  const math::Vec3 v_base = then->q_world_base.conjugate().rotate(then->v_world_mps);
  const math::Mat3 r = then->q_world_base.matrix(), turn = math::skew(then->v_world_mps);
  const double seen[2] = {s.forward_radps, s.left_radps};
  std::array<Measurement, 2> rows;
  for (int i = 0; i < 2; ++i) {
    Measurement& m = rows[at(i)];
    for (int k = 0; k < 3; ++k) {
      m.add(kErrV + k, r(k, i) / height_m);
      double c = 0;
      for (int j = 0; j < 3; ++j) c += r(j, i) * turn(j, k);
      m.add(kErrTheta + k, c / height_m);
    }
    m.add(kErrP + 2, -v_base[i] / (height_m * height_m));
    m.residual = seen[i] - v_base[i] / height_m;
    m.variance = square(p.motion_noise_radps + p.motion_noise_share * math::fabs(seen[i]));
  }
  fuse(NavSource::motion, rows);
}

// ---- report --------------------------------------------------------------------------------------------------------

bool NavEstimator::take_report(msg::NavReport& report) {
  if ((out_.active == 0 && out_.report_due == 0) || !started_) return false;
  if (out_.report_due == 0 && last_imu_ - out_.last_report < kReportEvery) return false;
  const InertialState& x = filter_.state();
  const Covariance& p = filter_.covariance();
  msg::NavReport& r = out_.report;
  r.stamp = last_imu_;
  r.heading_valid = out_.heading_valid;
  r.heading_std_rad = heading_std_rad();
  r.bank_heading_rad = out_.bank.heading_rad();
  r.bank_heading_std_rad = out_.bank.std_rad();
  r.earth_field_t = x.earth_field_t.to<msg::Vec3>();
  r.body_field_t = x.body_field_t.to<msg::Vec3>();
  r.wind_world_mps = x.wind_world_mps.to<msg::Vec3>();
  r.wind_std_mps = math::sqrt(p.variance(kErrWind) + p.variance(kErrWind + 1));
  out_.report_due = 0;
  out_.last_report = last_imu_;
  report = r;
  return true;
}

}  // namespace sinew::control
