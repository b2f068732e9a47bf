#pragma once
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

inline constexpr std::size_t kRotors = 4;
inline constexpr int kRangeSteps = 40, kBaroSteps = 80, kBatterySteps = 400;        // 100, 50, 10 Hz
inline constexpr std::int64_t kRangeDelayNs = 4'000'000, kBaroDelayNs = 2'000'000;  // stamp to availability
inline constexpr std::int64_t kCameraDelayNs =
    25'000'000;  // middle of the exposure to the driver: exposure, read-out, USB
inline constexpr std::int64_t kBatteryDelayNs = 5'000'000;
/// The devices on board, in the order of the Welcome.
inline constexpr WorldDevice kQuadDevices[] = {
    {Part::imu, "imu", kImuSteps, kImuSteps* kStepNs / 2, 0, FaultDevice::imu},
    {Part::range, "range", kRangeSteps, kRangeDelayNs, 0, FaultDevice::range},
    {Part::baro, "baro", kBaroSteps, kBaroDelayNs, 0, FaultDevice::baro},
    {Part::camera, "camera", 0, kCameraDelayNs, 0, FaultDevice::camera},
    {Part::actuators, "motors", 0, 0, kRotors, FaultDevice::motors, 0, 1},
    {Part::battery, "battery", kBatterySteps, kBatteryDelayNs, 0, FaultDevice::battery},
};

}  // namespace sinew::plant
