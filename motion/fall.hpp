#pragma once
// Falls: seen before the ground is hit, and what the body does until then.
#include "motion/figure.hpp"
#include "motion/param.hpp"

namespace sinew::motion {

enum class FallWay : std::uint8_t { none, front, back, left, right };

struct FallParams {
  double omega_radps = 6;
  double pitch_front_rad = 0.75, pitch_back_rad = 0.65, roll_rad = 0.6;
  double smooth_s = 0.01;
  double hold_s = 0.02;
  double give_way_s = 0;
  double relax_share = 0.25;
  double lying_rad = 1.0, rest_radps = 0.3, rest_s = 0.4;
};

inline constexpr Param<FallParams> kFallParams[] = {
    {"omega_radps", &FallParams::omega_radps, "rad/s", 2, 15, "of the toppling body: how much its rate counts"},
    {"pitch_front_rad", &FallParams::pitch_front_rad, "rad", 0.2, 1.5, "tilt and rate / omega of a fall forward"},
    {"pitch_back_rad", &FallParams::pitch_back_rad, "rad", 0.2, 1.5, "the same backward"},
    {"roll_rad", &FallParams::roll_rad, "rad", 0.2, 1.5, "the same to a side"},
    {"smooth_s", &FallParams::smooth_s, "s", 0, 0.1, "low pass of the rate"},
    {"hold_s", &FallParams::hold_s, "s", 0, 0.2, "how long it has to be so"},
    {"give_way_s", &FallParams::give_way_s, "s", 0, 0.5,
     "from then until the joints give way, which lets the body hit the ground sooner"},
    {"relax_share", &FallParams::relax_share, "1", 0, 1, "of the servos' torque, from then until the body lies"},
    {"lying_rad", &FallParams::lying_rad, "rad", 0.5, 1.5, "tilt of a body that lies"},
    {"rest_radps", &FallParams::rest_radps, "rad/s", 0.05, 2, "a body that turns slower has come to rest"},
    {"rest_s", &FallParams::rest_s, "s", 0.1, 3, "for so long"},
};

/// Tells a fall that cannot be helped any more from a sway: a body that tilts as a pendulum on its feet's edge comes
/// to rest where tilt + rate / omega says, so beyond some angle it goes on falling. What was told is taken back when it
/// is so no more before the joints gave way.
/// Frames:  tilt and rate in torso axes. Thread:  owner.   RT: yes.
class FallDetector {
 public:
  FallParams params;

  /// `up`: in torso axes; `rate_radps` without bias.
  void step(const math::Vec3& up, const math::Vec3& rate_radps, double dt_s);
  void reset() { *this = FallDetector{params}; }

  FallDetector() = default;
  explicit FallDetector(const FallParams& p) : params(p) {}

  /// State (kept_numbers.hpp).
  template <class Visit>
  void each_part(Visit&& visit) {
    visit(rate_, forward_rad_, left_rad_, beyond_s_, told_s_, still_s_, rest_s_, way_);
  }
  /// From the moment at which a fall was seen, until reset() or until it was taken back.
  FallWay way() const { return way_; }
  /// The joints are to give way: from give_way_s after that moment until reset().
  bool gives_way() const { return way_ != FallWay::none && told_s_ >= params.give_way_s; }
  /// It has fallen, and lies still.
  bool lies() const { return still_s_ >= params.rest_s; }
  /// So long it has not moved, at whatever tilt.
  double rests_s() const { return rest_s_; }
  /// tilt + rate / omega, forward and to the left: what is compared.
  double forward_rad() const { return forward_rad_; }
  double left_rad() const { return left_rad_; }

 private:
  math::Vec3 rate_;
  double forward_rad_ = 0, left_rad_ = 0, beyond_s_ = 0, told_s_ = 0, still_s_ = 0, rest_s_ = 0;
  FallWay way_ = FallWay::none;
};

/// On which side a body lies, from up in torso axes; none: it does not lie.
FallWay lying(const math::Vec3& up);

}  // namespace sinew::motion
