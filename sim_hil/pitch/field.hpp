#pragma once
// The field that humanoids of KidSize play on.
// Frames:  x along the field towards the right goal, y to the left of it, z up; the middle of the field is 0.
#include <vector>

namespace sinew::plant {

/// Source:  RoboCup Soccer Humanoid League, Laws of the Game 2021, Law 1 (KidSize): field A to K, goals; lines 5 cm.
/// The
///          length of a mark's strokes is not in the rules; it is that of the league's own simulation of 2021.
struct FieldSize {
  double length_m = 9, width_m = 6;
  double goal_depth_m = 0.6, goal_width_m = 2.6, goal_height_m = 1.2;  // width between the posts
  double post_radius_m = 0.05;
  double goal_area_length_m = 1, goal_area_width_m = 3;
  double penalty_area_length_m = 2, penalty_area_width_m = 5;
  double penalty_mark_m = 1.5;  // from the goal line
  double circle_diameter_m = 1.5;
  double border_m = 1;  // of the carpet, outside of the lines
  double line_m = 0.05;
  double mark_m = 0.2;  // length of the strokes of a mark
};
inline constexpr FieldSize kKidField{};

/// A painted strip, parallel to an axis.
struct FieldLine {
  double x0_m, y0_m, x1_m, y1_m;  // of its middle line
};
/// All straight lines of a field. Outer edges of the outer lines are length x width apart.
std::vector<FieldLine> field_lines(const FieldSize& size);

/// Source:  Law 2: FIFA size 1.
struct BallSize {
  double radius_m = 0.07, mass_kg = 0.2;
};
inline constexpr BallSize kKidBall{};

}  // namespace sinew::plant
