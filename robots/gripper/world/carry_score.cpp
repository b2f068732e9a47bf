#include "robots/gripper/world/carry_score.hpp"

#include <cstdio>

#include "sim_hil/pitch/wheeled.hpp"
#include "sim_hil/worlds/json_object.hpp"

namespace sinew::plant {
namespace {

constexpr double kLeastWay_m = 1, kMostError_m = 0.5;
constexpr double kApart_m = 0.5;  // from the wheels: it has let go and moved away
constexpr double kRolls_mps = 0.05;
constexpr double kSlack_m = 0.02;      // between the ball and paddles that hold it
constexpr double kLostSlack_m = 0.06;  // likewise, until it counts as let go

}  // namespace

void CarryScore::look(const BodyTruth& robot, const BallTruth& ball, bool driven) {
  begun_ = begun_ || driven;
  const math::Vec3 at = robot.torso.inverse().of(ball.p_m);
  const double opening_m = kPioneer.opening_m - robot.joint_rad[kLeftPaddle] - robot.joint_rad[kRightPaddle];
  const double reach_m = kPioneer.length_m / 2 + kPioneer.middle_x_m;
  const bool between = at.x > reach_m && at.x < reach_m + kPioneer.paddle_long_m + kKidBall.radius_m &&
                       math::fabs(at.y) < kPioneer.opening_m / 2;
  const bool closed = opening_m < 2 * kKidBall.radius_m + (held_ ? kLostSlack_m : kSlack_m);
  const bool held = between && closed;
  if (held && !held_) {
    ++grips_;
    from_m_ = ball.p_m;
  }
  held_ = held;
  if (held) carried_m_ = math::hypot(ball.p_m.x - from_m_.x, ball.p_m.y - from_m_.y);
  apart_m_ = math::hypot(at.x, at.y);
  ball_m_ = ball.p_m;
  ball_mps_ = math::norm(ball.v_mps);
}

double CarryScore::error_m() const { return math::hypot(ball_m_.x - start_m_.x, ball_m_.y - start_m_.y); }

std::string CarryScore::words() const {
  if (!begun_) return "its motors never had a command";
  if (grips_ == 0) return "never held the ball";
  if (held_) return "holds the ball";
  if (carried_m_ < kLeastWay_m) return "took the ball, and carried it nowhere";
  if (error_m() > kMostError_m) return "carried the ball to another place";
  return apart_m_ >= kApart_m && ball_mps_ < kRolls_mps ? "fetched the ball" : "is still at the ball";
}

Verdict CarryScore::verdict() const {
  Verdict v;
  v.outcome = words();
  v.begun = begun_;
  v.good = begun_ && grips_ > 0 && !held_ && carried_m_ >= kLeastWay_m && error_m() <= kMostError_m &&
           apart_m_ >= kApart_m && ball_mps_ < kRolls_mps;
  v.measures = {{"carried_m", "carried", "m", carried_m_, kLeastWay_m, true},
                {"ball_from_start_m", "ball from the robot's start", "m", error_m(), kMostError_m},
                {"grips", "grips", "", static_cast<double>(grips_)}};
  return v;
}

std::string CarryScore::text() const {
  char figures[96];
  std::snprintf(figures, sizeof figures, ": %.2f m carried, ball %.2f m from the start, %u grips", carried_m_,
                error_m(), grips_);
  return words() + figures;
}

void CarryScore::add_to(JsonObject& report) const {
  report.boolean("holds_ball", held_);
  report.integer("grips", grips_);
  report.number("carried_m", carried_m_);
  report.number("ball_from_start_m", error_m());
}

}  // namespace sinew::plant
