#pragma once
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sinew::app {

struct Series {
  std::string name;
  std::vector<std::pair<double, double>> points;  // not finite: a gap
};

struct Plot {
  std::string title, x_label, y_label;
  std::vector<Series> series;
};

/// A line plot as an SVG document, 900 x 420, at most about 2000 points a series drawn (minimum and maximum of each bin
/// are kept, so peaks stay visible).
std::string to_svg(const Plot& plot);

/// Several, one below the other.
std::string to_svg(std::span<const Plot> plots);

/// Round axis marks that cover [low, high], about `wanted` of them.
std::vector<double> axis_marks(double low, double high, int wanted = 6);

}  // namespace sinew::app
