#pragma once
#include "sim_hil/worlds/air.hpp"
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
inline constexpr std::size_t kMostQuads = 4;  // in one room
inline constexpr double kClear_m = 1.2;       // no obstacle is nearer to the pad, along either axis (room.xml)
/// What a user may choose in the quadrotor's world.
inline constexpr auto kQuadWorldOptions = with_shared_world_options(std::to_array<WorldOption>({
    {"gust_mps", "gust", "m/s", 0, 15, 2.0, "",
     "the wind with its gusts is never faster, unless wind_mps is; 0: no gusts, and still air without wind_mps"},
    {"wind_mps", "wind", "m/s", 0, 15, std::nullopt, "by the seed, up to half of gust_mps", "speed of the steady wind"},
    {"wind_toward_deg", "wind-toward", "deg", -360, 360, std::nullopt, "by the seed",
     "where the steady wind blows to, counter-clockwise from east (the world's x)"},
    {"start_offset_m", "start-offset", "m", 0, 3, 1.0, "", "largest distance of the start from the pad"},
    {"start_x_m", "start-x", "m", -kClear_m, kClear_m, std::nullopt, "by the seed, within start_offset_m",
     "where the vehicle starts, east of the pad's centre", false, true},
    {"start_y_m", "start-y", "m", -kClear_m, kClear_m, std::nullopt, "by the seed, within start_offset_m",
     "where the vehicle starts, north of the pad's centre", false, true},
    {"start_yaw_deg", "start-yaw", "deg", -180, 180, std::nullopt, "by the seed, up to 17 either way",
     "heading at the start, counter-clockwise from east", false, true},
    {"land_x_m", "land-x", "m", -kClear_m, kClear_m, 0.0, "",
     "where the vehicle shall land, east of the pad's centre: the landing error counts from there", false, true},
    {"land_y_m", "land-y", "m", -kClear_m, kClear_m, 0.0, "", "where the vehicle shall land, north of the pad's centre",
     false, true},
    {"battery_charge", "battery-charge", "", 0.05, 1, std::nullopt, "by the seed, from 0.85 to 1",
     "share of the battery's charge at the start", false, true},
    {"spread", "spread", "", 0, 0.3, 0.05, "", "of mass and each motor's thrust, as a share, either way"},
    {"sensor_errors", "sensor-errors", "", 0, 1, 1.0, "", "0: all sensors tell the truth", true},
}));

}  // namespace sinew::plant
