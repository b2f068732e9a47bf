#pragma once
// The classes of robots that clients may ask for, and what each has on board: names, places, intervals, and where that
// comes from.
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "sim_hil/places/vehicle_kind.hpp"

namespace sinew::usarsim {

enum class SensorType : std::uint8_t {
  ground_truth,
  gps,
  ins,
  imu,
  acceleration,
  sonar,
  range_scanner,
  odometry,
  encoder,
  touch,
  altitude,
};

/// "GroundTruth", as {Type ...} has it.
std::string_view to_string(SensorType type);

/// Frames:  REP-103: p_base in the vehicle's base, yaw to the left, pitch downwards.
struct SensorMount {
  SensorType type{};
  const char* name = "";
  double interval_s = 0.1;
  bool stamped = true;  // with {Time ...}
  int decimals = 4;     // of Location and Orientation
  math::Vec3 p_base_m{};
  double yaw_rad = 0, pitch_rad = 0;
  double most_m = 0;                       // beams
  double resolution_rad = 0, fov_rad = 0;  // scanner, encoder (a tick)
  bool left = false;                       // encoder: of the left wheels
};

/// What a joint that DRIVE {Name ...} and MULTIDRIVE name moves. Wheels of one side, and of a steered vehicle all
/// driven ones, turn together; so do the two wheels of an axle that steers.
enum class JointPart : std::uint8_t { pan, tilt, left_wheel, right_wheel, driven_wheel, front_steer, rear_steer };
struct JointName {
  const char* name = "";  // in any case
  JointPart part{};
};

struct RobotClass {
  const char* name = "";  // "AirRobot"; clients also write "USARBot.AirRobot"
  const plant::VehicleKind* kind = nullptr;
  std::span<const SensorMount> sensors;
  double normal_mps = 0, normal_radps = 0;  // what DRIVE's 100 % are: of velocities, of turning or of wheels
  const char* source = "";                  // of the table
  std::span<const JointName> joints{};      // besides the camera's, which all have
};

inline constexpr double kStatusInterval_s = 0.2;  // STA and MISSTA: the captured session
inline constexpr const char* kCameraName = "Camera";
inline constexpr const char* kPackageName = "CameraPanTilt";
inline constexpr double kPackageTorque = -20;  // as the captured session says, whatever it does
/// A sonar's cone. Source: DefaultUSAR.ini, [USARSensor.SonarSensor].
inline constexpr double kBeamAngle_rad = 0.349, kMostIncidence_rad = 0.1745329252, kSonarLeast_m = 0.1;
inline constexpr int kCones = 10, kTracesPerCone = 16;
/// Source: DefaultUSAR.ini: [USARSensor.RangeSensor]; Touch.uc; AltitudeSensor.uc (ASL).
inline constexpr double kScannerLeast_m = 0.1, kTouch_m = 0.05, kSeaLevel_m = 111;

std::span<const RobotClass> robot_classes();
/// By "AirRobot", "USARBot.AirRobot" and the like, in any case. Null: there is none.
const RobotClass* find_class(std::string_view name);
/// In any case. Null: it has no joint of this name.
const JointName* find_joint(const RobotClass& kind, std::string_view name);
/// "FLWheelRoll, ..., CameraPan, CameraTilt, ...".
std::string joint_names(const RobotClass& kind);
/// "USARBot.AirRobot, USARBot.P3AT, ...".
std::string class_names();

}  // namespace sinew::usarsim
