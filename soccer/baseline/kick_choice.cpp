#include "soccer/baseline/kick_choice.hpp"

#include <algorithm>

namespace sinew::soccer::baseline {
namespace {

constexpr double kRoundTheBall_m = 0.3;
constexpr double kAimMiddle_m = 2.5;   // from farther away the middle of the goal is good enough
constexpr double kBesidePost_m = 0.2;  // of the aim

constexpr double kAside_rad[] = {0, 0.5, -0.5, 1, -1};
constexpr double kSameWay_rad = 0.35;

/// How far a ball rolls that way until it comes to somebody.
double free_way_m(const FieldPoint& ball, double way_rad, std::span<const Round> others, double keep_m) {
  const FieldAt along{ball.x_m, ball.y_m, way_rad};
  double free_m = math::kInf;
  for (const Round& r : others) {
    const FieldPoint p = along.in(r.at.x_m, r.at.y_m);
    if (p.x_m > 0 && math::fabs(p.y_m) < r.radius_m + keep_m)
      free_m = std::min(free_m, std::max(0.0, p.x_m - r.radius_m));
  }
  return free_m;
}

double side_of(msg::Foot foot) { return foot == msg::Foot::left ? 1 : -1; }

/// Walking there: straight, and round the ball where it lies in between.
double time_to_s(const FieldAt& robot, const FieldAt& to, const FieldPoint& ball, const KickOptions& o) {
  const double straight_m = distance_m(robot, to);
  const FieldPoint from_ball = ball - FieldPoint{robot.x_m, robot.y_m};
  const double to_ball_m = length_m(from_ball);
  const FieldPoint at_ball{to.x_m - ball.x_m, to.y_m - ball.y_m};
  // The angle at the ball between where the robot is and where it has to be.
  const double round_rad =
      to_ball_m > 0 ? math::fabs(math::wrap_pi(bearing_rad(-1.0 * from_ball) - bearing_rad(at_ball))) : 0;
  const double way_m = std::max(straight_m, std::max(0.0, to_ball_m - kRoundTheBall_m) + kRoundTheBall_m * round_rad);
  return std::max(way_m / o.walk_mps, turn_between_rad(robot, to) / o.turn_radps);
}

}  // namespace

double aim_rad(const FieldPoint& ball, const Field& field, std::span<const Round> others) {
  const FieldSize& size = field.size();
  const FieldPoint goal{0.5 * size.length_m, 0};
  if (length_m(goal - ball) > kAimMiddle_m) return bearing_rad(goal - ball);
  const double half_m = 0.5 * size.goal_width_m - kBesidePost_m;
  // Along the goal line: where somebody stands in between is shadow. Tried at 32 places; the widest run of free ones.
  constexpr int kPlaces = 32;
  const auto place = [&](int i) { return FieldPoint{goal.x_m, half_m * (2.0 * i / (kPlaces - 1) - 1)}; };
  const auto free = [&](int i) {
    const FieldPoint way = place(i) - ball;
    const double far_m = length_m(way);
    if (far_m <= 0) return true;
    return std::ranges::none_of(others, [&](const Round& r) {
      const FieldPoint to = r.at - ball;
      const double along = (to.x_m * way.x_m + to.y_m * way.y_m) / far_m;
      const double across = math::fabs(to.x_m * way.y_m - to.y_m * way.x_m) / far_m;
      return along > 0 && along < far_m && across < r.radius_m + 0.1;
    });
  };
  int best_from = 0, best_n = 0, from = 0, n = 0;
  for (int i = 0; i < kPlaces; ++i) {
    if (!free(i)) {
      n = 0;
      continue;
    }
    if (n == 0) from = i;
    if (++n > best_n) best_from = from, best_n = n;
  }
  if (best_n == 0) return bearing_rad(goal - ball);
  const FieldPoint a = place(best_from), b = place(best_from + best_n - 1);
  return bearing_rad(0.5 * (a + b) - ball);
}

FieldAt stand_for(const KickKind& kind, msg::Foot foot, const FieldPoint& ball, double aim_rad) {
  const double side = side_of(foot);
  const double heading = math::wrap_pi(aim_rad - side * kind.direction_rad);
  const FieldPoint at = FieldAt{0, 0, heading}.out(kind.ball.x_m, side * kind.ball.y_m);
  return {ball.x_m - at.x_m, ball.y_m - at.y_m, heading};
}

ChosenKick choose_kick(const FieldAt& robot, const FieldPoint& ball, double aim_rad, std::span<const Round> others,
                       const ChosenKick* before, const KickOptions& o) {
  const bool hurry =
      std::ranges::any_of(others, [&](const Round& r) { return length_m(r.at - ball) - r.radius_m < o.near_m; });
  double most_m = 0;
  for (const KickKind& kind : o.kinds) most_m = std::max(most_m, kind.rolls_m);
  ChosenKick best;
  for (const double aside_rad : kAside_rad) {
    const double way_rad = aim_rad + aside_rad;
    const double free_m = free_way_m(ball, way_rad, others, o.blocked_m);
    for (std::uint32_t k = 0; k < o.kinds.size(); ++k) {
      const KickKind& kind = o.kinds[k];
      if (kind.rolls_m <= 0) continue;
      for (const msg::Foot foot : {msg::Foot::left, msg::Foot::right}) {
        ChosenKick c{k, foot, stand_for(kind, foot, ball, way_rad)};
        // What it does not roll ahead has to be walked behind the ball.
        const double ahead_m = std::min(kind.rolls_m, free_m) * math::cos(aside_rad);
        c.cost_s =
            time_to_s(robot, c.from, ball, o) + (hurry ? o.hurry : 1) * kind.lasts_s + (most_m - ahead_m) / o.walk_mps;
        const bool same = before && before->cost_s < math::kInf && before->kind == k && before->foot == foot &&
                          turn_between_rad(before->from, c.from) < kSameWay_rad;
        if (same) c.cost_s -= o.keeps_s;
        if (c.cost_s < best.cost_s) best = c;
      }
    }
  }
  return best;
}

}  // namespace sinew::soccer::baseline
