#pragma once
#include <cstdint>
#include <vector>

#include "apps/view/canvas.hpp"

namespace sinew::app {

/// Draws into rows of RGB, with smooth edges. Letters are strokes (stroke_font.hpp): no font and no library is needed.
/// The picture has `scale` pixels for each px of the drawing.
class PixelCanvas final : public Canvas {
 public:
  PixelCanvas(double width_px, double height_px, double scale);
  void rectangle(Point from, Point size, std::string_view colour) override;
  void line(std::span<const Point> points, const Stroke& stroke) override;
  void text(std::string_view text, const Label& label) override;

  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }
  /// Rows from above to below, without padding.
  std::span<const std::uint8_t> rgb() const { return rgb_; }

 private:
  struct Box {  // pixels; the ends are not in it
    int left = 0, top = 0, right = 0, bottom = 0;
    bool empty() const { return left >= right || top >= bottom; }
  };
  Box clipped(double left, double top, double right, double bottom) const;
  void cover(Point a, Point b, double radius);
  void paint(std::string_view colour);

  double scale_;
  std::uint32_t width_, height_;
  std::vector<std::uint8_t> rgb_;
  std::vector<std::uint8_t> cover_;  // of the line that is being drawn: how much of each pixel it covers
  Box covered_{};
};

}  // namespace sinew::app
