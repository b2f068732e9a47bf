#include "soccer/field.hpp"

#include "math/elementary.hpp"

namespace sinew::soccer {

using msg::FieldMark;

Field::Field(const FieldSize& f) : size_(f) {
  const double x = f.length_m / 2, y = f.width_m / 2, post = f.goal_width_m / 2;
  std::size_t lines = 0, corners = 0;
  const auto line = [&](FieldPoint from, FieldPoint to) { lines_[lines++] = {from, to}; };
  const auto corner = [&](FieldPoint at, double heading_rad, FieldMark kind) {
    corners_[corners++] = {at, heading_rad, kind};
  };
  line({0, -y}, {0, y});
  corner({0, f.circle_radius_m}, math::kPi / 2, FieldMark::corner_x);
  corner({0, -f.circle_radius_m}, math::kPi / 2, FieldMark::corner_x);
  for (const double up : {-1.0, 1.0}) {
    line({-x, up * y}, {x, up * y});
    corner({0, up * y}, -up * math::kPi / 2, FieldMark::corner_t);
  }
  for (const double side : {-1.0, 1.0}) {
    const double inwards_rad = side > 0 ? math::kPi : 0;
    line({side * x, -y}, {side * x, y});
    for (const double up : {-1.0, 1.0}) corner({side * x, up * y}, math::atan2(-up, -side), FieldMark::corner_l);
    const auto area = [&](double length_m, double width_m) {
      const double inner = side * (x - length_m), half = width_m / 2;
      line({inner, -half}, {inner, half});
      for (const double up : {-1.0, 1.0}) {
        line({inner, up * half}, {side * x, up * half});
        corner({side * x, up * half}, inwards_rad, FieldMark::corner_t);
        corner({inner, up * half}, math::atan2(-up, side), FieldMark::corner_l);
      }
    };
    area(f.goal_area_length_m, f.goal_area_width_m);
    area(f.penalty_area_length_m, f.penalty_area_width_m);
  }
  posts_ = {FieldPoint{x, post}, {x, -post}, {-x, post}, {-x, -post}};
  marks_ = {FieldPoint{x - f.penalty_mark_m, 0}, {f.penalty_mark_m - x, 0}, {0, 0}};
}

bool Field::holds(const FieldPoint& p, double margin_m) const {
  return math::fabs(p.x_m) <= size_.length_m / 2 + margin_m && math::fabs(p.y_m) <= size_.width_m / 2 + margin_m;
}

}  // namespace sinew::soccer
