#include "apps/view/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>

#include "apps/view/pixel_canvas.hpp"
#include "apps/view/svg_canvas.hpp"
#include "dataset/png_image.hpp"

namespace sinew::app {
namespace {

constexpr double kWidth = 900, kAreaAlone = 320, kAreaOfSeveral = 190, kLeft = 76, kRight = 20, kBottom = 48;
constexpr double kTitleHeight = 30, kLegendRow = 18, kMarkRow = 14, kFrameGap = 6, kPixels = 2;
constexpr double kTitleSize = 15, kTextSize = 12.5, kMarkSize = 11;
constexpr std::size_t kBins = 1000, kMarkRows = 4;
constexpr std::array kColours{"#1f5fa8", "#d1495b", "#2e8b57", "#8a5fbf", "#b8860b", "#00838f", "#7a4b2a", "#555555"};
constexpr const char *kGrid = "#dddddd", *kFrame = "#888888", *kInk = "#222222", *kMarkInk = "#666666",
                     *kAlarm = "#c62828";

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void include(double v) {
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
  void widen() {
    if (low > high) low = 0, high = 1;
    if (low == high) {  // a constant lies in the middle, and far from zero still has two ends
      const double half = std::max(0.5, std::abs(low) * 1e-3);
      low -= half, high += half;
    }
  }
  double span() const { return high - low; }
};

// Keeps the smallest and largest point of each bin, in their order.
std::vector<std::pair<double, double>> thinned(const std::vector<std::pair<double, double>>& points) {
  if (points.size() <= 2 * kBins) return points;
  std::vector<std::pair<double, double>> kept;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const auto first = points.begin() + static_cast<std::ptrdiff_t>(bin * points.size() / kBins);
    const auto last = points.begin() + static_cast<std::ptrdiff_t>((bin + 1) * points.size() / kBins);
    const auto gap = std::find_if(first, last, [](const auto& p) { return !std::isfinite(p.second); });
    auto [low, high] = std::minmax_element(first, gap, [](auto& a, auto& b) { return a.second < b.second; });
    if (high < low) std::swap(low, high);
    if (low != gap) kept.push_back(*low);
    if (high != low) kept.push_back(*high);
    if (gap != last) kept.push_back(*gap);
  }
  return kept;
}

/// Marks of one axis with as many digits as tell them apart, and no more.
std::string mark_text(double value, double step) {
  if (std::abs(value) < step * 1e-6) return "0";
  const double digits = std::ceil(-std::log10(step) - 1e-6);
  if (std::abs(value) >= 1e6 || digits > 5) return fmt::format("{:.4g}", value);
  return fmt::format("{:.{}f}", value, std::max(0, static_cast<int>(digits)));
}

double step_of(const std::vector<double>& marks) { return marks.size() < 2 ? 1 : marks[1] - marks[0]; }

/// The text cut to what fits, with an ellipsis.
std::string fitted(const std::string& text, double width_px, double size_px) {
  if (text_width_px(text, size_px) <= width_px) return text;
  std::string cut = text;
  while (!cut.empty() && text_width_px(cut + "...", size_px) > width_px) cut.pop_back();
  return cut + "...";
}

struct PlacedText {
  std::string text;
  double x;
  std::size_t row;
  std::size_t index;  // of the mark or series
};

/// One plot on its part of the canvas.
class Drawing {
 public:
  Drawing(const Plot& plot, double area_px) : plot_(plot), area_(area_px) {
    for (const auto& s : plot.series)
      for (const auto& [px, py] : s.points) x_.include(px), y_.include(py);
    if (plot.x_range) x_ = {plot.x_range->first, plot.x_range->second};
    x_.widen();
    y_.widen();
    y_ = {y_.low - 0.03 * y_.span(), y_.high + 0.03 * y_.span()};
    place_legend();
    place_marks();
  }

  double height() const { return head() + area_ + kBottom; }

  void draw(Canvas& canvas, double top) {
    canvas_ = &canvas;
    top_ = top;
    if (!plot_.title.empty())
      canvas.text(fitted(plot_.title, kWidth - kLeft - kRight, kTitleSize), {{kLeft, top_ + 21}, kTitleSize, kInk});
    draw_legend();
    draw_grid();
    draw_marks();
    draw_series();
    draw_frame();
  }

