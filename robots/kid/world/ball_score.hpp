#pragma once
#include <cstdint>

#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// What a humanoid does with the ball, and how well it keeps the ball in view.
/// Thread:  owner.
class BallScore {
 public:
  /// After each step of the pitch. `touched`: this robot touched the ball last. `camera`: x looks ahead. `looks`: the
  /// robot is on its feet.
  void look(const BallTruth& ball, bool touched, const kinematics::Pose& camera, bool looks, double now_s);

  bool touched() const { return touched_s_ >= 0; }
  double left_mps() const { return left_mps_; }
  /// So often the ball became faster than 0.5 m/s while this robot had touched it last.
  std::uint64_t kicks() const { return kicks_; }
  void add_to(JsonObject& j) const;

 private:
  std::uint64_t kicks_ = 0;
  bool rolls_ = false;                   // by its kick
  double ball_s_ = 0, looked_at_s_ = 0;  // so long it was the last one at the ball; the last look
  double touched_s_ = -1, came_mps_ = 0, left_mps_ = 0, mps_ = 0;
  double off_axis_rad_ = 0, most_off_axis_rad_ = 0, looked_s_ = -1;  // sum, largest; since when it looks
  std::uint64_t looks_ = 0;
};

}  // namespace sinew::plant
