#pragma once
#include "control/heading_bank.hpp"
#include "control/inertial_filter.hpp"
#include "control/local_frame.hpp"
#include "control/pull_monitor.hpp"
#include "msg/navigation.hpp"

namespace sinew::control {

/// Numbers of the sources that only work outdoors; the module ErrorStateFilter gives each its unit and range.
struct OutdoorParams {
  math::Vec3 p_base_imu, p_base_antenna;                                       // where they sit
  double gnss_delay_s = 0;                                                     // how much older than its stamp a fix is
  double gnss_position_m = 0.5, gnss_height_m = 1.0, gnss_velocity_mps = 0.2;  // least one sigma, and where the
                                                                               // receiver says none
  double gnss_worst_m = 10, gnss_worst_mps = 2;  // one sigma: fixes that are less sure are not used
  double gnss_lost_s = 5;        // after so long without a fix that fits, the next one is taken as it is
  double baro_gnss_time_s = 30;  // time constant in which the barometer's zero follows the height by GNSS
  math::Vec3 mag_hard_t;         // what the magnetometer reads of the vehicle's own iron, base
  math::Mat3 mag_soft = math::Mat3::identity();  // symmetric: field = soft (reading - hard)
  double mag_noise_t = 2e-6;                     // one sigma of an axis, with what iron and currents nearby add
  double mag_body_field_t = 3e-6, mag_earth_field_t = 1.5e-6;  // one sigma at the start: iron left over; the model's
  double mag_delay_s = 0, mag_wait_s = 5;                      // so long it waits for a place on the earth
  double declination_rad = 0;                                  // without a place: magnetic north, positive to the east
  double date_year = 2026.0;                                   // decimal, for the World Magnetic Model
  double mag_heading_only = 0;  // 1: a horizontal direction; the fields are no states then
  double bank_most_std_rad = 0.26, bank_least_turn_rad = 0.44, bank_after_s = 1;  // when the bank's heading is taken
  double motion_noise_radps = 0.1, motion_noise_share = 0.1;
  double drag_per_s = 0, drag_noise_mps2 = 0.5, wind_mps = 3;  // 0: the wind is not estimated
  double ground_effect_height_m = 0, ground_effect_m = 3;  // below: so much too low a barometer is not believed; 0: off
};

/// What NavEstimator keeps for them. Nothing of it is used, and no state is added to the filter, before the first GNSS
/// or magnetometer sample.
struct OutdoorState {
  LocalFrame frame;
  HeadingBank bank;
  PullMonitor pull;
  msg::NavReport report;
  math::Vec3 earth_model_t;  // at the origin
  math::Vec3 mag_sum_t;      // in the local world
  math::Vec3 drag_sum_mps2;
  math::Vec3 mean_fix_mps;  // of the velocities of the last fixes; world
  msg::Time last_motion;    // when that was motion, not noise
  msg::Time first_mag, first_refused, last_report, last_height, mag_agrees_since;
  double mag_count = 0, drag_span_s = 0, drag_count = 0;
  std::uint32_t active = 0, heading_valid = 0, heading_without_place = 0, fresh_start = 0, report_due = 0,
                model_known = 0;
};

}  // namespace sinew::control
