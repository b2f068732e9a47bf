#pragma once
// The attitude of a torso that walks: gyro integrated, slowly drawn to the accelerometer's down.
#include "math/linear.hpp"

namespace sinew::motion {

struct TiltParams {
  double accel_per_s = 0.8;   // how fast the tilt is drawn to the accelerometer's
  double most_mps2 = 25;      // what it measures above this is a blow, and not used
  double bias_per_s2 = 0.06;  // how fast the gyro's bias is learned from the same error
  double rest_per_s = 1;      // how fast it is learned from a torso at rest
  double settle_s = 0.5;      // about the vertical: only after so much of a rest
  double rest_memory_s = 5;   // and then the mean over so much of rest, or over as much as there was
  double rest_radps = 0.08;   // a torso at rest turns slower than this
  double most_bias_radps = 0.05;
};

/// The attitude from gyro and accelerometer; yaw is the gyro's integral. A complementary filter: a walking torso is
/// shaken with the rhythm of its steps, which the slow draw averages out: the mean of the specific force over a step is
/// g, as long as each sample has the same weight, so nothing is normalised and little is left out.
/// Source:  R. Mahony, T. Hamel, J. Pflimlin, Nonlinear complementary filters on the special orthogonal group (2008).
/// Frames:  q_world_torso, world z up. Thread:  owner.   RT: yes.
class Tilt {
 public:
  TiltParams params;

  /// Attitude from the accelerometer alone, yaw 0.
  void start(const math::Vec3& accel_mps2);
  /// `at_rest`: the body is not meant to move, so what the gyro says is its bias, that of yaw, too.
  void step(const math::Vec3& gyro_radps, const math::Vec3& accel_mps2, bool at_rest, double dt_s);

  const math::Quat& q_world_torso() const { return q_; }
  /// Without the bias, torso axes.
  const math::Vec3& rate_radps() const { return rate_; }
  const math::Vec3& bias_radps() const { return bias_; }
  /// Up in torso axes.
  math::Vec3 up() const { return q_.conjugate().rotate({0, 0, 1}); }
  /// State (kept_numbers.hpp).
  template <class Visit>
  void each_part(Visit&& visit) {
    visit(q_, rate_, bias_, rest_s_, learned_s_);
  }

 private:
  math::Quat q_;
  math::Vec3 rate_, bias_;
  double rest_s_ = 0, learned_s_ = 0;
};

}  // namespace sinew::motion
