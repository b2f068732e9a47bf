#pragma once
// Straight lines and the centre circle out of points of lines.
#include <array>
#include <optional>
#include <span>

#include "soccer/sight/line_points.hpp"

namespace sinew::soccer {

struct LinePiece {
  double u0_px = 0, v0_px = 0, u1_px = 0, v1_px = 0;
  GroundXy from, to;
  int points = 0;
  bool is_bent = false;  // part of a circle: not among lines()
  double length_m() const { return math::hypot(to.x_m - from.x_m, to.y_m - from.y_m); }
};

struct CirclePiece {
  GroundXy centre;
  double radius_m = 0;  // as it was seen; a camera that is tilted by more than the robot knows sees another one
  int points = 0;
};

/// The circle is looked for on the ground, straight lines in the picture, where all points are equally sure.
/// Both by random samples of points of a fixed sequence: the same points give the same lines. What was found is checked
/// against the picture: along it lies what is no carpet, beside it carpet.
/// Source:  M. Fischler and R. Bolles, Random sample consensus, Comm. ACM 24 (1981).
/// Thread:  owner.   RT: yes.
class LineFinder {
 public:
  static constexpr std::size_t kMost = 10;
  /// `circle_radius_m`: of the middle of its line.
  void find(const Picture& picture, const GroundView& view, std::span<const LinePoint> points, double circle_radius_m);

  std::span<const LinePiece> lines() const { return {line_.data(), lines_}; }
  const std::optional<CirclePiece>& circle() const { return circle_; }
  /// Points that are of no line and of no circle; those of lines are 1 + the line's number, of the circle
  /// 255, of bent pieces 253.
  std::uint8_t owner(std::size_t point) const { return owner_[point]; }

 private:
  void find_circle(const Picture& picture, const GroundView& view, std::span<const LinePoint> points, double radius_m);
  void circle_of_chords(const Picture& picture, const GroundView& view, std::span<const LinePoint> points,
                        double radius_m);
  bool find_line(const Picture& picture, const GroundView& view, std::span<const LinePoint> points);
  /// The share of these points that two straight lines hold.
  template <class Use>
  double two_lines_share(const Picture& picture, std::span<const LinePoint> points, const Use& use);
  std::uint32_t random(std::uint32_t below);

  std::uint32_t draw_ = 1;
  std::array<LinePiece, kMost> line_{};
  std::size_t lines_ = 0;
  std::optional<CirclePiece> circle_;
  std::array<std::uint8_t, LinePoints::kMost> owner_{};
};

/// What the picture shows at a place on the ground: nothing (outside of it), or whether a line's width there is carpet.
enum class Probe : std::uint8_t { unseen, carpet, line, other };
Probe probe(const Picture& picture, const GroundView& view, const GroundXy& p);

}  // namespace sinew::soccer
