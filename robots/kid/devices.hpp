#pragma once
#include "kinematics/limbs.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

inline constexpr int kKidImuSteps = 8;                         // 500 Hz, each physics step
inline constexpr int kKidJointSteps = 32;                      // 125 Hz: the servos' buses are read in turn
inline constexpr int kKidCameraSteps = 400;                    // 10 Hz
inline constexpr int kKidBatterySteps = 400;                   // 10 Hz
inline constexpr int kKidRefereeSteps = 2000;                  // 2 Hz, as RoboCup's game controller
inline constexpr std::int64_t kKidCameraDelayNs = 25'000'000;  // as the quadrotor's: exposure, read-out, USB
inline constexpr std::uint32_t kKidHeadJoints = 2, kKidArmJoints = 4, kKidLegJoints = 6;  // at most
inline constexpr std::array<std::uint32_t, kinematics::kLimbs> kKidLimbJoints{
    kKidHeadJoints, kKidArmJoints, kKidArmJoints, kKidLegJoints, kKidLegJoints};

/// The devices on board, in the order of the Welcome. Samples of joints, soles and IMU are older than they come by
/// their delays, which are options of the world.
inline constexpr WorldDevice kKidDevices[] = {
    {Part::imu, "imu", kKidImuSteps, 0, 0, FaultDevice::imu},
    {Part::soles, "soles", kKidJointSteps, 0, 0, FaultDevice::soles},
    {Part::battery, "battery", kKidBatterySteps, 5'000'000, 0, FaultDevice::battery},
    {Part::referee, "referee", kKidRefereeSteps, 2'000'000, 0, FaultDevice::referee},
    {Part::joints, "head_joints", kKidJointSteps, 0, kKidHeadJoints, FaultDevice::joints, 0, 0, FaultDevice::head},
    {Part::joints, "left_arm_joints", kKidJointSteps, 0, kKidArmJoints, FaultDevice::joints, 0, 0,
     FaultDevice::left_arm},
    {Part::joints, "right_arm_joints", kKidJointSteps, 0, kKidArmJoints, FaultDevice::joints, 0, 0,
     FaultDevice::right_arm},
    {Part::joints, "left_leg_joints", kKidJointSteps, 0, kKidLegJoints, FaultDevice::joints, 0, 0,
     FaultDevice::left_leg},
    {Part::joints, "right_leg_joints", kKidJointSteps, 0, kKidLegJoints, FaultDevice::joints, 0, 0,
     FaultDevice::right_leg},
    {Part::camera, "camera", kKidCameraSteps, kKidCameraDelayNs, 0, FaultDevice::camera},
    {Part::camera, "camera2", kKidCameraSteps, kKidCameraDelayNs, 0, FaultDevice::camera},
    {Part::actuators, "head", 0, 0, kKidHeadJoints, FaultDevice::head, -2, 2},
    {Part::actuators, "left_arm", 0, 0, kKidArmJoints, FaultDevice::left_arm, -2, 2},
    {Part::actuators, "right_arm", 0, 0, kKidArmJoints, FaultDevice::right_arm, -2, 2},
    {Part::actuators, "left_leg", 0, 0, kKidLegJoints, FaultDevice::left_leg, -2, 2},
    {Part::actuators, "right_leg", 0, 0, kKidLegJoints, FaultDevice::right_leg, -2, 2},
};
/// Of the world "soccer": its own options, those of bodies and ground, and those that several robots share.
std::span<const WorldOption> soccer_options();

}  // namespace sinew::plant
