#pragma once
// How well many poses of a robot agree with what it has seen, at once.
// Frames:  poses "field", sightings "robot" of msg/soccer.hpp.
// Thread:  any.   RT: yes, after the constructor.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "soccer/field.hpp"

namespace sinew::soccer {

/// One thing that was seen, for scoring.
struct ScoredSight {
  enum class Kind : std::uint32_t { line, corner_l, corner_t, corner_x, penalty_mark, circle, post };
  Kind kind = Kind::line;
  float x_m = 0, y_m = 0;                 // a line: the middle of the piece that was seen
  float ahead = 1, left = 0, half_m = 0;  // a line: its direction as a unit vector, half the length of the piece
  float per_m2 = 1;                       // cost of a metre of distance, squared: 1 / variance
  float per_angle2 = 0;                   // a line: cost of the sine of the angle between the two, squared
  float most = 6;                         // what something that is not there costs
};

/// Poses side by side, and what they cost. Room for kMost; places beyond `count` mean nothing.
struct ScoredPoses {
  static constexpr std::size_t kMost = 512;
  std::size_t count = 0;
  alignas(16) std::array<float, kMost> x_m{}, y_m{}, cos{}, sin{}, cost{};

  bool full() const { return count == kMost; }
  void add(double x, double y, double heading_rad);
};

/// The field folded onto a quarter: lines, corners, marks and posts are the same left and right and at both ends, so a
/// distance to the nearest needs a seventh of the places.
class PoseScore {
 public:
  explicit PoseScore(const Field& field);

  /// Sets each pose's cost: the sum over all sightings of
  ///   min(per_m2 * distance^2 to the nearest of its kind + per_angle2 * sin(angle)^2, most).
  /// A line counts against those field lines whose direction is nearer to its own; its distance is across the line, and
  /// along it by how far the piece sticks out over the line's ends.
  /// Four poses at a time; the same bits as score_one_by_one(), since each pose has the same operations in the same
  /// order.
  void score(std::span<const ScoredSight> sights, ScoredPoses& poses) const;
  void score_one_by_one(std::span<const ScoredSight> sights, ScoredPoses& poses) const;

 private:
  /// Of a line in the quarter: `at` across, from `low` to `high` along. A line over the middle has its low end far
  /// away.
  struct Strip {
    float at, low, high;
  };
  struct Places {
    std::array<float, 4> x{}, y{};
    std::size_t count = 0;
  };
  template <class V>
  void run(std::span<const ScoredSight> sights, ScoredPoses& poses) const;

  std::array<Strip, 3> along_{};    // lines along x
  std::array<Strip, 4> across_{};   // lines along y
  std::array<Places, 7> places_{};  // by kind
};

}  // namespace sinew::soccer
