#include "apps/view/svg_canvas.hpp"

#include <fmt/format.h>

#include <utility>

namespace sinew::app {
namespace {

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else if (static_cast<unsigned char>(c) >= 0x20)  // XML has no control characters
      out += c;
  }
  return out;
}

const char* anchor_name(Label::Anchor anchor) {
  switch (anchor) {
    case Label::Anchor::begin:
      return "start";
    case Label::Anchor::middle:
      return "middle";
    case Label::Anchor::end:
      return "end";
  }
  return "start";
}

}  // namespace

SvgCanvas::SvgCanvas(double width_px, double height_px)
    : out_(fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:g} {1:g}\" width=\"{0:g}\" "
                       "height=\"{1:g}\" font-family=\"Helvetica, Arial, sans-serif\">\n",
                       width_px, height_px)) {}

void SvgCanvas::rectangle(Point from, Point size, std::string_view colour) {
  out_ += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n", from.x,
                      from.y, size.x, size.y, colour);
}

void SvgCanvas::line(std::span<const Point> points, const Stroke& stroke) {
  if (points.empty()) return;
  std::string path;
  for (const Point& p : points) path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", p.x, p.y);
  out_ += fmt::format(
      "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{:g}\" stroke-linejoin=\"round\" "
      "stroke-linecap=\"round\"{}/>\n",
      path, stroke.colour, stroke.width_px, stroke.dashed ? " stroke-dasharray=\"3 4\"" : "");
}

void SvgCanvas::text(std::string_view text, const Label& label) {
  const std::string turned =
      label.upwards ? fmt::format(" transform=\"rotate(-90 {:.1f} {:.1f})\"", label.at.x, label.at.y) : "";
  out_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:g}\" fill=\"{}\" text-anchor=\"{}\"{}>{}</text>\n",
                      label.at.x, label.at.y, label.size_px, label.colour, anchor_name(label.anchor), turned,
                      escaped(text));
}

std::string SvgCanvas::document() && { return std::move(out_) + "</svg>\n"; }

}  // namespace sinew::app
