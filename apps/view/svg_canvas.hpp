#pragma once
#include "apps/view/canvas.hpp"

namespace sinew::app {

/// Draws into an SVG document.
class SvgCanvas final : public Canvas {
 public:
  SvgCanvas(double width_px, double height_px);
  void rectangle(Point from, Point size, std::string_view colour) override;
  void line(std::span<const Point> points, const Stroke& stroke) override;
  void text(std::string_view text, const Label& label) override;
  /// The whole document; nothing is drawn after it.
  std::string document() &&;

 private:
  std::string out_;
};

}  // namespace sinew::app
