#pragma once
#include <span>
#include <string_view>
#include <vector>

#include "apps/view/canvas.hpp"

namespace sinew::app {

/// One stroke of a letter: the base line is y = 0, capitals are 6 high, y grows upwards.
using GlyphStroke = std::vector<Point>;

/// A letter made of strokes, as a plotter draws it.
struct Glyph {
  std::vector<GlyphStroke> strokes{};
  double width = 0;  // of the letter itself
};

/// '?' for what is no printable ASCII.
Glyph glyph_of(char letter);

/// From the units of a glyph to px of a text of this size, and the space between two letters.
inline constexpr double kGlyphWide = 0.106, kGlyphHigh = 0.12, kGlyphSpace = 1.6;

}  // namespace sinew::app
