#pragma once
// The field as a robot knows it: its lines, corners, posts. Frame "field" of msg/soccer.hpp: the middle is 0, x towards
// the other team's goal. The field is the same when it is turned by half a turn about its middle.
// Thread:  any.   RT: yes, after the constructor.
#include <array>
#include <span>

#include "math/elementary.hpp"
#include "msg/soccer.hpp"

namespace sinew::soccer {

/// Units:   m. All are between the middles of lines and posts, where nothing else is said.
/// Source:  RoboCup Soccer Humanoid League, Laws of the Game 2021, Law 1 (KidSize): outer edges of the outer lines are
///          9 m x 6 m apart, lines are 5 cm wide, goals have 2.6 m between their posts of 10 cm.
struct FieldSize {
  double length_m = 8.95, width_m = 5.95;
  double goal_width_m = 2.7;
  double goal_area_length_m = 1, goal_area_width_m = 2.95;
  double penalty_area_length_m = 2, penalty_area_width_m = 4.95;
  double penalty_mark_m = 1.5;  // from the goal line
  double circle_radius_m = 0.75;
  double border_m = 1;  // carpet outside of the outer lines
};

struct FieldPoint {
  double x_m, y_m;
  friend constexpr FieldPoint operator+(const FieldPoint& a, const FieldPoint& b) {
    return {a.x_m + b.x_m, a.y_m + b.y_m};
  }
  friend constexpr FieldPoint operator-(const FieldPoint& a, const FieldPoint& b) {
    return {a.x_m - b.x_m, a.y_m - b.y_m};
  }
  friend constexpr FieldPoint operator*(double s, const FieldPoint& a) { return {s * a.x_m, s * a.y_m}; }
};
inline double length_m(const FieldPoint& a) { return math::hypot(a.x_m, a.y_m); }
inline double bearing_rad(const FieldPoint& a) { return math::atan2(a.y_m, a.x_m); }

/// The middle of a painted line.
struct FieldLine {
  FieldPoint from, to;
};

/// Headings as those of msg::SeenMark.
struct FieldCorner {
  FieldPoint at;
  double heading_rad;
  msg::FieldMark kind;  // corner_l, corner_t or corner_x
};

class Field {
 public:
  explicit Field(const FieldSize& size = {});

  const FieldSize& size() const { return size_; }
  std::span<const FieldLine> lines() const { return lines_; }        // the straight ones
  std::span<const FieldCorner> corners() const { return corners_; }  // also where the halfway line crosses the circle
  std::span<const FieldPoint, 4> posts() const { return posts_; }
  std::span<const FieldPoint, 3> penalty_marks() const { return marks_; }  // of both goals, and the middle
  /// Inside of the outer lines, or out by at most this much.
  bool holds(const FieldPoint& p, double margin_m = 0) const;

 private:
  FieldSize size_;
  std::array<FieldLine, 17> lines_;
  std::array<FieldCorner, 24> corners_;
  std::array<FieldPoint, 4> posts_;
  std::array<FieldPoint, 3> marks_;
};

}  // namespace sinew::soccer