 private:
  double legend_top() const { return plot_.title.empty() ? kFrameGap : kTitleHeight; }
  double marks_top() const { return legend_top() + kLegendRow * static_cast<double>(legend_rows_); }
  double head() const { return marks_top() + kMarkRow * static_cast<double>(mark_rows_) + kFrameGap; }
  double frame_top() const { return top_ + head(); }
  double bottom() const { return frame_top() + area_; }
  double at_x(double v) const { return kLeft + (v - x_.low) / x_.span() * (kWidth - kLeft - kRight); }
  double at_y(double v) const { return bottom() - (v - y_.low) / y_.span() * area_; }

  /// Names with a piece of their line, in as many rows as they need.
  void place_legend() {
    constexpr double kGap = 24;
    if (plot_.series.size() == 1 && plot_.series[0].name == plot_.title) return;
    double x = kLeft;
    for (std::size_t i = 0; i < plot_.series.size(); ++i) {
      if (plot_.series[i].name.empty()) continue;
      const std::string name = fitted(plot_.series[i].name, kWidth - kLeft - kRight - kSwatch, kTextSize);
      const double width = kSwatch + text_width_px(name, kTextSize);
      if (legend_rows_ == 0) legend_rows_ = 1;
      if (x > kLeft && x + width > kWidth - kRight) x = kLeft, ++legend_rows_;
      legend_.push_back({name, x, legend_rows_ - 1, i});
      x += width + kGap;
    }
  }

  void draw_legend() {
    for (const PlacedText& p : legend_) {
      const double y = top_ + legend_top() + kLegendRow * static_cast<double>(p.row);
      const std::array line{Point{p.x, y + 8}, Point{p.x + kSwatch - 6, y + 8}};
      canvas_->line(line, {kColours[p.index % kColours.size()], 2.5});
      canvas_->text(p.text, {{p.x + kSwatch, y + 12.5}, kTextSize, kInk});
    }
  }

  /// Finds a row for the text of each mark.
  void place_marks() {
    constexpr double kGap = 8;
    std::array<double, kMarkRows> free_from{};
    for (std::size_t i = 0; i < plot_.marks.size(); ++i) {
      const PlotMark& mark = plot_.marks[i];
      if (mark.text.empty() || mark.x < x_.low || mark.x > x_.high) continue;
      const double width = text_width_px(mark.text, kMarkSize);
      const double x = std::max(0.0, std::min(at_x(mark.x), kWidth - kRight - width));
      for (std::size_t row = 0; row < kMarkRows; ++row) {
        if (x < free_from[row]) continue;
        free_from[row] = x + width + kGap;
        placed_.push_back({mark.text, x, row, i});
        mark_rows_ = std::max(mark_rows_, row + 1);
        break;
      }
    }
  }

  void draw_marks() {
    for (const PlotMark& mark : plot_.marks) {
      if (mark.x < x_.low || mark.x > x_.high) continue;
      const std::array line{Point{at_x(mark.x), frame_top() - kFrameGap + 2}, Point{at_x(mark.x), bottom()}};
      canvas_->line(line, {mark.alarm ? kAlarm : "#999999", 1, true});
    }
    for (const PlacedText& p : placed_)
      canvas_->text(p.text, {{p.x, top_ + marks_top() + 11 + kMarkRow * static_cast<double>(p.row)},
                             kMarkSize,
                             plot_.marks[p.index].alarm ? kAlarm : kMarkInk});
  }

  void draw_grid() {
    const auto columns = axis_marks(x_.low, x_.high, 10);
    for (const double m : columns) {
      const std::array line{Point{at_x(m), frame_top()}, Point{at_x(m), bottom()}};
      canvas_->line(line, {kGrid, 1});
      canvas_->text(mark_text(m, step_of(columns)), {{at_x(m), bottom() + 17}, kTextSize, kInk, Label::Anchor::middle});
    }
    for (const auto& [value, text] : row_marks()) {
      const std::array line{Point{kLeft, at_y(value)}, Point{kWidth - kRight, at_y(value)}};
      canvas_->line(line, {kGrid, 1});
      canvas_->text(fitted(text, kLeft - 8, kTextSize),
                    {{kLeft - 6, at_y(value) + 4.5}, kTextSize, kInk, Label::Anchor::end});
    }
    canvas_->text(plot_.x_label,
                  {{(kLeft + kWidth - kRight) / 2, bottom() + 37}, kTextSize, kInk, Label::Anchor::middle});
    canvas_->text(fitted(plot_.y_label, bottom() - frame_top(), kTextSize),
                  {{16, (frame_top() + bottom()) / 2}, kTextSize, kInk, Label::Anchor::middle, true});
  }

