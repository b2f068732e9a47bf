#pragma once
#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// How well a robot with a gripper has fetched a ball. It is held while it is between closed paddles.
/// Thread:  owner.
class CarryScore {
 public:
  explicit CarryScore(const math::Vec3& start_m) : start_m_(start_m) {}
  /// After each step of the pitch.
  void look(const BodyTruth& robot, const BallTruth& ball, bool driven);

  std::uint32_t grips() const { return grips_; }
  bool has_begun() const { return begun_; }
  bool holds() const { return held_; }
  void add_to(JsonObject& report) const;
  /// Good: the ball was carried, lies where the robot began, and was let go.
  Verdict verdict() const;
  std::string text() const;

 private:
  std::string words() const;
  double error_m() const;

  math::Vec3 start_m_, from_m_, ball_m_;
  bool begun_ = false, held_ = false;
  std::uint32_t grips_ = 0;
  double carried_m_ = 0;  // from where it was taken to where it was last held
  double apart_m_ = 0, ball_mps_ = 0;
};

}  // namespace sinew::plant
