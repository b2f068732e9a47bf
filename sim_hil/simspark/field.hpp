#pragma once
// The field of RoboCup's 3D soccer simulation.
// Frames:  x from the left goal to the right one, y to the left of it, z up; the middle is 0.
#include <array>
#include <string_view>
#include <vector>

#include "math/linear.hpp"
#include "sim_hil/pitch/field.hpp"

namespace sinew::simspark {

/// Source:  rcssserver3d, naosoccersim.rb; its lines have no width of their own.
inline constexpr plant::FieldSize kSparkField{.length_m = 30,
                                              .width_m = 20,
                                              .goal_depth_m = 0.6,
                                              .goal_width_m = 2.1,
                                              .goal_height_m = 0.8,
                                              .post_radius_m = 0.02,
                                              .goal_area_length_m = 1.8,
                                              .goal_area_width_m = 6,
                                              .penalty_area_length_m = 1.8,
                                              .penalty_area_width_m = 6,
                                              .penalty_mark_m = 1.8,
                                              .circle_diameter_m = 4,
                                              .border_m = 1};
inline constexpr plant::BallSize kSparkBall{.radius_m = 0.042, .mass_kg = 0.026};

struct Landmark {
  std::string_view name;
  math::Vec3 at_m;
};
inline constexpr std::array<Landmark, 8> kLandmarks{{
    {"F1L", {-15, 10, 0}},
    {"F2L", {-15, -10, 0}},
    {"F1R", {15, 10, 0}},
    {"F2R", {15, -10, 0}},
    {"G1L", {-15, 1.05, 0.8}},
    {"G2L", {-15, -1.05, 0.8}},
    {"G1R", {15, 1.05, 0.8}},
    {"G2R", {15, -1.05, 0.8}},
}};

struct SparkLine {
  math::Vec3 from_m, to_m;
};
/// Outer lines, middle line, penalty areas, and the circle as ten straight lines: 21.
const std::vector<SparkLine>& spark_lines();

}  // namespace sinew::simspark
