#include "sim_hil/simspark/field.hpp"

#include "math/elementary.hpp"

namespace sinew::simspark {

const std::vector<SparkLine>& spark_lines() {
  static const std::vector<SparkLine> all = [] {
    std::vector<SparkLine> lines;
    const double x = kSparkField.length_m / 2, y = kSparkField.width_m / 2;
    const double area = kSparkField.penalty_area_width_m / 2;
    lines.push_back({{0, -y, 0}, {0, y, 0}});
    for (const double side : {1.0, -1.0}) {
      lines.push_back({{side * x, -y, 0}, {side * x, y, 0}});
      lines.push_back({{-x, side * y, 0}, {x, side * y, 0}});
      const double inner = side * (x - kSparkField.penalty_area_length_m);
      lines.push_back({{inner, -area, 0}, {inner, area, 0}});
      for (const double end : {1.0, -1.0}) lines.push_back({{inner, end * area, 0}, {side * x, end * area, 0}});
    }
    constexpr int kOfCircle = 10;
    const auto of_circle = [](int i) {
      const auto at = math::sincos(2 * math::kPi * i / kOfCircle);
      const double r = kSparkField.circle_diameter_m / 2;
      return math::Vec3{r * at.cos, r * at.sin, 0};
    };
    for (int i = 0; i < kOfCircle; ++i) lines.push_back({of_circle(i), of_circle((i + 1) % kOfCircle)});
    return lines;
  }();
  return all;
}

}  // namespace sinew::simspark
