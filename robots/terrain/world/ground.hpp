#pragma once
#include <cstdint>
#include <string>

namespace sinew::plant {

/// Ground to fly over, each in a lane of its own of the same room, along x.
enum class Terrain : std::uint8_t { hills = 1, steps = 2, buildings = 3 };

inline constexpr double kCourseBegin_m = 16, kCourseEnd_m = 88;  // before and behind it the ground is flat
inline constexpr double kLaneHalfWidth_m = 12;

/// The y of the middle of its lane.
double lane_m(Terrain terrain);

/// Height of the ground above the place of the start; `across_m` from the middle of the lane.
/// Hills: up to 1.3 m, slopes up to 1 : 2. Steps: up to 0.4 m at once, a fifth of a height of 2 m. Buildings:
/// roofs of up to 3 m, reached and left over ramps of 1 : 4.
double ground_m(Terrain terrain, double x_m, double across_m);

/// MuJoCo's XML: the vehicle as the quadrotor's room describes it, over all three lanes.
std::string terrain_room();

}  // namespace sinew::plant
