#pragma once
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

inline constexpr std::size_t kHeadJoints = 2;                   // pan, tilt
inline constexpr int kJointSteps = 8;                           // 500 Hz
inline constexpr std::int64_t kJointsDelayNs = 500'000;         // a poll over a field bus
inline constexpr std::int64_t kHeadCameraDelayNs = 25'000'000;  // as the quadrotor's: exposure, read-out, USB

/// The devices on board, in the order of the Welcome.
inline constexpr WorldDevice kHeadDevices[] = {
    {Part::imu, "imu", kImuSteps, kImuSteps* kStepNs / 2, 0, FaultDevice::imu},
    {Part::joints, "joints", kJointSteps, kJointsDelayNs, kHeadJoints, FaultDevice::joints},
    {Part::camera, "camera", 0, kHeadCameraDelayNs, 0, FaultDevice::camera},
    {Part::actuators, "head", 0, 0, kHeadJoints, FaultDevice::head, -1.4, 1.4},
};

}  // namespace sinew::plant
