#include "soccer/world/track_obstacles.hpp"

namespace sinew::soccer {

void TrackObstacles::declare(rt::Declaration& d) {
  d.in("sight", sight_, {.depth = 4});
  d.in("sight2", sight2_, {.depth = 4, .optional = true});
  d.out("obstacles", out_);
  ObstacleOptions& o = filter_.options();
  d.param("sight_scale", o.sight_scale, {.min = 0.05, .max = 5, .doc = "of the sightings' standard deviations"});
  d.param("floor_m", o.floor_m, {.unit = "m", .min = 0.01, .max = 1, .doc = "smallest standard deviation"});
  d.param("push_mps2", o.push_mps2, {.unit = "m/s", .min = 0, .max = 5, .doc = "change of a robot's speed after 1 s"});
  d.param("calm_s", o.calm_s, {.unit = "s", .min = 0.1, .max = 60, .doc = "in which a speed dies down"});
  d.param("gate", o.gate, {.min = 2, .max = 200, .doc = "squared error beyond which it is another robot"});
  d.param("radius_m", o.radius_m, {.unit = "m", .min = 0.02, .max = 2, .doc = "of a robot"});
  d.param("forget_s", o.forget_s, {.unit = "s", .min = 0.2, .max = 60, .doc = "so long a sighting counts"});
  d.param("least_sightings", o.least_sightings,
          {.min = 0.5, .max = 50, .doc = "before it is reported; faded ones count less"});
  d.state(filter_.state());
}

rt::StepStatus TrackObstacles::step(const rt::Step&) noexcept {
  if (sight_.empty() && sight2_.empty()) return rt::StepStatus::stale;
  for (const msg::SoccerSight& s : sight_) filter_.see(s);
  for (const msg::SoccerSight& s : sight2_) filter_.see(s);
  msg::ObstacleModel& out = out_.loan();
  out.stamp = {filter_.state().stamp_ns};
  filter_.fill(out);
  return rt::StepStatus::ok;
}

}  // namespace sinew::soccer
