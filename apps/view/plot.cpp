#include "apps/view/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sinew::app {
namespace {

constexpr double kWidth = 900, kHeight = 420, kLeft = 70, kRight = 20, kTop = 40, kBottom = 50;
constexpr std::size_t kBins = 1000;
constexpr std::array kColours{"#1f5fa8", "#d1495b", "#2e8b57", "#8a5fbf", "#b8860b", "#555555"};

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void include(double v) {
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
  void widen() {
    if (low > high) low = 0, high = 1;
    if (low == high) low -= 0.5, high += 0.5;
  }
};

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else
      out += c;
  }
  return out;
}

// Keeps the smallest and largest point of each bin, in their order.
std::vector<std::pair<double, double>> thinned(const std::vector<std::pair<double, double>>& points) {
  if (points.size() <= 2 * kBins) return points;
  std::vector<std::pair<double, double>> kept;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const auto first = points.begin() + static_cast<std::ptrdiff_t>(bin * points.size() / kBins);
    const auto last = points.begin() + static_cast<std::ptrdiff_t>((bin + 1) * points.size() / kBins);
    auto [low, high] = std::minmax_element(first, last, [](auto& a, auto& b) { return a.second < b.second; });
    if (high < low) std::swap(low, high);
    kept.push_back(*low);
    if (high != low) kept.push_back(*high);
  }
  return kept;
}

/// The inside of an SVG document of kWidth x kHeight.
std::string drawn(const Plot& plot) {
  Range x, y;
  for (const auto& s : plot.series)
    for (const auto& [px, py] : s.points) x.include(px), y.include(py);
  x.widen();
  y.widen();
  const auto at_x = [&](double v) { return kLeft + (v - x.low) / (x.high - x.low) * (kWidth - kLeft - kRight); };
  const auto at_y = [&](double v) {
    return kHeight - kBottom - (v - y.low) / (y.high - y.low) * (kHeight - kTop - kBottom);
  };
  std::string out = fmt::format(
      "<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n"
      "<text x=\"{2}\" y=\"24\" font-size=\"16\">{3}</text>\n",
      kWidth, kHeight, kLeft, escaped(plot.title));
  for (const double m : axis_marks(x.low, x.high, 10))
    out += fmt::format(
        "<path d=\"M{0:.1f} {1}V{2}\" stroke=\"#ddd\"/><text x=\"{0:.1f}\" y=\"{3}\" "
        "text-anchor=\"middle\">{4:g}</text>\n",
        at_x(m), kTop, kHeight - kBottom, kHeight - kBottom + 18, m);
  for (const double m : axis_marks(y.low, y.high))
    out += fmt::format(
        "<path d=\"M{1} {0:.1f}H{2}\" stroke=\"#ddd\"/><text x=\"{3}\" y=\"{4:.1f}\" "
        "text-anchor=\"end\">{5:g}</text>\n",
        at_y(m), kLeft, kWidth - kRight, kLeft - 6, at_y(m) + 4, m);
  out += fmt::format(
      "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n"
      "<text x=\"18\" y=\"{}\" text-anchor=\"middle\" transform=\"rotate(-90 18 {})\">{}</text>\n",
      (kLeft + kWidth - kRight) / 2, kHeight - 12, escaped(plot.x_label), kHeight / 2, kHeight / 2,
      escaped(plot.y_label));
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const char* colour = kColours[i % kColours.size()];
    std::string path;
    bool pen_up = true;
    for (const auto& [px, py] : thinned(plot.series[i].points)) {
      const bool good = std::isfinite(px) && std::isfinite(py);
      if (good) path += fmt::format("{}{:.1f} {:.1f}", pen_up ? "M" : "L", at_x(px), at_y(py));
      pen_up = !good;
    }
    out += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.3\"/>\n", path, colour);
    out += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"end\" fill=\"{}\">{}</text>\n", kWidth - kRight - 8,
                       kTop + 18 + 18 * static_cast<double>(i), colour, escaped(plot.series[i].name));
  }
  return out;
}

}  // namespace

std::vector<double> axis_marks(double low, double high, int wanted) {
  const double raw = (high - low) / wanted;
  const double magnitude = std::pow(10.0, std::floor(std::log10(raw)));
  double step = magnitude * 10;
  for (const double m : {1.0, 2.0, 5.0})
    if (raw <= m * magnitude) {
      step = m * magnitude;
      break;
    }
  std::vector<double> marks;
  for (double k = std::ceil(low / step); k * step <= high + step * 1e-9; ++k) marks.push_back(k * step);
  return marks;
}

std::string to_svg(std::span<const Plot> plots) {
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"sans-serif\" font-size=\"13\">\n",
      kWidth, kHeight * static_cast<double>(plots.size()));
  for (std::size_t i = 0; i < plots.size(); ++i)
    out +=
        fmt::format("<g transform=\"translate(0 {})\">\n{}</g>\n", kHeight * static_cast<double>(i), drawn(plots[i]));
  return out + "</svg>\n";
}

std::string to_svg(const Plot& plot) { return to_svg(std::span(&plot, 1)); }

}  // namespace sinew::app
