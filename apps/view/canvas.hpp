#pragma once
// What a plot is drawn with, so that one code draws it as SVG and as pixels.
#include <span>
#include <string>
#include <string_view>

namespace sinew::app {

struct Point {
  double x = 0, y = 0;  // px from the upper left corner
};

struct Stroke {
  std::string_view colour = "#000000";  // "#rrggbb"
  double width_px = 1;
  bool dashed = false;
};

struct Label {
  enum class Anchor { begin, middle, end };
  Point at{};  // on the text's base line
  double size_px = 13;
  std::string_view colour = "#222222";
  Anchor anchor = Anchor::begin;
  bool upwards = false;  // reads from below to above
};

class Canvas {
 public:
  virtual ~Canvas() = default;
  virtual void rectangle(Point from, Point size, std::string_view colour) = 0;
  virtual void line(std::span<const Point> points, const Stroke& stroke) = 0;
  /// ASCII; another character may be shown as one that stands for it.
  virtual void text(std::string_view text, const Label& label) = 0;
};

/// How wide a text is drawn, or somewhat less: every canvas has its own letters.
double text_width_px(std::string_view text, double size_px);

}  // namespace sinew::app
