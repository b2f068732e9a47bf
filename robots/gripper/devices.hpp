#pragma once
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

inline constexpr int kGripperImuSteps = 16, kGripperJointSteps = 40, kGripperCameraSteps = 200;  // 250, 100, 20 Hz
inline constexpr std::int64_t kGripperCameraDelayNs = 25'000'000;  // as the quadrotor's: exposure, read-out, USB

/// The motor of the gripper turns a screw that moves both paddles. 0: open.
/// Source:  ours.
inline constexpr double kGripperLead_m_per_rad = 0.01;
inline constexpr double kGripperMost_rad = 10.75;  // closed: each paddle has moved by half of 0.215 m

/// The devices on board, in the order of the Welcome: channels of "wheels" and "wheel_joints" are left and right, in
/// rad/s and rad; the channel of "gripper" is the angle of its motor. Without a command wheels roll, and the gripper
/// gives no force.
inline constexpr WorldDevice kGripperDevices[] = {
    {Part::imu, "imu", kGripperImuSteps, 0, 0, FaultDevice::imu},
    {Part::joints, "wheel_joints", kGripperJointSteps, 0, 2, FaultDevice::joints, 0, 0, FaultDevice::motors},
    {Part::joints, "gripper_joint", kGripperJointSteps, 0, 1, FaultDevice::joints, 0, 0, FaultDevice::gripper},
    {Part::camera, "camera", kGripperCameraSteps, kGripperCameraDelayNs, 0, FaultDevice::camera},
    {Part::actuators, "wheels", 0, 0, 2, FaultDevice::motors, -20, 20},
    {Part::actuators, "gripper", 0, 0, 1, FaultDevice::gripper, 0, kGripperMost_rad},
};

/// What a user may choose in its world: its own options, and those of the pitch that mean something for wheels.
std::span<const WorldOption> gripper_options();

}  // namespace sinew::plant
