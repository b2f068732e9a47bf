#pragma once
// Motions that show what a joint is like: which setpoint, when.
#include <array>
#include <cstdint>

#include "math/random.hpp"

namespace sinew::control {

/// Where a joint may go, and how fast.
struct ExcitationRange {
  double centre_rad = 0;
  double reach_rad = 0.5;  // to each side; 0: it stays at its centre
  double fast_radps = 4;   // of setpoints that swing
  double jump_radps = 40;  // of setpoints that jump: below what the guardian takes for a fault
};

/// One joint moves after the other, the others stay. It moves in rounds, each with all that shows something, at other
/// places and with other phases, so that each part of a record can be fitted alone and the last ones are held out:
///   1  a slow sweep there and back: gravity, Coulomb friction
///   2  small, slow turns: play, friction at its reversal
///   3  a sum of sines of 0.7 to 7 Hz: inertia, damping
///   4  jumps: delay, stall torque, speed without load
/// Then all joints swing together, slowly, for what couples them.
/// Source:  sums of sines: J. Swevers and others, Optimal robot excitation and identification (1997).
/// Thread:  any.   RT: yes.
class ExcitationPlan {
 public:
  std::int64_t rounds = 10;
  double round_s = 6;
  double together_s = 0;
  double turn_rad = 0.03;  // of the small turns, to each side
  std::uint64_t seed = 1;  // of places, phases and jumps

  static constexpr double kBetween_s = 1;  // at the centre, before each joint's motion
  double joint_s() const { return kBetween_s + static_cast<double>(rounds) * round_s; }
  double whole_s(std::size_t joints) const { return static_cast<double>(joints) * joint_s() + together_s + kBetween_s; }

  /// The setpoint of a joint, `t_s` after the beginning; its centre before and after.
  double target_rad(std::size_t joint, std::size_t joints, const ExcitationRange& range, double t_s) const;

 private:
  double round_rad(math::Random random, const ExcitationRange& range, double t_s) const;
};

}  // namespace sinew::control
