#pragma once
// Robots in the way, put together from sightings of which half are wrong (docs/soccer-vision.md): what was seen several
// times at one place counts.
// Thread:  owner.   RT: yes.
#include <array>
#include <cstdint>

#include "math/matrix.hpp"
#include "msg/soccer.hpp"
#include "soccer/world/field_at.hpp"

namespace sinew::soccer {

struct ObstacleOptions {
  double sight_scale = 0.6;  // of the standard deviations of SoccerSight
  double floor_m = 0.08;     // smallest standard deviation: the middle of the feet is not seen exactly
  double push_mps2 = 0.4;    // m/s after the root of 1 s
  double calm_s = 1.5;       // in which a speed dies down
  double way_sigma = 0.1;    // of the odometry: m after 1 m
  double gate = 9;           // squared error by covariance beyond which it is another robot
  double radius_m = 0.2;
  double forget_s = 4;         // a sighting counts for so long
  double least_sightings = 3;  // counted so, before it is reported
};

class ObstacleFilter {
 public:
  static constexpr std::size_t kMost = 24;

  struct Track {
    math::Vec<4> state;  // x, y, vx, vy; odometry's frame
    math::Mat<4, 4> covariance;
    double evidence = 0;  // sightings, faded
    double red = 0;       // jerseys seen: red ones less blue ones, faded
    std::int64_t seen_ns = 0;
    std::uint32_t sightings = 0, spare = 0;
  };
  struct State {
    std::array<Track, kMost> track;
    FieldAt robot;
    std::int64_t stamp_ns = 0;
    std::uint32_t count = 0, dropped = 0;
  };

  explicit ObstacleFilter(const ObstacleOptions& options = {}) : o_(options) {}
  ObstacleOptions& options() { return o_; }
  State& state() { return s_; }
  void forget() { s_ = {}; }

  void see(const msg::SoccerSight& sight);
  /// All but the stamp, in the frame "robot" at the last picture; the nearest first.
  void fill(msg::ObstacleModel& out);

 private:
  void move(const msg::SoccerSight& sight);
  void add(const msg::SeenRobot& seen);

  ObstacleOptions o_;
  State s_;
};

}  // namespace sinew::soccer
