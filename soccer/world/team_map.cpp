#include "soccer/world/team_map.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

constexpr std::size_t kMostReports = 8;  // seven mates and this robot

/// As it would be seen now: rolled on, and less sure.
BallReport aged(BallReport b, msg::Time now, const TeamMapOptions& o) {
  const double age = std::max(0.0, msg::seconds(now - b.seen));
  const RollingBall at = RollingBall{b.x_m, b.y_m, b.vx_mps, b.vy_mps}.after(age, o.deceleration_mps2);
  b.x_m = at.x_m, b.y_m = at.y_m, b.vx_mps = at.vx_mps, b.vy_mps = at.vy_mps;
  const double moved = o.ball_mps * age;
  b.covariance(0, 0) += moved * moved, b.covariance(1, 1) += moved * moved;
  b.confidence *= std::max(0.0, 1 - age / o.ball_s);
  return b;
}

double chi2(const BallReport& a, const BallReport& b) {
  const auto factor = math::cholesky(a.covariance + b.covariance);
  if (!factor) return math::kInf;
  const math::Vec<2> e{a.x_m - b.x_m, a.y_m - b.y_m};
  return (e.transpose() * factor->solve(e)).a[0];
}

}  // namespace

std::optional<BallReport> own_ball(const msg::BallModel& ball, const msg::FieldPose& pose, const TeamMapOptions& o) {
  if (ball.seen.ns == 0 || ball.confidence < o.least_confidence || pose.found == 0 || pose.mirrored > o.most_mirrored)
    return std::nullopt;
  const math::SinCos t = math::sincos(pose.heading_rad);
  const math::Mat<2, 2> r{t.cos, -t.sin, t.sin, t.cos};
  const auto at = [&](std::size_t i) { return pose.covariance[i]; };
  const FieldPoint p = FieldAt{pose.x_m, pose.y_m, pose.heading_rad}.out(ball.x_m, ball.y_m);
  // The ball's own, turned; the robot's place; its heading at the ball's distance, and how it goes with the place.
  const math::Mat<2, 2> b{ball.covariance[0], ball.covariance[1], ball.covariance[4], ball.covariance[5]};
  const double jx = -(p.y_m - pose.y_m), jy = p.x_m - pose.x_m;
  const math::Mat<2, 2> place{
      at(0) + jx * jx * at(8) + 2 * jx * at(2), at(1) + jx * jy * at(8) + jx * at(5) + jy * at(2),
      at(1) + jx * jy * at(8) + jx * at(5) + jy * at(2), at(4) + jy * jy * at(8) + 2 * jy * at(5)};
  BallReport out;
  out.x_m = p.x_m, out.y_m = p.y_m;
  out.vx_mps = t.cos * ball.vx_mps - t.sin * ball.vy_mps, out.vy_mps = t.sin * ball.vx_mps + t.cos * ball.vy_mps;
  out.covariance = (r * b * r.transpose() + place).symmetric();
  out.confidence = ball.confidence;
  out.seen = ball.seen;
  out.bit = kOwnBallBit;
  return out;
}

void fill_report(const msg::FieldPose& pose, const msg::BallModel* ball, const TeamMapOptions& o,
                 msg::SoccerReport& out) {
  const auto f = [](double v) { return static_cast<float>(v); };
  out.x_m = f(pose.x_m), out.y_m = f(pose.y_m), out.heading_rad = f(pose.heading_rad);
  out.xx_m2 = f(pose.covariance[0]), out.xy_m2 = f(pose.covariance[1]), out.yy_m2 = f(pose.covariance[4]);
  out.heading_sigma_rad = f(math::sqrt(pose.covariance[8]));
  out.mirrored = pose.found != 0 ? f(pose.mirrored) : 0.5F;
  if (!ball) return;
  const std::optional<BallReport> b = own_ball(*ball, pose, o);
  if (!b) return;
  out.ball_seen = b->seen;
  out.ball = {f(b->x_m), f(b->y_m), f(b->covariance(0, 0)), f(b->covariance(0, 1)), f(b->covariance(1, 1))};
  out.ball_vx_mps = f(b->vx_mps), out.ball_vy_mps = f(b->vy_mps);
  out.ball_confidence = f(b->confidence);
  constexpr double kBeside_m = 0.12;
  out.has_ball = ball->x_m > 0 && ball->x_m < o.feet_m && math::fabs(ball->y_m) < kBeside_m ? 1 : 0;
}

