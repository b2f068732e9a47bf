#include "sim_hil/usarsim/robot_class.hpp"

#include "sim_hil/usarsim/values.hpp"

namespace sinew::usarsim {
namespace {

constexpr double kRight = math::kPi / 2;

constexpr SensorMount sonar_at(const char* name, double yaw_deg) {
  // On the deck's edge; 0.2 s and 5 m: [USARSensor.SonarSensor].
  return {.type = SensorType::sonar,
          .name = name,
          .interval_s = 0.2,
          .p_base_m = {yaw_deg > 60 || yaw_deg < -60 ? 0.10 : 0.20, yaw_deg > 0 ? 0.12 : -0.12, 0.03},
          .yaw_rad = yaw_deg * math::kPi / 180,
          .most_m = 5};
}

// GroundTruth, GPS: 0.2 s, two decimals and GPS without a time, as in the captured session of an AirRobot. The rest,
// which that robot did not have, as DefaultUSAR.ini gives it to UDK's AirRobot, with a sonar that looks down.
constexpr SensorMount kAirRobotSensors[] = {
    {.type = SensorType::ground_truth, .name = "GroundTruth", .interval_s = 0.2, .decimals = 2},
    {.type = SensorType::gps, .name = "GPS", .interval_s = 0.2, .stamped = false, .p_base_m = {0, 0, 0.15}},
    {.type = SensorType::imu, .name = "IMU"},
    {.type = SensorType::acceleration, .name = "Accel"},
    {.type = SensorType::altitude, .name = "Altitude", .p_base_m = {0, 0, 0.15}},
    {.type = SensorType::sonar,
     .name = "D1",
     .interval_s = 0.2,
     .p_base_m = {0, 0, -0.05},
     .pitch_rad = kRight,
     .most_m = 5},
};

// [USARBot.P3AT] of DefaultUSAR.ini: GndTruth, InsTest, lms200, W1, W2; Odometer is there, too, but commented out.
constexpr SensorMount kP3atSensors[] = {
    {.type = SensorType::ground_truth, .name = "GndTruth", .decimals = 3},
    {.type = SensorType::ins, .name = "InsTest", .interval_s = 0.2, .stamped = false, .p_base_m = {0, 0, 0.2}},
    {.type = SensorType::range_scanner,
     .name = "lms200",
     .interval_s = 0.2,
     .p_base_m = {0.2085, 0, 0.2},
     .most_m = 20,
     .resolution_rad = 0.01745,
     .fov_rad = 3.14159},
    {.type = SensorType::odometry, .name = "Odometer"},
    {.type = SensorType::encoder, .name = "W1", .resolution_rad = 0.01745, .left = true},
    {.type = SensorType::encoder, .name = "W2", .resolution_rad = 0.01745},
    {.type = SensorType::touch, .name = "T1", .p_base_m = {0.26, 0, -0.05}},
    {.type = SensorType::imu, .name = "IMU"},
};

// As the manual's examples have it: eight sonars in front, a SICK laser, INS, odometry, encoders, GPS.
constexpr SensorMount kP2atSensors[] = {
    {.type = SensorType::ground_truth, .name = "GroundTruth", .interval_s = 0.2, .decimals = 2},
    sonar_at("F1", 90),
    sonar_at("F2", 50),
    sonar_at("F3", 30),
    sonar_at("F4", 10),
    sonar_at("F5", -10),
    sonar_at("F6", -30),
    sonar_at("F7", -50),
    sonar_at("F8", -90),
    {.type = SensorType::range_scanner,
     .name = "Scanner1",
     .interval_s = 0.2,
     .p_base_m = {0.2085, 0, 0.2},
     .most_m = 20,
     .resolution_rad = 0.01745,
     .fov_rad = 3.14159},
    {.type = SensorType::ins, .name = "INS", .interval_s = 0.2, .stamped = false},
    {.type = SensorType::odometry, .name = "Odometry", .interval_s = 0.2},
    {.type = SensorType::encoder, .name = "ECLeft", .interval_s = 0.2, .resolution_rad = 0.01745, .left = true},
    {.type = SensorType::encoder, .name = "ECRight", .interval_s = 0.2, .resolution_rad = 0.01745},
    {.type = SensorType::touch, .name = "Touch", .p_base_m = {0.26, 0, -0.05}},
    {.type = SensorType::gps, .name = "GPS", .interval_s = 0.2, .stamped = false, .p_base_m = {0, 0, 0.2}},
};

// Steered wheels: what P3AT has, and as it has it; the laser is on the front, the feeler before it.
constexpr SensorMount kSteeredSensors[] = {
    {.type = SensorType::ground_truth, .name = "GndTruth", .decimals = 3},
    {.type = SensorType::ins, .name = "InsTest", .interval_s = 0.2, .stamped = false, .p_base_m = {0, 0, 0.2}},
    {.type = SensorType::range_scanner,
     .name = "lms200",
     .interval_s = 0.2,
     .p_base_m = {0.40, 0, 0.2},
     .most_m = 20,
     .resolution_rad = 0.01745,
     .fov_rad = 3.14159},
    {.type = SensorType::odometry, .name = "Odometer"},
    {.type = SensorType::encoder, .name = "W1", .resolution_rad = 0.01745, .left = true},
    {.type = SensorType::encoder, .name = "W2", .resolution_rad = 0.01745},
    {.type = SensorType::touch, .name = "T1", .p_base_m = {0.58, 0, 0}},
    {.type = SensorType::imu, .name = "IMU"},
};

// Names of joints. The camera's links: UT2004's USARBot.ini mounts its camera on CameraPanTilt_Link2. Wheels: P3AT.uc,
// FrontAckerman.uc, BasicAckermanRobot.uc; P2AT's are those of UT2004.
constexpr JointName kCameraJointNames[] = {{"CameraPan", JointPart::pan},
                                           {"CameraTilt", JointPart::tilt},
                                           {"CameraPanTilt_Link1", JointPart::pan},
                                           {"CameraPanTilt_Link2", JointPart::tilt}};
constexpr JointName kP3atJoints[] = {{"FLWheelRoll", JointPart::left_wheel},
                                     {"BLWheelRoll", JointPart::left_wheel},
                                     {"FRWheelRoll", JointPart::right_wheel},
                                     {"BRWheelRoll", JointPart::right_wheel}};
constexpr JointName kP2atJoints[] = {{"LeftFWheel", JointPart::left_wheel},
                                     {"LeftRWheel", JointPart::left_wheel},
                                     {"RightFWheel", JointPart::right_wheel},
                                     {"RightRWheel", JointPart::right_wheel}};
constexpr JointName kFrontSteeredJoints[] = {
    {"FLFrontSteer", JointPart::front_steer}, {"FRFrontSteer", JointPart::front_steer},
    {"FLWheelRoll", JointPart::driven_wheel}, {"FRWheelRoll", JointPart::driven_wheel},
    {"BLWheelRoll", JointPart::driven_wheel}, {"BRWheelRoll", JointPart::driven_wheel}};
constexpr JointName kRearSteeredJoints[] = {
    {"BLRearSteer", JointPart::rear_steer},   {"BRRearSteer", JointPart::rear_steer},
    {"FLWheelRoll", JointPart::driven_wheel}, {"FRWheelRoll", JointPart::driven_wheel},
    {"BLWheelRoll", JointPart::driven_wheel}, {"BRWheelRoll", JointPart::driven_wheel}};

// 100 %: AirRobot.uc (maxLinearSpeed 2 m/s, maxRotationSpeed 100 deg/s); a Pioneer's 0.7 m/s.
constexpr RobotClass kClasses[] = {
    {"AirRobot",
     &plant::kAirRobot,
     kAirRobotSensors,
     2,
     1.7453293,
     "captured session; robocup-usarsim, DefaultUSAR.ini and AirRobot.uc",
     {}},
    {"P3AT", &plant::kP3at, kP3atSensors, 0, 6.4, "robocup-usarsim, DefaultUSAR.ini", kP3atJoints},
    {"P2AT", &plant::kP2at, kP2atSensors, 0, 6.4, "USARSim manual V3.1.3", kP2atJoints},
    {"FrontAckerman", &plant::kFrontSteered, kSteeredSensors, 0, 8, "robocup-usarsim, FrontAckerman.uc",
     kFrontSteeredJoints},
    {"BasicAckermanRobot", &plant::kRearSteered, kSteeredSensors, 0, 8, "robocup-usarsim, BasicAckermanRobot.uc",
     kRearSteeredJoints},
};

}  // namespace

std::string_view to_string(SensorType type) {
  switch (type) {
    case SensorType::ground_truth:
      return "GroundTruth";
    case SensorType::gps:
      return "GPS";
    case SensorType::ins:
      return "INS";
    case SensorType::imu:
      return "IMU";
    case SensorType::acceleration:
      return "Acceleration";
    case SensorType::sonar:
      return "Sonar";
    case SensorType::range_scanner:
      return "RangeScanner";
    case SensorType::odometry:
      return "Odometry";
    case SensorType::encoder:
      return "Encoder";
    case SensorType::touch:
      return "Touch";
    case SensorType::altitude:
      break;
  }
  return "AltitudeSensor";
}

std::span<const RobotClass> robot_classes() { return kClasses; }

const RobotClass* find_class(std::string_view name) {
  const auto dot = name.rfind('.');
  if (dot != std::string_view::npos) name.remove_prefix(dot + 1);
  for (const RobotClass& c : kClasses)
    if (same_word(c.name, name)) return &c;
  return nullptr;
}

const JointName* find_joint(const RobotClass& kind, std::string_view name) {
  for (const std::span<const JointName> joints : {kind.joints, std::span<const JointName>(kCameraJointNames)})
    for (const JointName& j : joints)
      if (same_word(j.name, name)) return &j;
  return nullptr;
}

std::string joint_names(const RobotClass& kind) {
  std::string all;
  for (const std::span<const JointName> joints : {kind.joints, std::span<const JointName>(kCameraJointNames)})
    for (const JointName& j : joints) all += (all.empty() ? "" : ", ") + std::string(j.name);
  return all;
}

std::string class_names() {
  std::string all;
  for (const RobotClass& c : kClasses) all += (all.empty() ? "USARBot." : ", USARBot.") + std::string(c.name);
  return all;
}

}  // namespace sinew::usarsim
