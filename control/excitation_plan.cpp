#include "control/excitation_plan.hpp"

#include <algorithm>

#include "math/elementary.hpp"

namespace sinew::control {
namespace {

constexpr double kTurn = 2 * math::kPi;
constexpr double kJump_s = 0.36;  // from one jump to the next: a servo of 5 rad/s has arrived
constexpr double kEdge_s = 0.2;   // in which a swing begins and ends
constexpr double kTurns_hz = 1.5;

/// -1 to 1 and back in a period of 1, 0 at 0.
double triangle(double x) {
  const double phase = x - math::floor(x);
  return phase < 0.25 ? 4 * phase : phase < 0.75 ? 2 - 4 * phase : 4 * phase - 4;
}

/// 0 at both ends and 1 in between.
double fade(double t_s, double length_s, double edge_s = kEdge_s) {
  const double edge = std::clamp(std::min(t_s, length_s - t_s) / edge_s, 0.0, 1.0);
  return edge * edge * (3 - 2 * edge);
}

double sines_rad(math::Random& random, const ExcitationRange& range, double least_hz, double t_s, double length_s) {
  constexpr int kSines = 6;
  constexpr double kRatio = 1.59;  // from one to the next: 10 in all, and no common period
  double sum = 0, hz = least_hz;
  for (int k = 0; k < kSines; ++k, hz *= kRatio) {
    const double most = std::min(range.reach_rad / 2, range.fast_radps / 2 / (kTurn * hz));
    sum += most * math::sin(kTurn * (hz * t_s + random.uniform()));
  }
  return std::clamp(sum, -range.reach_rad, range.reach_rad) * fade(t_s, length_s);
}

double jumps_rad(math::Random& random, const ExcitationRange& range, double t_s, double length_s) {
  double from = 0, to = 0, side = random.uniform() < 0.5 ? 1 : -1;
  const double last = math::floor(length_s / kJump_s) - 1, now = math::floor(t_s / kJump_s);
  for (double k = 0; k <= now; ++k) {
    // Far to the other side mostly, so that the motor gets to its largest torque and speed.
    from = to, side = -side;
    to = k < last ? range.reach_rad * side * random.uniform(0.1, 1) : 0;
  }
  const double way = range.jump_radps * (t_s - now * kJump_s);
  return from + std::clamp(to - from, -way, way);
}

}  // namespace

double ExcitationPlan::round_rad(math::Random random, const ExcitationRange& range, double t_s) const {
  const double part_s = round_s / 4, part = math::floor(t_s / part_s), t = t_s - part * part_s;
  constexpr double kLeast_hz = 0.7;
  const double side = random.uniform() < 0.5 ? 1 : -1, reach = range.reach_rad;
  const double sweep = side * reach * random.uniform(0.4, 1), at = reach * random.uniform(-0.9, 0.9);
  if (part <= 0) return sweep * (1 - math::fabs(2 * t / part_s - 1));
  if (part <= 1) {
    const double turn = std::min(turn_rad, reach);
    return std::clamp(at, turn - reach, reach - turn) * fade(t, part_s, 0.25 * part_s) +
           turn * triangle(kTurns_hz * t) * fade(t, part_s);
  }
  if (part <= 2) return sines_rad(random, range, kLeast_hz, t, part_s);
  return jumps_rad(random, range, t, part_s);
}

double ExcitationPlan::target_rad(std::size_t joint, std::size_t joints, const ExcitationRange& range,
                                  double t_s) const {
  if (!(range.reach_rad > 0)) return range.centre_rad;
  const auto stream = static_cast<std::uint32_t>(joint);
  const double alone = t_s - static_cast<double>(joint) * joint_s() - kBetween_s;
  const double together = t_s - static_cast<double>(joints) * joint_s() - kBetween_s;
  double moved = 0;
  if (alone >= 0 && alone < static_cast<double>(rounds) * round_s) {
    const double round = math::floor(alone / round_s);
    const math::Random random(seed, stream, 1 + static_cast<std::uint64_t>(round));
    moved = round_rad(random, range, alone - round * round_s);
  } else if (together >= 0 && together < together_s) {
    constexpr double kLeast_hz = 0.12;  // up to 1.2 Hz
    math::Random random(seed, stream);
    moved = sines_rad(random, range, kLeast_hz, together, together_s);
  }
  return range.centre_rad + moved;
}

}  // namespace sinew::control
