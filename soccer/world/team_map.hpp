#pragma once
// What a team knows together of the ball: the own sighting and those of the mates, each as old and as sure as it is.
// The largest group that agrees makes the ball; whoever contradicts it is distrusted. One mate alone, however sure it
// says it is, does not overrule what the robot sees itself. Frames:  "field" of msg/soccer.hpp. Thread:  any.   RT:
// yes.
#include <optional>
#include <span>

#include "math/matrix.hpp"
#include "msg/soccer.hpp"
#include "soccer/world/ball_filter.hpp"

namespace sinew::soccer {

struct TeamMapOptions {
  double heard_s = 3;               // a mate that was silent for longer is not counted
  double ball_s = 5;                // older sightings of the ball tell nothing
  double ball_mps = 0.15;           // a ball that was not seen since may have been moved: m for each second
  double deceleration_mps2 = 0.35;  // of a ball that rolls
  double gate = 9;                  // squared difference by covariance beyond which two balls are two
  double most_mirrored = 0.3;       // a robot that may so well be in the other half tells nothing of the field
  double least_confidence = 0.3;
  double own_eyes_s = 1;  // a ball that the robot saw so lately is not overruled by one mate alone
  double doubt_s = 10;    // so long a mate that the own eyes contradicted counts half where two balls are two
  double feet_m = 0.25;   // a ball nearer than this before the robot is its own
};

/// One ball that somebody believes in.
struct BallReport {
  double x_m = 0, y_m = 0, vx_mps = 0, vy_mps = 0;
  math::Mat<2, 2> covariance;
  double confidence = 0;
  msg::Time seen{};
  std::uint32_t bit = 0;  // of TeamModel::ball_from
};

constexpr std::uint32_t kOwnBallBit = 31;

/// The own ball on the field; nothing when it or the place is not known well enough.
std::optional<BallReport> own_ball(const msg::BallModel& ball, const msg::FieldPose& pose,
                                   const TeamMapOptions& options);

/// A report of what this robot believes, for its mates; all but role, plays and to_ball_s.
void fill_report(const msg::FieldPose& pose, const msg::BallModel* ball, const TeamMapOptions& options,
                 msg::SoccerReport& out);

/// Puts together the ball and the counts; `out.mate` is there already. `now` ages the sightings. `doubted`: bit n: mate
/// n was contradicted by the own eyes lately.
void put_together(const std::optional<BallReport>& own, msg::Time now, const TeamMapOptions& options,
                  std::uint32_t doubted, msg::TeamModel& out);

}  // namespace sinew::soccer
