#include "apps/view/pixel_canvas.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "apps/view/stroke_font.hpp"

namespace sinew::app {
namespace {

constexpr double kDash = 3, kDashGap = 4;  // as in the SVG
constexpr double kLetterStroke = 0.085;    // of the size

using Rgb = std::array<std::uint8_t, 3>;

Rgb rgb_of(std::string_view colour) {
  unsigned value = 0;
  std::from_chars(colour.data() + 1, colour.data() + colour.size(), value, 16);
  return {static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8),
          static_cast<std::uint8_t>(value)};
}

double distance_to_segment(Point p, Point a, Point b) {
  const double dx = b.x - a.x, dy = b.y - a.y, length = dx * dx + dy * dy;
  const double t = length > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / length, 0.0, 1.0) : 0.0;
  return std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
}

/// The parts of a line that a dashed stroke draws.
std::vector<std::array<Point, 2>> dashes_of(std::span<const Point> points) {
  std::vector<std::array<Point, 2>> dashes;
  double along = 0;  // since the beginning of the dash
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Point a = points[i - 1], b = points[i];
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    const auto at = [&](double s) { return Point{a.x + (b.x - a.x) * s / length, a.y + (b.y - a.y) * s / length}; };
    for (double s = 0; s < length;) {
      const bool drawn = along < kDash;
      const double step = std::min((drawn ? kDash : kDash + kDashGap) - along, length - s);
      if (drawn) dashes.push_back({at(s), at(s + step)});
      s += step;
      along += step;
      if (along >= kDash + kDashGap - 1e-9) along = 0;
      if (step <= 0) break;
    }
  }
  return dashes;
}

}  // namespace

PixelCanvas::PixelCanvas(double width_px, double height_px, double scale)
    : scale_(scale),
      width_(static_cast<std::uint32_t>(std::lround(width_px * scale))),
      height_(static_cast<std::uint32_t>(std::lround(height_px * scale))),
      rgb_(std::size_t{3} * width_ * height_, 255),
      cover_(std::size_t{1} * width_ * height_) {}

PixelCanvas::Box PixelCanvas::clipped(double left, double top, double right, double bottom) const {
  const auto inside = [](double v, std::uint32_t end) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(end)));
  };
  return {inside(std::floor(left), width_), inside(std::floor(top), height_), inside(std::ceil(right), width_),
          inside(std::ceil(bottom), height_)};
}

void PixelCanvas::rectangle(Point from, Point size, std::string_view colour) {
  const Rgb rgb = rgb_of(colour);
  const Box box = clipped(from.x * scale_, from.y * scale_, (from.x + size.x) * scale_, (from.y + size.y) * scale_);
  for (int y = box.top; y < box.bottom; ++y)
    for (int x = box.left; x < box.right; ++x)
      std::copy(rgb.begin(), rgb.end(), rgb_.begin() + 3 * (std::ptrdiff_t{y} * width_ + x));
}

void PixelCanvas::cover(Point a, Point b, double radius) {
  const Box box = clipped(std::min(a.x, b.x) - radius - 1, std::min(a.y, b.y) - radius - 1,
                          std::max(a.x, b.x) + radius + 1, std::max(a.y, b.y) + radius + 1);
  if (box.empty()) return;
  for (int y = box.top; y < box.bottom; ++y)
    for (int x = box.left; x < box.right; ++x) {
      const double distance = distance_to_segment({x + 0.5, y + 0.5}, a, b);
      const auto share = static_cast<std::uint8_t>(255 * std::clamp(radius + 0.5 - distance, 0.0, 1.0));
      std::uint8_t& at = cover_[static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(x)];
      at = std::max(at, share);
    }
  covered_ = covered_.empty() ? box
                              : Box{std::min(covered_.left, box.left), std::min(covered_.top, box.top),
                                    std::max(covered_.right, box.right), std::max(covered_.bottom, box.bottom)};
}

void PixelCanvas::paint(std::string_view colour) {
  const Rgb rgb = rgb_of(colour);
  for (int y = covered_.top; y < covered_.bottom; ++y)
    for (int x = covered_.left; x < covered_.right; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(x);
      const int share = cover_[at];
      cover_[at] = 0;
      for (std::size_t c = 0; share > 0 && c < 3; ++c) {
        std::uint8_t& channel = rgb_[3 * at + c];
        channel = static_cast<std::uint8_t>((channel * (255 - share) + rgb[c] * share + 127) / 255);
      }
    }
  covered_ = {};
}

void PixelCanvas::line(std::span<const Point> points, const Stroke& stroke) {
  const auto scaled = [&](Point p) { return Point{p.x * scale_, p.y * scale_}; };
  const double radius = 0.5 * stroke.width_px * scale_;
  if (stroke.dashed)
    for (const auto& dash : dashes_of(points)) cover(scaled(dash[0]), scaled(dash[1]), radius);
  for (std::size_t i = 0; i < points.size() && !stroke.dashed; ++i)
    if (i + 1 < points.size() || points.size() == 1)
      cover(scaled(points[i]), scaled(points[std::min(i + 1, points.size() - 1)]), radius);
  paint(stroke.colour);
}

void PixelCanvas::text(std::string_view text, const Label& label) {
  double along = 0;
  const double whole = text_width_px(text, label.size_px) - kGlyphSpace * kGlyphWide * label.size_px;
  if (label.anchor == Label::Anchor::middle) along = -whole / 2;
  if (label.anchor == Label::Anchor::end) along = -whole;
  const auto at = [&](Point p) {
    const double right = along + p.x * kGlyphWide * label.size_px, up = p.y * kGlyphHigh * label.size_px;
    return label.upwards ? Point{label.at.x - up, label.at.y - right} : Point{label.at.x + right, label.at.y - up};
  };
  for (const char c : text) {
    const Glyph glyph = glyph_of(c);
    for (const GlyphStroke& stroke : glyph.strokes) {
      for (std::size_t i = 0; i < stroke.size(); ++i) {
        const Point a = at(stroke[i]), b = at(stroke[std::min(i + 1, stroke.size() - 1)]);
        cover({a.x * scale_, a.y * scale_}, {b.x * scale_, b.y * scale_}, 0.5 * kLetterStroke * label.size_px * scale_);
      }
    }
    along += (glyph.width + kGlyphSpace) * kGlyphWide * label.size_px;
  }
  paint(label.colour);
}

}  // namespace sinew::app
