#pragma once
// Points of the field's lines on columns and rows of a picture.
#include <array>
#include <span>

#include "soccer/sight/field_border.hpp"

namespace sinew::soccer {

struct LinePoint {
  float u_px = 0, v_px = 0;  // of the line's middle on the scan
  float x_m = 0, y_m = 0;    // robot
  float wide_px = 0;
  bool in_column = false;  // the scan went down a column, not along a row
};

/// Scans columns and rows for pieces that are no carpet, lie between carpet, are as wide as a line would be there and
/// brighter than the carpet beside them. Rows are spaced by their distance on the ground.
/// Thread:  owner.   RT: yes.
class LinePoints {
 public:
  static constexpr std::size_t kMost = 320;
  void find(const Picture& picture, const GroundView& view, const FieldBorder& border);
  std::span<const LinePoint> points() const { return {point_.data(), count_}; }

 private:
  std::array<LinePoint, kMost> point_{};
  std::size_t count_ = 0;
};

inline constexpr double kLineWide_m = 0.05;

}  // namespace sinew::soccer
