#pragma once
// The inner corners of a printed chessboard.
//
//   BoardFinder finder({.columns = 9, .rows = 6});
//   if (finder.find(luma.view())) finder.corners()[0].u_px;
//
// Thread:  owner.   RT: no, it allocates and its time depends on the picture.
#include <cstdint>
#include <span>
#include <vector>

#include "vision/image_view.hpp"

namespace sinew::vision {

/// Inner corners: a board of 10 x 7 squares has 9 x 6.
struct BoardSize {
  std::uint32_t columns = 9, rows = 6;  // 3 to 32 each
};

struct BoardCorner {
  double u_px = 0, v_px = 0;
};

/// Finds one board that is whole in the picture, with a square of 6 pixels or more. Corners are where two dark and two
/// bright quarters meet; from one of them the board grows along its edges, each next corner where the last ones lead;
/// then each is moved to where all edges around it cross.
/// Source:  S. Bennett, J. Lasenby, ChESS: quick and robust detection of chess-board features, CVIU 118 (2014), for the
///          corners; W. Foerstner, E. Guelch, A fast operator for detection and precise location of distinct points
///          (1987), for their places.
class BoardFinder {
 public:
  explicit BoardFinder(const BoardSize& size) : size_(size) {}

  /// `mono`: mono8. False: no board of this size is there, or more than one.
  bool find(const ImageView& mono);
  /// Row after row. Rows go to the right and columns down for somebody before the board; the square between the first
  /// two corners of the first two rows is dark. Only if columns + rows is odd this is one way to number it; else the
  /// same board turned by half a turn is numbered from its other end (by a quarter, if both are the same).
  std::span<const BoardCorner> corners() const { return corners_; }
  const BoardSize& size() const { return size_; }

 private:
  struct Candidate {
    double u = 0, v = 0;
    double strength = 0;
    double cos2 = 0, sin2 = 0;  // of twice the angle of the bright quarters
  };
  struct Grid;
  double grey(double u, double v) const;
  void smooth(const ImageView& mono);
  void find_candidates();
  int nearest(double u, double v, double within, const Candidate& like, bool opposite) const;
  bool grow(std::size_t seed, Grid& grid) const;
  bool take(const Grid& grid);
  void refine();
  void order();

  BoardSize size_;
  std::uint32_t width_ = 0, height_ = 0;
  std::vector<float> grey_, soft_;
  std::vector<Candidate> candidate_;
  std::vector<BoardCorner> corners_;
};

}  // namespace sinew::vision
