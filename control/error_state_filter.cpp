#include "control/error_state_filter.hpp"

#include "control/plausible.hpp"

namespace sinew::control {

void ErrorStateFilter::declare(rt::Declaration& d) {
  d.in("imu", imu_, {.depth = 32});  // a late start brings up to 20 at once
  d.in("imu2", imu2_, {.depth = 32, .optional = true});
  d.in("imu3", imu3_, {.depth = 32, .optional = true});
  d.in("range", range_, {.depth = 4, .optional = true});
  d.in("baro", baro_, {.depth = 4, .optional = true});
  d.in("pad", pad_, {.depth = 4, .optional = true});
  d.in("gnss", gnss_, {.depth = 4, .optional = true});
  d.in("mag", mag_, {.depth = 8, .optional = true});
  d.in("motion", motion_, {.depth = 4, .optional = true});
  d.in("motors", motors_, {.optional = true, .previous = true});
  d.out("state", state_);
  d.out("report", report_, {.usual_period = NavEstimator::kReportEvery});
  d.state(estimator_, others_, selector_);
  d.param("imus", imus_, {.unit = "1", .min = 1, .max = 3, .doc = "IMUs that are bound: imu, imu2, imu3"});
  declare_sensors(d);
  declare_levelling(d);
  declare_gnss(d);
  declare_mag(d);
}

void ErrorStateFilter::declare_sensors(rt::Declaration& d) {
  NavParams& p = estimator_.params;
  d.param("gyro_noise", p.noise.gyro,
          {.unit = "rad/s/sqrt(Hz)", .min = 1e-6, .max = 0.1, .doc = "white noise of the gyro"});
  d.param("accel_noise", p.noise.accel,
          {.unit = "m/s^2/sqrt(Hz)", .min = 1e-5, .max = 10, .doc = "white noise of the accelerometer"});
  d.param("gyro_walk", p.noise.gyro_walk,
          {.unit = "rad/s/sqrt(s)", .min = 0, .max = 0.1, .doc = "drift of the gyro's bias"});
  d.param("accel_walk", p.noise.accel_walk,
          {.unit = "m/s^2/sqrt(s)", .min = 0, .max = 1, .doc = "drift of the accelerometer's bias"});
  d.param("gyro_bias_radps", p.spread.gyro_bias_radps,
          {.unit = "rad/s", .min = 1e-5, .max = 1, .doc = "standard deviation at the start"});
  d.param("accel_bias_mps2", p.spread.accel_bias_mps2,
          {.unit = "m/s^2", .min = 1e-4, .max = 5, .doc = "standard deviation at the start"});
  d.param("gyro_limit_radps", p.gyro_limit_radps, {.unit = "rad/s", .min = 0.1, .max = 1e4, .doc = "beyond: nonsense"});
  d.param("accel_limit_mps2", p.accel_limit_mps2, {.unit = "m/s^2", .min = 1, .max = 1e5, .doc = "beyond: nonsense"});
  d.param("range_min_m", p.range_min_m, {.unit = "m", .min = 0, .max = 10, .doc = "below: nonsense"});
  d.param("range_max_m", p.range_max_m, {.unit = "m", .min = 0.1, .max = 1e4, .doc = "beyond: nonsense"});
  d.param("range_noise_m", p.range_noise_m,
          {.unit = "m", .min = 1e-4, .max = 1, .doc = "1 sigma of a range, with the share below"});
  d.param("range_noise_share", p.range_noise_share, {.unit = "1", .min = 0, .max = 0.5, .doc = "of the range"});
  d.param("range_below_base_m", p.range_below_base_m,
          {.unit = "m", .min = -1, .max = 1, .doc = "how far the range finder is below the base's origin"});
  d.param("baro_noise_m", p.baro_noise_m,
          {.unit = "m", .min = 0.01, .max = 50, .doc = "1 sigma of the height by barometer"});
  d.param("baro_offset_time_s", p.baro_offset_time_s,
          {.unit = "s",
           .min = 0.1,
           .max = 1000,
           .doc = "time constant in which the barometer's zero follows the range finder"});
  d.param("pad_noise_m", p.pad_noise_m,
          {.unit = "m", .min = 1e-4, .max = 1, .doc = "1 sigma of a sighting of the pad, with the share below"});
  d.param("pad_noise_share", p.pad_noise_share, {.unit = "1", .min = 0, .max = 0.5, .doc = "of the distance"});
  d.param("pad_min_confidence", p.pad_min_confidence,
          {.unit = "1", .min = 0.01, .max = 1, .doc = "sightings below are not used"});
  d.param("gate", p.gate, {.unit = "1", .min = 1, .max = 1e6, .doc = "largest squared normalised innovation"});
  const rt::ParamOptions place{.unit = "m", .min = -2, .max = 2, .doc = "camera in the base frame"};
  d.param("camera_x_m", p.p_base_camera.x, place);
  d.param("camera_y_m", p.p_base_camera.y, place);
  d.param("camera_z_m", p.p_base_camera.z, place);
  const rt::ParamOptions turn{.unit = "1", .min = -1, .max = 1, .doc = "unit quaternion, optical frame to base"};
  d.param("camera_qw", p.q_base_optical.w, turn);
  d.param("camera_qx", p.q_base_optical.x, turn);
  d.param("camera_qy", p.q_base_optical.y, turn);
  d.param("camera_qz", p.q_base_optical.z, turn);
}

void ErrorStateFilter::declare_levelling(rt::Declaration& d) {
  NavParams& p = estimator_.params;
  d.param("max_gap_s", p.max_gap_s, {.unit = "s", .min = 0.002, .max = 10, .doc = "longer without samples: new start"});
  d.param("level_time_s", p.level_time_s, {.unit = "s", .min = 0, .max = 10, .doc = "average behind first attitude"});
  d.param("level_rate_hz", p.level_rate_hz,
          {.unit = "Hz",
           .min = 0.1,
           .max = 1000,
           .doc = "without other sensors: how often \"it hardly moves\" counts as a measurement"});
  d.param("level_velocity_mps", p.level_velocity_mps,
          {.unit = "m/s", .min = 0.01, .max = 1000, .doc = "1 sigma of that for the velocity"});
  d.param("level_accel_mps2", p.level_accel_mps2,
          {.unit = "m/s^2", .min = 0.01, .max = 1000, .doc = "1 sigma of that for the acceleration"});
  d.param(
      "level_per_deviation", p.level_per_deviation,
      {.unit = "1", .min = 0, .max = 1000, .doc = "more of it for each m/s^2 that the specific force is off gravity"});
  d.param("level_per_rate", p.level_per_rate,
          {.unit = "m/s", .min = 0, .max = 1000, .doc = "more of it for each rad/s of turning"});
  d.param("start_tilt_rad", p.spread.tilt_rad,
          {.unit = "rad", .min = 1e-4, .max = 1, .doc = "1 sigma of the first attitude"});
  d.param("start_v_mps", p.spread.v_mps,
          {.unit = "m/s", .min = 1e-4, .max = 100, .doc = "1 sigma of the first velocity"});
  d.param("rest_gyro_radps", p.rest.gyro_spread_radps,
          {.unit = "rad/s", .min = 0, .max = 1, .doc = "standing still: the gyro spreads less"});
  d.param("rest_accel_mps2", p.rest.accel_spread_mps2,
          {.unit = "m/s^2", .min = 0, .max = 5, .doc = "standing still: the accelerometer spreads less"});
  d.param("valid_tilt_rad", p.valid_tilt_rad, {.unit = "rad", .min = 0.001, .max = 1, .doc = "1 sigma"});
  d.param("valid_v_mps", p.valid_v_mps, {.unit = "m/s", .min = 0.01, .max = 100, .doc = "1 sigma"});
  d.param("valid_p_m", p.valid_p_m, {.unit = "m", .min = 0.01, .max = 1000, .doc = "1 sigma"});
  d.param("valid_height_age_s", p.valid_height_age_s,
          {.unit = "s", .min = 0.01, .max = 60, .doc = "the height is valid for so long after a range or a pressure"});
}

void ErrorStateFilter::declare_gnss(rt::Declaration& d) {
  OutdoorParams& p = estimator_.params.outdoors;
  const rt::ParamOptions imu{.unit = "m", .min = -5, .max = 5, .doc = "IMU in the base frame"};
  d.param("imu_x_m", p.p_base_imu.x, imu);
  d.param("imu_y_m", p.p_base_imu.y, imu);
  d.param("imu_z_m", p.p_base_imu.z, imu);
  const rt::ParamOptions antenna{.unit = "m", .min = -5, .max = 5, .doc = "GNSS antenna in the base frame"};
  d.param("antenna_x_m", p.p_base_antenna.x, antenna);
  d.param("antenna_y_m", p.p_base_antenna.y, antenna);
  d.param("antenna_z_m", p.p_base_antenna.z, antenna);
  d.param("gnss_delay_s", p.gnss_delay_s,
          {.unit = "s", .min = 0, .max = 0.3, .doc = "how much older than its stamp a fix is"});
  const rt::ParamOptions least{.unit = "m", .min = 0.005, .max = 50, .doc = "least one sigma, and where none is said"};
  d.param("gnss_position_m", p.gnss_position_m, least);
  d.param("gnss_height_m", p.gnss_height_m, least);
  d.param("gnss_velocity_mps", p.gnss_velocity_mps,
          {.unit = "m/s", .min = 0.005, .max = 10, .doc = "least one sigma, and where none is said"});
  d.param("gnss_worst_m", p.gnss_worst_m,
          {.unit = "m", .min = 0.05, .max = 1000, .doc = "one sigma; less sure fixes are not used"});
  d.param("gnss_worst_mps", p.gnss_worst_mps,
          {.unit = "m/s", .min = 0.05, .max = 100, .doc = "one sigma; less sure fixes are not used"});
  d.param("gnss_lost_s", p.gnss_lost_s,
          {.unit = "s",
           .min = 0.5,
           .max = 600,
           .doc = "after so long without a fix that fits, the next is taken as it is"});
  d.param(
      "baro_gnss_time_s", p.baro_gnss_time_s,
      {.unit = "s", .min = 1, .max = 10000, .doc = "time constant of the barometer's zero towards the GNSS height"});
  d.param("bank_most_std_rad", p.bank_most_std_rad,
          {.unit = "rad", .min = 0.01, .max = 1, .doc = "less sure, the bank's heading is never taken"});
  d.param("bank_least_turn_rad", p.bank_least_turn_rad,
          {.unit = "rad", .min = 0.05, .max = 3, .doc = "smaller differences are left to the filter"});
  d.param("bank_after_s", p.bank_after_s,
          {.unit = "s", .min = 0.1, .max = 60, .doc = "of refused GNSS velocities before the bank is asked"});
  d.param("motion_noise_radps", p.motion_noise_radps,
          {.unit = "rad/s", .min = 1e-3, .max = 10, .doc = "1 sigma of the ground's motion, with the share below"});
  d.param("motion_noise_share", p.motion_noise_share, {.unit = "1", .min = 0, .max = 2, .doc = "of the motion"});
  d.param("drag_per_s", p.drag_per_s,
          {.unit = "1/s", .min = 0, .max = 5, .doc = "rotor drag: base x and y of the force for each m/s; 0: no wind"});
  d.param("drag_noise_mps2", p.drag_noise_mps2, {.unit = "m/s^2", .min = 0.01, .max = 20, .doc = "1 sigma of that"});
  d.param("wind_mps", p.wind_mps, {.unit = "m/s", .min = 0.1, .max = 50, .doc = "1 sigma of the wind at the start"});
  d.param(
      "ground_effect_height_m", p.ground_effect_height_m,
      {.unit = "m", .min = 0, .max = 10, .doc = "below, with turning motors, a too low barometer counts less; 0: off"});
  d.param("ground_effect_m", p.ground_effect_m, {.unit = "m", .min = 0, .max = 20, .doc = "by so much"});
}

void ErrorStateFilter::declare_mag(rt::Declaration& d) {
  OutdoorParams& p = estimator_.params.outdoors;
  const rt::ParamOptions hard{.unit = "T", .min = -1e-3, .max = 1e-3, .doc = "hard iron: subtracted from a reading"};
  d.param("mag_hard_x_t", p.mag_hard_t.x, hard);
  d.param("mag_hard_y_t", p.mag_hard_t.y, hard);
  d.param("mag_hard_z_t", p.mag_hard_t.z, hard);
  const char* const names[3][3] = {{"mag_soft_xx", "mag_soft_xy", "mag_soft_xz"},
                                   {"mag_soft_yx", "mag_soft_yy", "mag_soft_yz"},
                                   {"mag_soft_zx", "mag_soft_zy", "mag_soft_zz"}};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      d.param(names[r][c], p.mag_soft(r, c),
              {.unit = "1", .min = -3, .max = 3, .doc = "soft iron: field = soft (reading - hard)"});
  d.param("mag_noise_t", p.mag_noise_t, {.unit = "T", .min = 1e-8, .max = 1e-4, .doc = "1 sigma of an axis"});
  d.param("mag_body_field_t", p.mag_body_field_t,
          {.unit = "T", .min = 1e-8, .max = 1e-4, .doc = "1 sigma of the iron that the calibration left"});
  d.param("mag_earth_field_t", p.mag_earth_field_t,
          {.unit = "T", .min = 1e-8, .max = 1e-5, .doc = "1 sigma of the earth's field at the start"});
  d.param("mag_delay_s", p.mag_delay_s, {.unit = "s", .min = 0, .max = 0.3, .doc = "how much older than its stamp"});
  d.param(
      "mag_wait_s", p.mag_wait_s,
      {.unit = "s", .min = 0, .max = 600, .doc = "first heading: so long it waits for a place, for the declination"});
  d.param("mag_heading_only", p.mag_heading_only,
          {.unit = "1", .min = 0, .max = 1, .doc = "1: a horizontal direction; no field of the body is estimated"});
  d.param("declination_rad", p.declination_rad,
          {.unit = "rad", .min = -3.2, .max = 3.2, .doc = "where no place is known; positive to the east"});
  d.param("date_year", p.date_year,
          {.unit = "1", .min = 2000, .max = 2100, .doc = "decimal year, for the World Magnetic Model (2025 to 2030)"});
}

hal::Status ErrorStateFilter::configure(rt::Setup&) {
  others_.resize(static_cast<std::size_t>(imus_ - 1));
  return {};
}

void ErrorStateFilter::reset() {
  estimator_.reset();
  for (NavEstimator& other : others_) other.reset();
  selector_.reset();
}

/// False when there are samples and none of them can be used.
bool ErrorStateFilter::add_messages(NavEstimator& nav, const rt::InQueue<msg::ImuSample>& imu) noexcept {
  const msg::ActuatorCommand* motors = motors_.get();
  nav.set_motors_stopped(!motors || !motors->armed);
  bool good = false;
  for (const msg::ImuSample& s : imu) good = nav.add_imu(s) || good;
  for (const msg::RangeSample& s : range_) nav.add_range(s);
  for (const msg::BaroSample& s : baro_) nav.add_baro(s);
  for (const msg::PadSighting& s : pad_) nav.add_pad(s);
  for (const msg::GnssSample& s : gnss_) nav.add_gnss(s);
  for (const msg::MagSample& s : mag_) nav.add_mag(s);
  for (const msg::GroundMotion& s : motion_) nav.add_motion(s);
  return good;
}

NavEstimator& ErrorStateFilter::choose_imu(const rt::Step& step) noexcept {
  const auto count = static_cast<std::uint32_t>(others_.size() + 1);
  const auto lane = [&](std::uint32_t i) -> NavEstimator& { return i == 0 ? estimator_ : others_[i - 1]; };
  for (std::uint32_t i = 0; i < count; ++i) {
    NavEstimator& nav = lane(i);
    if (i > 0) {
      nav.params = estimator_.params;
      if (const auto& imu = queue_of(i); add_messages(nav, imu) && nav.started())
        selector_.add_sample(i, step.now, math::Vec3(imu.back().gyro_radps), math::Vec3(imu.back().accel_mps2));
    } else if (!imu_.empty() && nav.started()) {
      selector_.add_sample(0, step.now, math::Vec3(imu_.back().gyro_radps), math::Vec3(imu_.back().accel_mps2));
    }
    selector_.add_fit(i, nav.fit(), msg::seconds(step.dt));
  }
  const std::uint32_t before = selector_.chosen();
  NavEstimator& chosen = lane(selector_.choose(count, step.now));
  if (selector_.chosen() != before) chosen.announce_imu(selector_.chosen(), lane(before));
  return chosen;
}

rt::StepStatus ErrorStateFilter::step(const rt::Step& step) noexcept {
  const bool good = add_messages(estimator_, imu_);
  NavEstimator& nav = others_.empty() ? estimator_ : choose_imu(step);
  if (queue_of(others_.empty() ? 0 : selector_.chosen()).empty()) return rt::StepStatus::stale;
  if (!good && &nav == &estimator_) return rt::StepStatus::fault;  // no sample of this step could be used
  if (!nav.started()) return rt::StepStatus::stale;
  const msg::NavState n = nav.output();
  if (!plausible(n)) return rt::StepStatus::fault;
  state_.loan() = n;
  if (msg::NavReport report; nav.take_report(report)) report_.loan() = report;
  return rt::StepStatus::ok;
}

}  // namespace sinew::control
