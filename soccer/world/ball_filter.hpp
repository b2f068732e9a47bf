#pragma once
// Where the ball is: a bank of Kalman filters in the frame of the odometry, some of a ball that rests, some of one that
// rolls and slows down; the one that explains the sightings best counts. A ball out of sight stays where it must be by
// then, less and less sure; one that should be seen and is not becomes improbable.
// Thread:  owner.   RT: yes.
#include <array>
#include <cstdint>
#include <span>

#include "math/matrix.hpp"
#include "msg/soccer.hpp"
#include "soccer/world/field_at.hpp"

namespace sinew::soccer {

struct BallOptions {
  double deceleration_mps2 = 0.35;  // of a ball that rolls: docs/pitch.md
  double sight_scale = 0.6;         // of the standard deviations of SoccerSight
  double floor_m = 0.02;            // smallest standard deviation of a sighting
  double rest_mps = 0.02;           // a resting ball's place: m after the root of 1 s
  double push_mps2 = 0.3;           // a rolling ball's speed: m/s after the root of 1 s
  double way_sigma = 0.1;           // of the odometry: m after 1 m
  double kick_mps = 1.2;            // standard deviation of a new ball's speed
  double gate = 16;                 // squared error by covariance beyond which a sighting is of another ball
  double seen_share = 0.5;          // of the pictures that must show the ball it is found in so many, at least
  double forget_s = 20;             // in which a ball out of sight becomes improbable
  double evidence_s = 2;            // evidence fades
};

/// A ball some time later, by the same law as the filter's. Negative and zero times: as it is.
struct RollingBall {
  double x_m = 0, y_m = 0, vx_mps = 0, vy_mps = 0;

  RollingBall after(double s, double deceleration_mps2) const;
  double stops_after_s(double deceleration_mps2) const;
};

class BallFilter {
 public:
  static constexpr std::size_t kMost = 8;

  struct Track {
    RollingBall ball;            // odometry's frame
    math::Mat<4, 4> covariance;  // x, y, vx, vy
    double log_weight = 0;       // the best has 0
    double confidence = 0;       // that there is a ball
    double chi2 = 0;             // of the last sighting
    std::int64_t seen_ns = 0;
    std::uint32_t sightings = 0;
    std::uint32_t rolls = 0;  // 1: it has a speed
  };
  struct State {
    std::array<Track, kMost> track;
    FieldAt robot;  // in the odometry's frame
    std::int64_t stamp_ns = 0;
    std::uint32_t count = 0, spare = 0;  // spare: no padding in what is saved
    std::uint32_t sightings = 0;
    std::uint32_t gone = 0;
  };

  explicit BallFilter(const BallOptions& options = {}) : o_(options) {}
  BallOptions& options() { return o_; }
  State& state() { return s_; }
  const State& state() const { return s_; }

  void forget() { s_ = {}; }
  /// Moves on to this picture's time. Then for each ball that was predicted, where it is in the frame "robot":
  /// whether the picture must show it.
  std::span<const FieldPoint> predict(const msg::SoccerSight& sight);
  /// `shown`: a value for each of the places that predict() returned.
  void see(const msg::SoccerSight& sight, std::span<const bool> shown);

  /// All but stamp and the place on the field, in the frame "robot" at the last picture.
  void fill(msg::BallModel& out) const;
  std::span<const Track> tracks() const { return {s_.track.data(), s_.count}; }

 private:
  void spawn(const FieldPoint& at, const msg::SeenBall& seen, const math::Mat<2, 2>& noise, bool rolls);
  void tidy();
  const Track* best() const;

  BallOptions o_;
  State s_;
  std::array<FieldPoint, kMost> predicted_{};
};

}  // namespace sinew::soccer
