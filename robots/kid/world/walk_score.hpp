#pragma once
#include <cstdint>
#include <string>

#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// How well a humanoid has walked. A body that tips over slowly has got down, and not fallen.
/// Thread:  owner.
class WalkScore {
 public:
  /// After each step of the pitch. `driven`: its servos have commands.
  void look(const BodyTruth& truth, bool driven, double now_s);

  /// Somebody put it elsewhere, on its feet: that is neither a way nor a rise.
  void moved() {
    mark_s_ = -1;
    down_ = false;
  }

  std::uint32_t falls() const { return falls_; }
  bool has_begun() const { return begun_; }
  void add_to(JsonObject& report) const;
  /// Good: it walked or touched the ball, never fell, and is on its feet.
  Verdict verdict(const BodyTruth& now, bool touched_ball) const;
  std::string text(const BodyTruth& now, bool touched_ball) const;

 private:
  bool walked() const;
  std::string words(const BodyTruth& now, bool touched_ball) const;

  bool begun_ = false, down_ = false;
  std::uint32_t falls_ = 0, got_down_ = 0, rises_ = 0;
  double walked_m_ = 0, turned_rad_ = 0, fastest_mps_ = 0;
  double first_fall_s_ = 0, fell_s_ = 0, longest_down_s_ = 0;
  math::Vec3 mark_m_;  // of the last sample
  double mark_s_ = -1, mark_heading_rad_ = 0;
};

}  // namespace sinew::plant
