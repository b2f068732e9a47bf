#include "control/nav_estimator.hpp"

#include "control/limits.hpp"
#include "control/plausible.hpp"

namespace sinew::control {
namespace {

constexpr std::uint32_t kSightingsToAnchor = 5;    // averaged into the position of the pad
constexpr std::uint32_t kRefusedToReopen = 12;     // sightings in a row, about 0.4 s
constexpr std::uint32_t kRefusedToNewGround = 15;  // ranges in a row
constexpr double kRestOutdoors_s = 1.5;            // before rest corrects anything
constexpr double kGroundMoves_s = 2;               // a third new ground within this time is not believed
constexpr double kLostVelocity = 4;                // (m/s)^2: for a height that ran away
constexpr double kSameGround_m = 0.3;              // ranges that differ by more do not show one new ground
constexpr double kStuck_s = 0.25;                  // no sensor repeats one value for so long in flight
constexpr double kVagueVelocity = 1.0;             // (m/s)^2: an aided vehicle that knows less uses the weak prior, too

}  // namespace

void NavEstimator::reset() {
  const NavParams keep = params;
  *this = NavEstimator{};
  params = keep;
}

bool NavEstimator::add_imu(const msg::ImuSample& s) {
  const math::Vec3 gyro(s.gyro_radps), accel(s.accel_mps2);
  const bool first = !started_ && level_count_ == 0;
  const bool sane = norm(gyro) < params.gyro_limit_radps && norm(accel) < params.accel_limit_mps2;  // not so for NaN
  if (!sane || (!first && s.stamp < last_imu_)) {
    ++counters_.refused_imu;
    return false;
  }
  if (!first && s.stamp == last_imu_) {
    ++counters_.same_imu;
    return true;
  }
  const double dt_s = first ? 0 : msg::seconds(s.stamp - last_imu_);
  last_imu_ = s.stamp;
  gyro_radps_ = gyro;
  if (dt_s > params.max_gap_s) {
    ++counters_.gaps;
    started_ = false;
    level_count_ = 0;
    level_span_s_ = 0;
    level_sum_ = {};
    height_aided_ = false;
    pad_known_ = false;
    pad_sightings_ = 0;
    history_.clear();
    if (out_.active != 0) restart_outdoors();
  }
  if (!started_) {
    level_span_s_ += level_count_ > 0 ? dt_s : 0;
    level(accel, s.stamp);
    return true;
  }
  filter_.predict(gyro, accel, dt_s, params.noise);
  if (rest_.add(gyro, accel, dt_s, params.rest)) use_rest();
  const Covariance& p = filter_.covariance();
  const double v_variance = p.variance(kErrV) + p.variance(kErrV + 1);
  if (!height_aided_ || v_variance > kVagueVelocity) use_prior(dt_s);
  if (out_.active != 0) add_imu_outdoors(gyro, accel, dt_s);
  history_.add({s.stamp, filter_.state().p_world_m, filter_.state().q_world_base, filter_.state().v_world_mps});
  return true;
}

void NavEstimator::level(const math::Vec3& accel_mps2, msg::Time stamp) {
  level_sum_ += accel_mps2;
  level_count_ += 1;
  if (level_span_s_ < params.level_time_s) return;
  InertialState x;
  const math::Vec3 up_base = level_sum_ / level_count_;
  x.q_world_base = math::Quat::between(up_base, {0, 0, 1});
  // Yaw is 0 by definition of the world: turn the shortest rotation until base x points along world x, if it can.
  const math::Vec3 forward = x.q_world_base.rotate({1, 0, 0});
  if (forward.x * forward.x + forward.y * forward.y > 0.01) {
    x.q_world_base = math::Quat::from_axis_angle({0, 0, 1}, -math::atan2(forward.y, forward.x)) * x.q_world_base;
  }
  if (counters_.gaps) {
    x.gyro_bias_radps = filter_.state().gyro_bias_radps;
    x.accel_bias_mps2 = filter_.state().accel_bias_mps2;
  }
  filter_.start(x, params.spread);
  if (out_.active != 0) go_outdoors();
  history_.clear();
  history_.add({stamp, x.p_world_m, x.q_world_base});
  rest_.reset();
  prior_span_s_ = prior_count_ = prior_rate_ = 0;
  prior_f_sum_ = {};
  started_ = true;
}

/// The specific force as a measure of the tilt: it points up when the vehicle does not accelerate.
Measurement NavEstimator::gravity_row(int axis, const math::Vec3& f, double sigma) const {
  const math::Mat3 r = filter_.state().q_world_base.matrix();
  Measurement m;
  if (axis == 0) {
    m.add(kErrTheta + 1, -f.z);
    m.add(kErrTheta + 2, f.y);
  } else {
    m.add(kErrTheta + 0, f.z);
    m.add(kErrTheta + 2, -f.x);
  }
  for (int k = 0; k < 3; ++k) m.add(kErrAccelBias + k, r(axis, k));
  m.residual = f[axis];
  m.variance = sigma * sigma;
  return m;
}

void NavEstimator::use_rest() {
  if (!motors_stopped_ || is_carried()) return;
  // A steady push is as quiet as rest is; satellites tell them apart after a while.
  if (out_.frame.known() && rest_.blocks_at_rest() * params.rest.block_s < kRestOutdoors_s) return;
  const InertialState& x = filter_.state();
  const math::Vec3 f = x.q_world_base.rotate(rest_.accel_mean_mps2() - x.accel_bias_mps2);
  std::array<Measurement, 8> rows;
  for (int i = 0; i < 3; ++i) {
    rows[static_cast<std::size_t>(i)].add(kErrGyroBias + i, 1);
    rows[static_cast<std::size_t>(i)].residual = rest_.gyro_mean_radps()[i] - x.gyro_bias_radps[i];
    rows[static_cast<std::size_t>(i)].variance = square(5e-4);
    rows[static_cast<std::size_t>(i + 3)].add(kErrV + i, 1);
    rows[static_cast<std::size_t>(i + 3)].residual = -x.v_world_mps[i];
    rows[static_cast<std::size_t>(i + 3)].variance = square(0.01);
  }
  rows[6] = gravity_row(0, f, 0.02);
  rows[7] = gravity_row(1, f, 0.02);
  correct(rows, nullptr, kNoGate);
}

void NavEstimator::use_prior(double dt_s) {
  prior_f_sum_ += filter_.f_world_mps2();
  prior_rate_ += norm(gyro_radps_ - filter_.state().gyro_bias_radps);
  prior_count_ += 1;
  prior_span_s_ += dt_s;
  if (prior_span_s_ * params.level_rate_hz < 1) return;
  const math::Vec3 f = prior_f_sum_ / prior_count_;
  const double rate_radps = prior_rate_ / prior_count_;
  prior_span_s_ = prior_count_ = prior_rate_ = 0;
  prior_f_sum_ = {};

  const double deviation = math::fabs(norm(f) - kGravity);
  const double sigma =
      params.level_accel_mps2 + params.level_per_deviation * deviation + params.level_per_rate * rate_radps;
  std::array<Measurement, 5> rows;
  for (int i = 0; i < 3; ++i) {
    rows[static_cast<std::size_t>(i)].add(kErrV + i, 1);
    rows[static_cast<std::size_t>(i)].residual = -filter_.state().v_world_mps[i];
    rows[static_cast<std::size_t>(i)].variance = square(params.level_velocity_mps);
  }
  rows[3] = gravity_row(0, f, sigma);
  rows[4] = gravity_row(1, f, sigma);
  correct(rows, nullptr, kNoGate);
}

void NavEstimator::add_range(const msg::RangeSample& s) {
  if (!started_ || !(s.range_m > params.range_min_m) || !(s.range_m < params.range_max_m) || is_stuck(s)) return;
  const math::Vec3 up = filter_.state().q_world_base.conjugate().rotate({0, 0, 1});
  if (up.z < 0.7) return;  // looks at a wall
  const double height_m = (s.range_m + (params.range_below_base_m + params.outdoors.p_base_imu.z)) * up.z;
  const double variance = square(params.range_noise_m + params.range_noise_share * s.range_m);
  if (!height_aided_) {
    filter_.reset_position(2, height_m, variance);
    history_.clear();
    history_.add({last_imu_, filter_.state().p_world_m, filter_.state().q_world_base, filter_.state().v_world_mps});
    ground_z_m_ = 0;
    height_aided_ = true;
    last_range_ = s.stamp;
    return;
  }
  std::array<Measurement, 1> row;
  row[0].add(kErrP + 2, 1);
  row[0].residual = ground_z_m_ + height_m - filter_.state().p_world_m.z;
  row[0].variance = variance;
  const std::uint32_t before = counters_.gated_range;
  correct(row, &counters_.gated_range, params.gate);
  if (counters_.gated_range == before) {
    range_refused_in_row_ = 0;
    last_range_ = s.stamp;
    ++state_of(msg::NavSource::range).fused;
    state_of(msg::NavSource::range).last_fused = s.stamp;
  } else {
    reject(msg::NavSource::range);
    refuse_range(s.stamp, height_m);
  }
}

/// Many refusals in a row at about the same height: the vehicle is over a crate, or past its edge. A jumping height is
/// no ground.
void NavEstimator::refuse_range(msg::Time stamp, double height_m) {
  if (range_refused_in_row_ == 0 || math::fabs(height_m - refused_height_m_) > kSameGround_m) {
    range_refused_in_row_ = 0;
    refused_height_m_ = height_m;
  }
  if (++range_refused_in_row_ < kRefusedToNewGround) return;
  range_refused_in_row_ = 0;
  const bool moves = counters_.new_ground >= 2 && msg::seconds(stamp - ground_before_last_) < kGroundMoves_s;
  ++counters_.new_ground;
  ground_before_last_ = last_ground_;
  last_ground_ = stamp;
  const double z_m = filter_.state().p_world_m.z;
  if (!moves) {
    ground_z_m_ = z_m - height_m;
    return;
  }
  // The height of the vehicle runs away, after a shock beyond what the IMU measures.
  filter_.reset_position(2, ground_z_m_ + height_m, square(kSameGround_m));
  filter_.reopen_velocity(2, kLostVelocity);
  history_.shift({0, 0, ground_z_m_ + height_m - z_m});
  ++counters_.reopened_height;
  announce(msg::NavResetCause::measured_anew, 0, {0, 0, ground_z_m_ + height_m - z_m}, {});
}

/// On the ground a constant value is normal.
bool NavEstimator::is_stuck(const msg::RangeSample& s) {
  if (s.range_m != last_range_m_ || motors_stopped_) {
    last_range_m_ = s.range_m;
    range_changed_ = s.stamp;
    return false;
  }
  if (msg::seconds(s.stamp - range_changed_) < kStuck_s) return false;
  ++counters_.stuck_range;
  return true;
}

bool NavEstimator::is_stuck(const msg::PadSighting& s) {
  if (!(s.direction_optical == last_pad_direction_) || motors_stopped_) {
    last_pad_direction_ = s.direction_optical;
    pad_changed_ = s.stamp;
    return false;
  }
  if (msg::seconds(s.stamp - pad_changed_) < kStuck_s) return false;
  ++counters_.stuck_pad;
  return true;
}

void NavEstimator::add_baro(const msg::BaroSample& s) {
  if (!started_ || (!height_aided_ && out_.active == 0) || !(s.pressure_pa > 1000) || !(s.pressure_pa < 200000) ||
      !(math::fabs(s.temperature_c) < 150)) {
    return;
  }
  height_aided_ = true;  // outdoors the barometer may be the first: the start is at height 0
  // Height in an atmosphere of one temperature; the offset takes the weather.
  const double kelvin = 273.15 + s.temperature_c;
  const double height_m = 29.2718 * kelvin * math::log(101325.0 / s.pressure_pa);
  const double z_m = filter_.state().p_world_m.z;
  const double since_s = baro_known_ != 0 ? msg::seconds(s.stamp - last_baro_) : 0;
  last_baro_ = s.stamp;
  if (baro_known_ == 0) {
    baro_offset_m_ = height_m - z_m;
    baro_known_ = 1;
  } else if (msg::seconds(s.stamp - last_range_) < 0.3) {
    const double share = since_s / (params.baro_offset_time_s + since_s);
    baro_offset_m_ += share * (height_m - z_m - baro_offset_m_);
  } else {
    std::array<Measurement, 1> row;
    row[0].add(kErrP + 2, 1);
    row[0].residual = height_m - baro_offset_m_ - z_m;
    row[0].variance = square(params.baro_noise_m);
    // Near the ground the rotors raise the pressure: the barometer reads too low, never too high.
    const OutdoorParams& o = params.outdoors;
    const bool in_ground_effect = o.ground_effect_height_m > 0 && z_m - ground_z_m_ < o.ground_effect_height_m;
    if (in_ground_effect && !motors_stopped_ && row[0].residual < 0)
      row[0].residual = row[0].residual < -o.ground_effect_m ? row[0].residual + o.ground_effect_m : 0;
    const std::uint32_t before = counters_.gated_baro;
    correct(row, &counters_.gated_baro, params.gate);
    if (counters_.gated_baro != before) return reject(msg::NavSource::baro);
    ++state_of(msg::NavSource::baro).fused;
    state_of(msg::NavSource::baro).last_fused = s.stamp;
  }
}

void NavEstimator::add_pad(const msg::PadSighting& s) {
  const math::Vec3 direction(s.direction_optical);
  if (!started_ || !height_aided_ || !s.found || !(s.confidence >= params.pad_min_confidence) ||
      !(math::fabs(norm(direction) - 1) < 1e-3)) {
    return;
  }
  if (is_stuck(s)) return;
  auto then = history_.at(s.stamp);
  if (!then) {
    ++counters_.late_pad;
    return;
  }
  const math::Vec3 arm = then->q_world_base.rotate(params.p_base_camera - params.outdoors.p_base_imu);
  const math::Vec3 beam = then->q_world_base.rotate(params.q_base_optical.rotate(direction));
  if (beam.z > -0.5) return;  // too flat for a distance from the height
  if (!ground_seen()) {
    use_pad_size(s, then->p_world_m.z + arm.z - ground_z_m_, -beam.z);
    then = history_.at(s.stamp);
  }
  const double camera_height_m = then->p_world_m.z + arm.z - ground_z_m_;
  if (camera_height_m < 0.02) return;
  const math::Vec3 ray = beam * (camera_height_m / -beam.z);
  const math::Vec3 offset = arm + ray;
  const math::Vec3 seen = then->p_world_m + offset;
  if (!pad_known_) return anchor_pad({seen.x, seen.y, ground_z_m_});

  const double delay_s = msg::seconds(last_imu_ - s.stamp);
  const double sigma = (params.pad_noise_m + params.pad_noise_share * norm(ray)) / s.confidence;
  std::array<Measurement, 2> rows;
  for (int i = 0; i < 2; ++i) {
    Measurement& m = rows[static_cast<std::size_t>(i)];
    m.add(kErrP + i, 1);
    m.add(kErrV + i, -delay_s);
    m.residual = pad_world_m_[i] - seen[i];
    m.variance = sigma * sigma;
  }
  rows[0].add(kErrTheta + 1, offset.z);  // seen = p + offset + theta x offset
  rows[0].add(kErrTheta + 2, -offset.y);
  rows[1].add(kErrTheta + 0, -offset.z);
  rows[1].add(kErrTheta + 2, offset.x);
  const std::uint32_t before = counters_.gated_pad;
  correct(rows, &counters_.gated_pad, params.gate);
  if (counters_.gated_pad == before) {
    ++state_of(msg::NavSource::pad).fused;
    state_of(msg::NavSource::pad).last_fused = s.stamp;
    pad_stamp_ = s.stamp;
    pad_refused_in_row_ = 0;
  } else if (++pad_refused_in_row_ >= kRefusedToReopen) {
    for (int i = 0; i < 2; ++i) {
      const double p_m = filter_.state().p_world_m[i] + rows[static_cast<std::size_t>(i)].residual;
      filter_.reset_position(i, p_m, square(0.1));
    }
    history_.shift({rows[0].residual, rows[1].residual, 0});
    pad_refused_in_row_ = 0;
    ++counters_.reopened_position;
    announce(msg::NavResetCause::measured_anew, 0, {rows[0].residual, rows[1].residual, 0}, {});
  }
}

bool NavEstimator::ground_seen() const {
  return height_aided_ && msg::seconds(last_imu_ - last_range_) < params.range_lost_s;
}

/// `down`: how far one metre along the beam leads down.
void NavEstimator::use_pad_size(const msg::PadSighting& s, double camera_height_m, double down) {
  if (!(s.range_m > params.range_min_m) || !(s.range_m < params.range_max_m)) return;
  std::array<Measurement, 1> row;
  row[0].add(kErrP + 2, 1);
  row[0].add(kErrV + 2, -msg::seconds(last_imu_ - s.stamp));
  row[0].residual = s.range_m * down - camera_height_m;
  row[0].variance = square(params.pad_range_share * s.range_m * down / s.confidence);
  correct(row, &counters_.gated_pad_size, params.gate);
}

/// The first sightings measure where the pad is; later ones measure where the vehicle is.
void NavEstimator::anchor_pad(const math::Vec3& seen) {
  const math::Vec3 apart = seen - pad_world_m_;
  if (pad_sightings_ && apart.x * apart.x + apart.y * apart.y > square(0.3))
    pad_sightings_ = 0;  // two different things
  if (!pad_sightings_) pad_world_m_ = seen;
  ++pad_sightings_;
  pad_world_m_ += (seen - pad_world_m_) / static_cast<double>(pad_sightings_);
  pad_known_ = pad_sightings_ >= kSightingsToAnchor;
  pad_stamp_ = last_imu_;
}

void NavEstimator::correct(std::span<const Measurement> rows, std::uint32_t* refused, double gate) {
  const InertialState before = filter_.state();
  const std::uint32_t used = filter_.update(rows, gate);
  if (refused && used < rows.size()) ++*refused;
  if (!used) return;
  const InertialState& x = filter_.state();
  if (out_.active == 0) return history_.shift(x.p_world_m - before.p_world_m);
  history_.correct(last_imu_, x.p_world_m - before.p_world_m, x.v_world_mps - before.v_world_mps,
                   (x.q_world_base * before.q_world_base.conjugate()).log());
}

msg::NavState NavEstimator::output() const {
  const InertialState& x = filter_.state();
  const Covariance& p = filter_.covariance();
  msg::NavState n;
  n.stamp = last_imu_;
  n.q_world_base = x.q_world_base.to<msg::Quat>();
  n.v_world_mps = x.v_world_mps.to<msg::Vec3>();
  n.p_world_m = x.p_world_m.to<msg::Vec3>();
  n.gyro_radps = (gyro_radps_ - x.gyro_bias_radps).to<msg::Vec3>();
  if (const math::Vec3& imu = params.outdoors.p_base_imu; !(imu == math::Vec3{})) {
    n.p_world_m = (x.p_world_m - x.q_world_base.rotate(imu)).to<msg::Vec3>();
    n.v_world_mps =
        (x.v_world_mps - x.q_world_base.rotate(cross(gyro_radps_ - x.gyro_bias_radps, imu))).to<msg::Vec3>();
  }
  n.gyro_bias_radps = x.gyro_bias_radps.to<msg::Vec3>();
  n.accel_bias_mps2 = x.accel_bias_mps2.to<msg::Vec3>();
  n.pad_world_m = pad_world_m_.to<msg::Vec3>();
  n.pad_stamp = pad_stamp_;
  n.height_m = n.p_world_m.z - ground_z_m_;
  n.tilt_std_rad = math::sqrt(p.variance(kErrTheta) + p.variance(kErrTheta + 1));
  n.p_std_m = math::sqrt(p.variance(kErrP) + p.variance(kErrP + 1));
  n.v_std_mps = math::sqrt(p.variance(kErrV) + p.variance(kErrV + 1) + p.variance(kErrV + 2));
  n.attitude_valid = started_ && n.tilt_std_rad < params.valid_tilt_rad;
  const bool height_fresh = msg::seconds(last_imu_ - last_range_) < params.valid_height_age_s ||
                            (baro_known_ != 0 && msg::seconds(last_imu_ - last_baro_) < params.valid_height_age_s) ||
                            (out_.frame.known() && !lost(msg::NavSource::gnss_height, params.valid_height_age_s));
  n.height_valid = n.attitude_valid && height_aided_ && height_fresh;
  n.position_valid = n.height_valid && n.v_std_mps < params.valid_v_mps && n.p_std_m < params.valid_p_m &&
                     (out_.active == 0 || out_.heading_valid != 0);
  n.pad_known = pad_known_;
  n.ground_seen = ground_seen();
  n.at_rest = rest_.at_rest() && motors_stopped_ && !is_carried();
  return n;
}

}  // namespace sinew::control
