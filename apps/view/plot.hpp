#pragma once
// Line plots: one drawing of them for SVG and PNG, and for every command that plots.
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sinew::app {

struct Series {
  std::string name{};
  std::vector<std::pair<double, double>> points{};  // not finite: a gap
  bool stepped = false;                             // keeps its value until the next point
};

/// Something that happened: a line across the plot, with its text above.
struct PlotMark {
  double x = 0;
  std::string text{};  // empty: only the line
  bool alarm = false;  // drawn in red
};

struct Plot {
  std::string title{}, x_label{}, y_label{};
  std::vector<Series> series{};
  std::vector<PlotMark> marks{};
  std::map<double, std::string> y_names{};             // of values that have names; shown in place of numbers
  std::optional<std::pair<double, double>> x_range{};  // else that of the points
};

/// A line plot as an SVG document, 900 wide, at most about 2000 points a series drawn (minimum and maximum of each bin
/// are kept, so peaks stay visible). Texts of marks that would lie over each other go into further rows; what has no
/// room in four rows is left out, its line stays.
std::string to_svg(const Plot& plot);

/// Several, one below the other.
std::string to_svg(std::span<const Plot> plots);

/// The same as a PNG file, two pixels for each px. Empty, with `why`: it cannot be made.
std::string to_png(std::span<const Plot> plots, std::string& why);

/// Empty when write_plots() knows the kind of file by its name; else what is allowed, for an option's check.
std::string why_no_plot_file(const std::string& path);

/// Draws into a file, which is replaced if it exists. Empty when it is written; else why not, with the path.
std::string write_plots(const std::string& path, std::span<const Plot> plots);

/// Round axis marks that cover [low, high], about `wanted` of them.
std::vector<double> axis_marks(double low, double high, int wanted = 6);

}  // namespace sinew::app
