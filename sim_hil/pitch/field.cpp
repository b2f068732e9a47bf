#include "sim_hil/pitch/field.hpp"

namespace sinew::plant {

std::vector<FieldLine> field_lines(const FieldSize& f) {
  const double x = (f.length_m - f.line_m) / 2, y = (f.width_m - f.line_m) / 2;
  std::vector<FieldLine> all{{-x, -y, x, -y}, {-x, y, x, y}, {-x, -y, -x, y}, {x, -y, x, y}, {0, -y, 0, y}};
  const double mark = f.mark_m / 2;
  all.push_back({-mark, 0, mark, 0});
  for (const double side : {-1.0, 1.0}) {
    const auto area = [&](double length_m, double width_m) {
      const double inner = side * (x - length_m), half = (width_m - f.line_m) / 2;
      all.push_back({inner, -half, inner, half});
      all.push_back({inner, half, side * x, half});
      all.push_back({inner, -half, side * x, -half});
    };
    area(f.goal_area_length_m, f.goal_area_width_m);
    area(f.penalty_area_length_m, f.penalty_area_width_m);
    const double spot = side * (x - f.penalty_mark_m);
    all.push_back({spot - mark, 0, spot + mark, 0});
    all.push_back({spot, -mark, spot, mark});
  }
  return all;
}

}  // namespace sinew::plant
