#pragma once
// What the state estimator says about itself outdoors: each jump of its output with its size, and what became of each
// source.
#include "msg/geometry.hpp"

namespace sinew::msg {

/// Sources of the estimator; the index into the arrays of NavReport.
enum class NavSource : std::uint32_t {
  gnss_position = 0,
  gnss_velocity = 1,
  gnss_height = 2,
  mag = 3,
  heading_bank = 4,
  baro = 5,
  range = 6,
  motion = 7,
  pad = 8,
  drag = 9
};
inline constexpr std::size_t kNavSources = 10;

inline constexpr ValueName kNavSourceNames[] = {{"gnss_position", NavSource::gnss_position},
                                                {"gnss_velocity", NavSource::gnss_velocity},
                                                {"gnss_height", NavSource::gnss_height},
                                                {"mag", NavSource::mag},
                                                {"heading_bank", NavSource::heading_bank},
                                                {"baro", NavSource::baro},
                                                {"range", NavSource::range},
                                                {"motion", NavSource::motion},
                                                {"pad", NavSource::pad},
                                                {"drag", NavSource::drag}};

/// Why the newest jump was made;
enum class NavResetCause : std::uint32_t {
  none = 0,
  first_heading = 1,  // the world's axes become east and north
  heading = 2,        // by the bank, against the magnetometer
  gnss_return = 3,    // position, velocity or height after a time without GNSS, or after many refused fixes
  imu_change = 4,     // another IMU's estimate is published from now on
  declination = 5,    // the place became known after the heading
  measured_anew = 6,  // height by the range finder or position by the pad, after many refusals in a row
  large_step = 7      // an ordinary correction of more than 0.5 m, 0.5 m/s or 0.1 rad
};
inline constexpr ValueName kNavResetCauseNames[] = {{"none", NavResetCause::none},
                                                    {"first_heading", NavResetCause::first_heading},
                                                    {"heading", NavResetCause::heading},
                                                    {"gnss_return", NavResetCause::gnss_return},
                                                    {"imu_change", NavResetCause::imu_change},
                                                    {"declination", NavResetCause::declination},
                                                    {"measured_anew", NavResetCause::measured_anew},
                                                    {"large_step", NavResetCause::large_step}};

/// One source: what became of its measurements.
struct NavSourceState {
  Time last_fused;
  double test_ratio =
      0;  // squared normalised innovation over the gate, the largest of the newest measurement; > 1: refused
  std::uint32_t fused = 0, rejected = 0;
};

/// Published in the step of each jump, and ten times a second, once a GNSS or magnetometer sample has come.
struct NavReport {
  Time stamp;
  // The newest jump: what was added to the output in that step. With first_heading the world was turned by
  // reset_yaw_rad about its origin before, and the other values come on top.
  double reset_yaw_rad = 0;
  Vec3 reset_p_world_m, reset_v_world_mps;
  double heading_std_rad = 0;                                // one sigma; pi/sqrt(3) while nothing is known
  double bank_heading_rad = 0, bank_heading_std_rad = 0;     // by GNSS velocity alone; yaw as in NavState
  double origin_latitude_deg = 0, origin_longitude_deg = 0;  // of the world's origin; NaN before it is known
  double origin_altitude_m = 0;                              // above mean sea level
  Vec3 earth_field_t;                                        // world
  Vec3 body_field_t;                                         // base
  Vec3 wind_world_mps;                                       // horizontal
  double wind_std_mps = 0;
  std::array<NavSourceState, kNavSources> source{};
  NavResetCause reset_cause = NavResetCause::none;
  std::uint32_t resets = 0;         // jumps so far
  std::uint32_t heading_valid = 0;  // x is east, y is north
  std::uint32_t imu = 0;            // whose estimate this is: 0, 1, 2
  std::uint32_t gnss_pulled = 0;    // positions drift away from their own velocities: they are not used
  std::uint32_t mag_refused = 0;    // the magnetometer contradicts for so long that it counts as faulty
  std::uint32_t field_model_expired = 0;
  std::uint32_t reserved = 0;
};

template <>
struct Description<NavSourceState> {
  using M = NavSourceState;
  static constexpr std::string_view name = "NavSourceState", doc = "What became of one source of the estimator.";
  static constexpr auto fields =
      describe(field<&M::last_fused>("ns"), field<&M::test_ratio>("1", "above 1: the newest measurement was refused"),
               field<&M::fused>("1"), field<&M::rejected>("1"));
};

template <>
struct Description<NavReport> {
  using M = NavReport;
  static constexpr std::string_view name = "NavReport", doc = "Jumps of the estimate with their size, and its sources.";
  static constexpr auto fields = describe(
      field<&M::stamp>("ns"), field<&M::reset_yaw_rad>("rad", "of the newest jump"),
      field<&M::reset_p_world_m>("m", "likewise"), field<&M::reset_v_world_mps>("m/s", "likewise"),
      field<&M::heading_std_rad>("rad"), field<&M::bank_heading_rad>("rad", "by GNSS velocity alone"),
      field<&M::bank_heading_std_rad>("rad"), field<&M::origin_latitude_deg>("deg", "NaN: not known"),
      field<&M::origin_longitude_deg>("deg", "likewise"), field<&M::origin_altitude_m>("m", "above mean sea level"),
      field<&M::earth_field_t>("T", "world"), field<&M::body_field_t>("T", "base"),
      field<&M::wind_world_mps>("m/s", "horizontal"), field<&M::wind_std_mps>("m/s"),
      field<&M::source>("",
                        "by NavSource: gnss_position, gnss_velocity, gnss_height, mag, heading_bank, baro, range, "
                        "motion, pad, drag"),
      enum_field<&M::reset_cause>(kNavResetCauseNames), field<&M::resets>("1", "jumps so far"),
      field<&M::heading_valid>("1", "x is east, y is north"), field<&M::imu>("1", "whose estimate this is"),
      field<&M::gnss_pulled>("1", "positions drift away from their velocities"), field<&M::mag_refused>("1"),
      field<&M::field_model_expired>("1", "the World Magnetic Model 2025 is over"), field<&M::reserved>("1"));
};

}  // namespace sinew::msg
