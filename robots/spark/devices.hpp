#pragma once
#include "robots/kid/devices.hpp"

namespace sinew::plant {

inline constexpr int kSparkSteps = 80;  // 50 Hz: the server's cycle of 20 ms

/// What SimSpark's Nao has, as devices of the kid's names: all come with the percepts of a cycle, without a delay.
/// Temperatures, efforts and voltages are not measured (NaN), and there is no battery.
inline constexpr WorldDevice kSparkDevices[] = {
    {Part::imu, "imu", kSparkSteps, 0, 0, FaultDevice::imu},
    {Part::soles, "soles", kSparkSteps, 0, 0, FaultDevice::soles},
    {Part::referee, "referee", kSparkSteps, 0, 0, FaultDevice::referee},
    {Part::joints, "head_joints", kSparkSteps, 0, kKidHeadJoints, FaultDevice::joints, 0, 0, FaultDevice::head},
    {Part::joints, "left_arm_joints", kSparkSteps, 0, kKidArmJoints, FaultDevice::joints, 0, 0, FaultDevice::left_arm},
    {Part::joints, "right_arm_joints", kSparkSteps, 0, kKidArmJoints, FaultDevice::joints, 0, 0,
     FaultDevice::right_arm},
    {Part::joints, "left_leg_joints", kSparkSteps, 0, kKidLegJoints, FaultDevice::joints, 0, 0, FaultDevice::left_leg},
    {Part::joints, "right_leg_joints", kSparkSteps, 0, kKidLegJoints, FaultDevice::joints, 0, 0,
     FaultDevice::right_leg},
    {Part::actuators, "head", 0, 0, kKidHeadJoints, FaultDevice::head, -2.1, 2.1},
    {Part::actuators, "left_arm", 0, 0, kKidArmJoints, FaultDevice::left_arm, -2.1, 2.1},
    {Part::actuators, "right_arm", 0, 0, kKidArmJoints, FaultDevice::right_arm, -2.1, 2.1},
    {Part::actuators, "left_leg", 0, 0, kKidLegJoints, FaultDevice::left_leg, -2.3, 2.3},
    {Part::actuators, "right_leg", 0, 0, kKidLegJoints, FaultDevice::right_leg, -2.3, 2.3},
};
/// Of the world "simspark": who the agent is, and where it beams to.
std::span<const WorldOption> spark_options();

}  // namespace sinew::plant
