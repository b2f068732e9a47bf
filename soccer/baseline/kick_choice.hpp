#pragma once
// Which kick, and where to stand for it. Frame: "field" of msg/soccer.hpp, unless it says "robot". Thread:  any.
// RT: yes.
#include <array>
#include <span>

#include "msg/kick.hpp"
#include "soccer/baseline/walk_to.hpp"

namespace sinew::soccer::baseline {

/// What a kick does, as measured (docs/walking.md).
struct KickKind {
  msg::BallMotion motion = msg::BallMotion::kick_forward;
  bool in_walk = false;
  FieldPoint ball{0.15, 0.05};  // frame "robot": where the ball has to lie for the left foot; mirrored for the right
  double direction_rad = 0;     // in which it goes from there; to the left for the left foot
  double rolls_m = 1;           // how far
  double lasts_s = 1;           // until the robot can walk again
};

struct KickOptions {
  std::array<KickKind, 4> kinds{};
  double walk_mps = 0.2, turn_radps = 0.8;  // of the way to where it kicks
  double near_m = 0.8;                      // an opponent that is so near to the ball does not wait for a slow kick
  double hurry = 2;                         // then a second of the kick itself counts so much
  double blocked_m = 0.12;                  // from the ball's way to somebody's edge: nearer, it does not pass
  double keeps_s = 1.5;                     // another kick must be so much better than the chosen one
};

/// A kick for which somebody walks to `from`.
struct ChosenKick {
  std::uint32_t kind = 0;  // place in KickOptions::kinds
  msg::Foot foot = msg::Foot::left;
  FieldAt from{};
  double cost_s = math::kInf;
};

/// The direction from the ball into the other goal: the middle of the widest part of its mouth that nobody stands in
/// front of; the middle of the goal from far away. `others`: frame "field".
double aim_rad(const FieldPoint& ball, const Field& field, std::span<const Round> others);

/// The kick that brings the ball along `aim_rad` soonest, straight or aside of it where somebody stands before the
/// ball: time to walk and turn there, of the kick, and to walk the way that the ball is not brought ahead. `others`:
/// frame "field". `before`: the one chosen last, kept unless another one is clearly better; null: none.
ChosenKick choose_kick(const FieldAt& robot, const FieldPoint& ball, double aim_rad, std::span<const Round> others,
                       const ChosenKick* before, const KickOptions& options);

/// Where to stand so that `kind` with `foot` sends a ball that lies at `ball` along `aim_rad`.
FieldAt stand_for(const KickKind& kind, msg::Foot foot, const FieldPoint& ball, double aim_rad);

}  // namespace sinew::soccer::baseline