  std::vector<std::pair<double, std::string>> row_marks() const {
    std::vector<std::pair<double, std::string>> rows;
    if (!plot_.y_names.empty()) {
      for (const auto& [value, name] : plot_.y_names)
        if (value >= y_.low && value <= y_.high && (rows.empty() || at_y(rows.back().first) - at_y(value) >= kTextSize))
          rows.emplace_back(value, name);
      return rows;
    }
    const auto marks = axis_marks(y_.low, y_.high, 6);
    for (const double m : marks) rows.emplace_back(m, mark_text(m, step_of(marks)));
    return rows;
  }

  void draw_series() {
    for (std::size_t i = 0; i < plot_.series.size(); ++i) {
      const Stroke stroke{kColours[i % kColours.size()], 1.4};
      std::vector<Point> line;
      for (const auto& [px, py] : thinned(plot_.series[i].points)) {
        if (!std::isfinite(px) || !std::isfinite(py)) {
          canvas_->line(line, stroke);
          line.clear();
          continue;
        }
        if (px < x_.low || px > x_.high) continue;
        if (plot_.series[i].stepped && !line.empty()) line.push_back({at_x(px), line.back().y});
        line.push_back({at_x(px), at_y(py)});
      }
      canvas_->line(line, stroke);
    }
  }

  void draw_frame() {
    const std::array frame{Point{kLeft, frame_top()}, Point{kWidth - kRight, frame_top()},
                           Point{kWidth - kRight, bottom()}, Point{kLeft, bottom()}, Point{kLeft, frame_top()}};
    canvas_->line(frame, {kFrame, 1});
  }

  static constexpr double kSwatch = 24;

  const Plot& plot_;
  double area_, top_ = 0;
  Canvas* canvas_ = nullptr;
  Range x_, y_;
  std::size_t legend_rows_ = 0, mark_rows_ = 0;
  std::vector<PlacedText> legend_, placed_;
};

/// All drawings of some plots, one below the other.
class Sheet {
 public:
  explicit Sheet(std::span<const Plot> plots) {
    for (const Plot& plot : plots) drawings_.emplace_back(plot, plots.size() > 1 ? kAreaOfSeveral : kAreaAlone);
  }
  double height() const {
    double sum = 0;
    for (const Drawing& d : drawings_) sum += d.height();
    return std::max(sum, 1.0);
  }
  void draw(Canvas& canvas) {
    canvas.rectangle({0, 0}, {kWidth, height()}, "#ffffff");
    double top = 0;
    for (Drawing& d : drawings_) {
      d.draw(canvas, top);
      top += d.height();
    }
  }

 private:
  std::vector<Drawing> drawings_;
};

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
  Sheet sheet(plots);
  SvgCanvas canvas(kWidth, sheet.height());
  sheet.draw(canvas);
  return std::move(canvas).document();
}

std::string to_svg(const Plot& plot) { return to_svg(std::span(&plot, 1)); }

std::string to_png(std::span<const Plot> plots, std::string& why) {
  Sheet sheet(plots);
  PixelCanvas canvas(kWidth, sheet.height(), kPixels);
  sheet.draw(canvas);
  return dataset::encode_png(msg::PixelFormat::rgb8, canvas.width(), canvas.height(), 3 * canvas.width(), canvas.rgb(),
                             why);
}

std::string why_no_plot_file(const std::string& path) {
  return path.ends_with(".svg") || path.ends_with(".png") ? std::string() : path + ": FILE.svg or FILE.png";
}

std::string write_plots(const std::string& path, std::span<const Plot> plots) {
  std::string why;
  const std::string drawn = path.ends_with(".png") ? to_png(plots, why) : to_svg(plots);
  if (drawn.empty()) return path + ": " + why;
  std::FILE* const out = std::fopen(path.c_str(), "wb");
  const bool all = out && std::fwrite(drawn.data(), 1, drawn.size(), out) == drawn.size();
  const bool closed = out && std::fclose(out) == 0;
  return all && closed ? std::string() : path + ": cannot be written: " + std::strerror(errno);
}

}  // namespace sinew::app
