#pragma once
// What a robot saw of the field in the last seconds, put together in the frame of its odometry.
// Thread:  owner.   RT: yes.
#include <array>

#include "msg/soccer.hpp"
#include "soccer/world/field_at.hpp"
#include "soccer/world/pose_score.hpp"

namespace sinew::soccer {

/// A line or mark that was seen once or more. Of lines the latest piece, unless it is much shorter.
struct RememberedSight {
  ScoredSight::Kind kind = ScoredSight::Kind::line;
  std::uint32_t times = 0;             // that it was seen
  double x_m = 0, y_m = 0;             // odometry's frame; a line: its middle
  double heading_rad = 0, half_m = 0;  // a line: along it, half its length. A mark: as msg::SeenMark; NaN: none
  double variance_m2 = 0;              // of the place; a line: across it
  std::int64_t seen_ns = 0;
};

/// The state is plain: it can be saved and restored as bytes.
class SightMemory {
 public:
  static constexpr std::size_t kMost = 48;

  void forget() { count_ = 0; }
  /// Adds lines and marks; drops what is older than `keep_s`.
  void see(const msg::SoccerSight& sight, double keep_s);
  std::span<const RememberedSight> all() const { return {sight_.data(), count_}; }

 private:
  void add(const RememberedSight& s);

  std::array<RememberedSight, kMost> sight_{};
  std::uint32_t count_ = 0, spare_ = 0;  // spare: no padding in what is saved
};

}  // namespace sinew::soccer
