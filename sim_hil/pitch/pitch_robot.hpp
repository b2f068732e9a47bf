#pragma once
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// One robot of a pitch as its session sees it, for worlds that step the pitch.
/// Thread:  the world's.
class PitchRobot : public SimRobot {
 public:
  /// Before a step of the pitch.
  virtual void act(RobotCommand command, std::int64_t now_ns) = 0;
  /// After it; `steps`: of the plant, since the begin.
  virtual void sample(std::int64_t steps) = 0;
  /// After a step of the plant that was none of the pitch.
  virtual void nothing_due() = 0;
};

}  // namespace sinew::plant
