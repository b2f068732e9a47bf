#pragma once
// A robot that walks about a field without pictures and dynamics: what its vision would report, with the errors, misses
// and false sightings that docs/soccer-vision.md measured, and its odometry with those of docs/walking.md.
// Thread:  owner.
#include "math/random.hpp"
#include "soccer/sight/ground_view.hpp"
#include "soccer/world/field_at.hpp"

namespace sinew::locate {

struct WalkErrors {
  double tilt_rad = 0.015;       // lasting, of the torso about both axes
  double tilt_sway_rad = 0.007;  // within a step
  double forward_scale = 0.06, side_scale = 0.1, turn_scale = 0.02, slip = 0.05, gyro_radps = 0.002;
  double bump_every_s = 20;  // somebody runs into it: 0.1 m, 0.15 rad
  double line_seen = 0.85, mark_seen = 0.6, circle_seen = 0.5, penalty_seen = 0.4, post_seen = 0.5;
  double false_line = 0.06;                                                 // of the lines
  double false_marks = 0.016, false_penalties = 0.025, false_posts = 0.08;  // for each picture
};

class FieldWalk {
 public:
  static constexpr double kPictureS = 0.05;  // two cameras in turn, 10 a second each
  FieldWalk(const soccer::Field& field, std::uint64_t seed, const WalkErrors& errors = {});

  /// Walks until the next picture, and says what it shows.
  const msg::SoccerSight& step();
  /// Somebody carries it there; its odometry notices nothing.
  void put(const soccer::FieldAt& at) { at_ = at; }
  /// A place somewhere on the field.
  soccer::FieldAt anywhere();
  const soccer::FieldAt& truth() const { return at_; }
  double now_s() const { return 1e-9 * static_cast<double>(sight_.stamp.ns); }
  math::Random& random() { return random_; }

 private:
  void walk(double dt_s);
  void look();

  const soccer::Field& field_;
  WalkErrors e_;
  math::Random random_;
  soccer::FieldAt at_, odometry_;
  soccer::FieldPoint aim_{};
  double speed_mps_ = 0.2, aside_ = 0, phase_ = 0;
  double tilt_x_ = 0, tilt_y_ = 0, sway_x_ = 0, sway_y_ = 0;
  double scale_forward_ = 0, scale_side_ = 0, scale_turn_ = 0, slip_ = 0, gyro_ = 0;
  std::uint32_t camera_ = 0;
  msg::SoccerSight sight_;
};

}  // namespace sinew::locate
