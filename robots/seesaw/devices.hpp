#pragma once
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// What the seesaw has on board: an IMU on its beam, and one motor in its hinge.
inline constexpr WorldDevice kSeesawDevices[] = {
    {Part::imu, "imu", kImuSteps, kImuSteps* kStepNs / 2, 0, FaultDevice::imu},
    {Part::actuators, "motor", 0, 0, 1, FaultDevice::motors, -1, 1},
};
/// What a user may choose in its world.
inline constexpr WorldOption kSeesawWorldOptions[] = {
    {"push_radps2", "push", "rad/s^2", 0, 5, 0.2, "", "leans on the beam every other 2 s"},
};

}  // namespace sinew::plant
