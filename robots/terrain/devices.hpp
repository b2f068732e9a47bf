#pragma once
#include "robots/quad/devices.hpp"

namespace sinew::plant {

/// What a user may choose in the terrain's world; on board is what the quadrotor has: kQuadDevices.
inline constexpr auto kTerrainWorldOptions = std::to_array<WorldOption>({
    {"terrain", "terrain", "", 1, 3, 1.0, "", "1: hills, 2: steps, 3: buildings with ramps", true},
    {"motion_radps", "motion", "rad/s", 0.1, 5, 0.75, "",
     "the ground's motion that the vehicle is meant to hold: the right height is its speed over ground divided by "
     "this"},
    {"gust_mps", "gust", "m/s", 0, 15, 0.3, "",
     "the wind with its gusts is never faster, unless wind_mps is; 0: no gusts, and still air without wind_mps"},
    {"wind_mps", "wind", "m/s", 0, 15, std::nullopt, "by the seed, up to half of gust_mps", "speed of the steady wind"},
    {"wind_toward_deg", "wind-toward", "deg", -360, 360, std::nullopt, "by the seed",
     "where the steady wind blows to; 180 is a head wind"},
    {"battery_charge", "battery-charge", "", 0.05, 1, std::nullopt, "by the seed, from 0.85 to 1",
     "share of the battery's charge at the start"},
    {"spread", "spread", "", 0, 0.3, 0.05, "", "of mass and each motor's thrust, as a share, either way"},
    {"sensor_errors", "sensor-errors", "", 0, 1, 1.0, "", "0: all sensors tell the truth", true},
});

}  // namespace sinew::plant
