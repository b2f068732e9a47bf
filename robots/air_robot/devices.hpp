#pragma once
#include "sim_hil/worlds/air.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// Channels of its actuator group: velocities in the axes of its heading (x forward, y left, z up) and of the yaw (to
/// the left), then where the camera's joints shall be (pan to the left, tilt downwards). Without a command it hovers.
enum AirRobotChannel : std::size_t {
  kAirForward_mps,
  kAirLeft_mps,
  kAirUp_mps,
  kAirTurn_radps,
  kAirPan_rad,
  kAirTilt_rad,
  kAirRobotChannels
};
inline constexpr std::size_t kAirCameraJoints = 2;       // pan, tilt
inline constexpr double kAirFocalPerHeight = 0.7945024;  // fx = fy: 80 degrees across a picture of 4 : 3

inline constexpr int kAirRangeSteps = 40, kAirBaroSteps = 80, kAirBatterySteps = 400, kAirJointSteps = 40;
/// The devices on board, in the order of the Welcome. The range finder looks down.
inline constexpr WorldDevice kAirRobotDevices[] = {
    {Part::imu, "imu", kImuSteps, kImuSteps* kStepNs / 2, 0, FaultDevice::imu},
    {Part::range, "range", kAirRangeSteps, 4'000'000, 0, FaultDevice::range},
    {Part::baro, "baro", kAirBaroSteps, 2'000'000, 0, FaultDevice::baro},
    {Part::joints, "camera_joints", kAirJointSteps, 500'000, kAirCameraJoints, FaultDevice::joints},
    {Part::camera, "camera", 0, 25'000'000, 0, FaultDevice::camera},
    {Part::actuators, "drone", 0, 0, kAirRobotChannels, FaultDevice::motors, -5, 5},
    {Part::battery, "battery", kAirBatterySteps, 5'000'000, 0, FaultDevice::battery},
};

inline constexpr std::size_t kPlaces = 4;
/// What a user may choose in the AirRobot's world.
inline constexpr auto kAirRobotWorldOptions = with_shared_world_options(std::to_array<WorldOption>({
    {"place", "place", "", 1, kPlaces, 1.0, "",
     "1: an arena with ramps, steps and obstacles, 2: the same arena empty, 3: a town with tall buildings, 4: the "
     "quadrotor's room",
     true},
    {"target_mps", "target-speed", "m/s", 0, 3, 0.4, "",
     "speed of the orange ball that goes round the place; 0: it stays where it starts"},
    {"gust_mps", "gust", "m/s", 0, 15, 0.0, "",
     "the wind with its gusts is never faster, unless wind_mps is; 0: no gusts, and still air without wind_mps"},
    {"wind_mps", "wind", "m/s", 0, 15, std::nullopt, "by the seed, up to half of gust_mps", "speed of the steady wind"},
    {"spread", "spread", "", 0, 1, 0.0, "",
     "1: where on its way the target begins, which way round it goes, and where the robots stand and look are drawn "
     "from the seed",
     true},
    {"goal", "goal", "", 0, 1, 0.0, "", "1: a run is good only if the target was kept in view and reached", true},
    {"start", "start", "", 1, kMostRobots, std::nullopt, "the robot's number", "number of the start pose", true, true},
    {"sensor_errors", "sensor-errors", "", 0, 1, 1.0, "", "0: all sensors tell the truth", true},
}));

}  // namespace sinew::plant
