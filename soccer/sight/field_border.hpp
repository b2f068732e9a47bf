#pragma once
// Where the carpet ends in a picture.
#include <array>

#include "soccer/sight/picture.hpp"

namespace sinew::soccer {

/// The uppermost carpet of scanned columns, made convex: the carpet is a rectangle, so what is below that curve and not
/// carpet stands or lies on it.
/// Source:  the idea of a convex hull over the tops of scan lines: T. Reinhardt, Kalibrierungsfreie
///          Bildverarbeitungsalgorithmen zur echtzeitfaehigen Objekterkennung im Roboterfussball, HTWK Leipzig, 2011.
/// Thread:  owner.   RT: yes.
class FieldBorder {
 public:
  static constexpr int kColumns = 41;
  void find(const Picture& picture, const GroundView& view);

  /// Some carpet was seen.
  bool found() const { return found_; }
  /// Row at which the carpet begins in this column.
  double row_px(double u_px) const;
  struct Point {
    double u_px = 0, v_px = 0;
    bool measured = false;  // the carpet ends there: not at the picture's upper side, and nothing stands before it
  };
  const std::array<Point, kColumns>& points() const { return point_; }

 private:
  bool found_ = false;
  double step_px_ = 1;
  std::array<Point, kColumns> point_{};
};

}  // namespace sinew::soccer