void put_together(const std::optional<BallReport>& own, msg::Time now, const TeamMapOptions& o, std::uint32_t doubted,
                  msg::TeamModel& out) {
  std::array<BallReport, kMostReports> all;
  std::size_t count = 0;
  const auto use = [&](const BallReport& b) {
    if (b.seen.ns == 0 || msg::seconds(now - b.seen) > o.ball_s || b.confidence < o.least_confidence) return;
    const BallReport a = aged(b, now, o);
    if (a.confidence > 0 && math::cholesky(a.covariance)) all[count++] = a;
  };
  if (own) use(*own);
  for (std::size_t i = 0; i < out.mate.size(); ++i) {
    const msg::SoccerReport& m = out.mate[i];
    if (m.stamp.ns == 0 || m.plays == 0 || msg::seconds(now - m.stamp) > o.heard_s) continue;
    ++out.mates;
    if (double{m.mirrored} > o.most_mirrored) continue;
    use({double{m.ball.x_m}, double{m.ball.y_m}, double{m.ball_vx_mps}, double{m.ball_vy_mps},
         math::Mat<2, 2>{m.ball.xx_m2, m.ball.xy_m2, m.ball.xy_m2, m.ball.yy_m2}, double{m.ball_confidence},
         m.ball_seen, static_cast<std::uint32_t>(i)});
  }
  const bool sees = own && count > 0 && all[0].bit == kOwnBallBit && msg::seconds(now - own->seen) <= o.own_eyes_s;
  const auto weight_of = [&](const BallReport& b) {
    const bool doubt = b.bit != kOwnBallBit && (doubted >> b.bit & 1) != 0;
    return doubt ? 0.5 * b.confidence : b.confidence;
  };
  // The group around each; the own one counts first where two weigh the same.
  double best_weight = 0;
  std::size_t centre = count;
  for (std::size_t i = 0; i < count; ++i) {
    double weight = 0;
    std::size_t members = 0;
    for (std::size_t k = 0; k < count; ++k)
      if (k == i || chi2(all[i], all[k]) < o.gate) weight += weight_of(all[k]), ++members;
    if (sees && i != 0 && members == 1) continue;
    if (weight > best_weight) best_weight = weight, centre = i;
  }
  if (centre == count) return;
  math::Mat<2, 2> information;
  math::Vec<2> sum;
  double missing = 1, speed_weight = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const BallReport& b = all[k];
    if (k != centre && chi2(all[centre], b) >= o.gate) {
      if (b.bit != kOwnBallBit) out.distrusted |= 1U << b.bit;
      continue;
    }
    const math::Mat<2, 2> i = math::cholesky(b.covariance)->inverse();
    information += i;
    sum += i * math::Vec<2>{b.x_m, b.y_m};
    const double fresh = i.trace();
    out.ball_vx_mps += fresh * b.vx_mps, out.ball_vy_mps += fresh * b.vy_mps;
    speed_weight += fresh;
    missing *= 1 - b.confidence;
    out.ball_from |= 1U << b.bit;
    out.ball_seen = std::max(out.ball_seen, b.seen);
  }
  const math::Mat<2, 2> c = math::cholesky(information)->inverse();
  const math::Vec<2> at = c * sum;
  out.ball_x_m = at(0), out.ball_y_m = at(1);
  out.ball_vx_mps /= speed_weight, out.ball_vy_mps /= speed_weight;
  out.ball_covariance_m2 = {c(0, 0), c(0, 1), c(1, 0), c(1, 1)};
  out.ball_confidence = 1 - missing;
}

}  // namespace sinew::soccer
