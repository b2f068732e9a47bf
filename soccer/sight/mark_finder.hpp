#pragma once
// Corners, penalty marks and the centre circle out of lines.
#include <array>
#include <span>

#include "soccer/sight/line_finder.hpp"

namespace sinew::soccer {

/// Where two lines would meet, the picture is asked in all four directions whether a line goes there; each must answer.
/// A penalty mark is a piece of line with carpet all round it.
/// Thread:  owner.   RT: yes.
class MarkFinder {
 public:
  static constexpr std::size_t kMost = 8;
  void find(const Picture& picture, const GroundView& view, const LineFinder& lines, std::span<const LinePoint> points);
  std::span<const msg::SeenMark> marks() const { return {mark_.data(), count_}; }

 private:
  void add_corner(const Picture& picture, const GroundView& view, const LinePiece& a, const LinePiece& b);
  void add(const GroundView& view, const GroundXy& at, msg::FieldMark kind, double heading_rad);

  std::array<msg::SeenMark, kMost> mark_{};
  std::size_t count_ = 0;
};

}  // namespace sinew::soccer
