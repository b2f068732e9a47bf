#pragma once
// Messages between the modules that fly: estimate, setpoints, sightings, mission.
#include "msg/geometry.hpp"

namespace sinew::msg {

/// Output of the state estimator. World: z up, origin on the ground below the place where the filter started, x in the
/// vehicle's direction at that time.
struct NavState {
  Time stamp;
  Quat q_world_base;
  Vec3 v_world_mps;
  Vec3 p_world_m;
  Vec3 gyro_radps;       // bias-corrected, base
  Vec3 gyro_bias_radps;  // base
  Vec3 accel_bias_mps2;  // base
  Vec3 pad_world_m;      // centre of the landing pad, once known
  Time pad_stamp;        // of the newest image whose sighting was used
  double height_m = 0;   // above the ground under the vehicle
  double tilt_std_rad = 0;
  double p_std_m = 0;  // horizontal, 1 sigma
  double v_std_mps = 0;
  std::uint32_t attitude_valid = 0;
  std::uint32_t height_valid = 0;    // height and vertical speed
  std::uint32_t position_valid = 0;  // these and the horizontal ones
  std::uint32_t pad_known = 0;
  std::uint32_t at_rest = 0;      // stands still with stopped motors
  std::uint32_t ground_seen = 0;  // the range finder measures the height; otherwise barometer and pad carry it on
};

enum class FlightMode : std::uint32_t { idle = 0, velocity = 1, position = 2 };

inline constexpr ValueName kFlightModeNames[] = {
    {"idle", FlightMode::idle}, {"velocity", FlightMode::velocity}, {"position", FlightMode::position}};

/// What the mission wants from the position controller.
struct FlightSetpoint {
  Time stamp;
  Vec3 p_world_m;    // mode position
  Vec3 v_world_mps;  // mode velocity; feed-forward in mode position
  double yaw_rad = 0;
  FlightMode mode = FlightMode::idle;
  std::uint32_t armed = 0;
};

struct AttitudeSetpoint {
  Time stamp;
  Quat q_world_base;
  double thrust_n = 0;  // along base z
  std::uint32_t armed = 0;
  std::uint32_t reserved = 0;
};

/// Wrench wanted from the rotors, in the base frame.
struct WrenchSetpoint {
  Time stamp;
  Vec3 torque_nm;
  double thrust_n = 0;
  std::uint32_t armed = 0;
  std::uint32_t reserved = 0;
};

/// The landing pad in one image.
struct PadSighting {
  Time stamp;              // of the image
  Vec3 direction_optical;  // unit vector to the pad's centre, camera optical frame
  double u_px = 0, v_px = 0;
  double radius_px = 0;
  double range_m = 0;     // from the known size of the pad; NaN when not measurable
  double confidence = 0;  // 0..1
  std::uint32_t found = 0;
  std::uint32_t blobs = 0;
};

inline constexpr std::uint32_t kMotionColumns = 16, kMotionRows = 12;

/// Elementary motion detection over two consecutive frames, pooled to a grid.
struct MotionField {
  Time stamp;  // of the newer frame
  std::int64_t interval_ns = 0;
  double mean_x = 0, mean_y = 0;          // normalised correlator output; sign of motion to the right and down
  double speed_x_px = 0, speed_y_px = 0;  // estimate, pixels per frame
  double moving_fraction = 0;             // 0..1 of the cells
  std::array<float, kMotionColumns * kMotionRows> x{}, y{};
  std::uint32_t moving = 0;
  std::uint32_t reserved = 0;
};

enum class MissionPhase : std::uint32_t {
  wait = 0,
  arm = 1,
  climb = 2,
  search = 3,
  approach = 4,
  hold = 5,
  descend = 6,
  touchdown = 7,
  done = 8,
  abort = 9
};

inline constexpr ValueName kMissionPhaseNames[] = {
    {"wait", MissionPhase::wait},         {"arm", MissionPhase::arm},
    {"climb", MissionPhase::climb},       {"search", MissionPhase::search},
    {"approach", MissionPhase::approach}, {"hold", MissionPhase::hold},
    {"descend", MissionPhase::descend},   {"touchdown", MissionPhase::touchdown},
    {"done", MissionPhase::done},         {"abort", MissionPhase::abort}};

struct MissionState {
  Time stamp;
  Time phase_since;
  Vec3 target_world_m;
  MissionPhase phase = MissionPhase::wait;
  std::uint32_t pad_known = 0;
};

template <>
struct Description<NavState> {
  static constexpr std::string_view name = "NavState", doc = "Attitude, velocity, position and biases.";
  static constexpr auto fields = describe(
      field<&NavState::stamp>("ns"), field<&NavState::q_world_base>("1"), field<&NavState::v_world_mps>("m/s", "world"),
      field<&NavState::p_world_m>("m", "world"), field<&NavState::gyro_radps>("rad/s", "base, bias-corrected"),
      field<&NavState::gyro_bias_radps>("rad/s"), field<&NavState::accel_bias_mps2>("m/s^2"),
      field<&NavState::pad_world_m>("m", "world, once known"), field<&NavState::pad_stamp>("ns", "image used last"),
      field<&NavState::height_m>("m", "above ground"), field<&NavState::tilt_std_rad>("rad"),
      field<&NavState::p_std_m>("m"), field<&NavState::v_std_mps>("m/s"), field<&NavState::attitude_valid>("1"),
      field<&NavState::height_valid>("1"), field<&NavState::position_valid>("1"), field<&NavState::pad_known>("1"),
      field<&NavState::at_rest>("1"), field<&NavState::ground_seen>("1", "by the range finder"));
};

template <>
struct Description<FlightSetpoint> {
  static constexpr std::string_view name = "FlightSetpoint", doc = "What the mission wants from the position loop.";
  static constexpr auto fields =
      describe(field<&FlightSetpoint::stamp>("ns"), field<&FlightSetpoint::p_world_m>("m", "world"),
               field<&FlightSetpoint::v_world_mps>("m/s", "world"), field<&FlightSetpoint::yaw_rad>("rad"),
               enum_field<&FlightSetpoint::mode>(kFlightModeNames), field<&FlightSetpoint::armed>("1"));
};

template <>
struct Description<AttitudeSetpoint> {
  static constexpr std::string_view name = "AttitudeSetpoint", doc = "Attitude and thrust wanted.";
  static constexpr auto fields =
      describe(field<&AttitudeSetpoint::stamp>("ns"), field<&AttitudeSetpoint::q_world_base>("1"),
               field<&AttitudeSetpoint::thrust_n>("N", "along base z"), field<&AttitudeSetpoint::armed>("1"),
               field<&AttitudeSetpoint::reserved>("1"));
};

template <>
struct Description<WrenchSetpoint> {
  static constexpr std::string_view name = "WrenchSetpoint", doc = "Torque and thrust wanted from the rotors.";
  static constexpr auto fields =
      describe(field<&WrenchSetpoint::stamp>("ns"), field<&WrenchSetpoint::torque_nm>("N m", "base"),
               field<&WrenchSetpoint::thrust_n>("N", "along base z"), field<&WrenchSetpoint::armed>("1"),
               field<&WrenchSetpoint::reserved>("1"));
};

template <>
struct Description<PadSighting> {
  static constexpr std::string_view name = "PadSighting", doc = "The landing pad in one image.";
  static constexpr auto fields = describe(
      field<&PadSighting::stamp>("ns"), field<&PadSighting::direction_optical>("1", "unit vector, optical frame"),
      field<&PadSighting::u_px>("px"), field<&PadSighting::v_px>("px"), field<&PadSighting::radius_px>("px"),
      field<&PadSighting::range_m>("m", "NaN when not measurable"), field<&PadSighting::confidence>("1"),
      field<&PadSighting::found>("1"), field<&PadSighting::blobs>("1"));
};

template <>
struct Description<MotionField> {
  static constexpr std::string_view name = "MotionField", doc = "Elementary motion detection, pooled to a grid.";
  static constexpr auto fields =
      describe(field<&MotionField::stamp>("ns"), field<&MotionField::interval_ns>("ns"),
               field<&MotionField::mean_x>("1"), field<&MotionField::mean_y>("1"),
               field<&MotionField::speed_x_px>("px", "per frame"), field<&MotionField::speed_y_px>("px", "per frame"),
               field<&MotionField::moving_fraction>("1"), field<&MotionField::x>("1"), field<&MotionField::y>("1"),
               field<&MotionField::moving>("1"), field<&MotionField::reserved>("1"));
};

template <>
struct Description<MissionState> {
  static constexpr std::string_view name = "MissionState", doc = "Where the mission is.";
  static constexpr auto fields =
      describe(field<&MissionState::stamp>("ns"), field<&MissionState::phase_since>("ns"),
               field<&MissionState::target_world_m>("m", "world"), enum_field<&MissionState::phase>(kMissionPhaseNames),
               field<&MissionState::pad_known>("1"));
};

}  // namespace sinew::msg
