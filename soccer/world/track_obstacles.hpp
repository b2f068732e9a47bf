#pragma once
#include "rt/module.hpp"
#include "soccer/world/obstacle_filter.hpp"

namespace sinew::soccer {

/// Says which robots are in the way: docs/soccer-world.md.
/// Frames:  out: "robot" of the newest picture.
/// Thread:  executor, released by sightings.   RT: yes.
/// Errors:  stale when no picture came.
class TrackObstacles final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override { filter_.forget(); }
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  rt::InQueue<msg::SoccerSight> sight_, sight2_;
  rt::Out<msg::ObstacleModel> out_;
  ObstacleFilter filter_;
};

}  // namespace sinew::soccer
