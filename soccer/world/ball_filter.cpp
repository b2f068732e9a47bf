#include "soccer/world/ball_filter.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

constexpr double kClutter = 0.05;     // density of sightings that are no balls, 1/m^2
constexpr double kSameBall_m = 0.12;  // filters of one kind this near are of the same ball
constexpr double kStarts_chi2 = 5;    // a resting ball whose sighting is off by more may have begun to roll
constexpr double kLeastBallWeight = -10, kLeastBallConfidence = 0.02;
constexpr double kRollPenalty = 1.5;  // logarithm: most balls rest
constexpr double kGone = 0.15;        // confidence below which a ball that was looked for is gone
constexpr std::uint32_t kSureSightings = 2;
// False sightings come again at the same place: one more tells less than its own confidence says.
constexpr double kFirst = 0.25, kMostTold = 0.65, kMostSure = 0.98;

/// The noise of a place that was seen, in the frame that `at` is in.
math::Mat<2, 2> noise_of(const msg::GroundPoint& p, const FieldAt& at, double scale, double floor_m) {
  const math::SinCos t = math::sincos(at.heading_rad);
  const math::Mat<2, 2> turn{t.cos, -t.sin, t.sin, t.cos};
  const math::Mat<2, 2> c{p.xx_m2, p.xy_m2, p.xy_m2, p.yy_m2};
  math::Mat<2, 2> r = (turn * c * turn.transpose()) * (scale * scale);
  r(0, 0) += floor_m * floor_m, r(1, 1) += floor_m * floor_m;
  return r.symmetric();
}

bool is_usable(const msg::SeenBall& b) {
  const double sum = double{b.at.x_m} + b.at.y_m + b.at.xx_m2 + b.at.xy_m2 + b.at.yy_m2 + b.confidence;
  return math::is_finite(sum) && math::fabs(double{b.at.x_m}) < 20 && math::fabs(double{b.at.y_m}) < 20 &&
         b.at.xx_m2 > 0 && b.at.yy_m2 > 0;
}

}  // namespace

double RollingBall::stops_after_s(double deceleration_mps2) const {
  return deceleration_mps2 > 0 ? math::hypot(vx_mps, vy_mps) / deceleration_mps2 : math::kInf;
}

RollingBall RollingBall::after(double s, double deceleration_mps2) const {
  const double speed = math::hypot(vx_mps, vy_mps);
  if (!(s > 0) || !(speed > 0)) return *this;
  const double t = std::min(s, stops_after_s(deceleration_mps2));
  const double way = speed * t - 0.5 * deceleration_mps2 * t * t, left = std::max(0.0, speed - deceleration_mps2 * t);
  return {x_m + vx_mps / speed * way, y_m + vy_mps / speed * way, vx_mps / speed * left, vy_mps / speed * left};
}

std::span<const FieldPoint> BallFilter::predict(const msg::SoccerSight& sight) {
  const FieldAt robot{sight.x_m, sight.y_m, sight.heading_rad};
  const double dt =
      s_.stamp_ns == 0 ? 0 : std::clamp(1e-9 * static_cast<double>(sight.stamp.ns - s_.stamp_ns), 0.0, 10.0);
  const double way = s_.stamp_ns == 0 ? 0 : distance_m(robot, s_.robot);
  const double kept = math::exp(-dt / o_.forget_s), faded = math::exp(-dt / o_.evidence_s);
  for (std::size_t i = 0; i < s_.count; ++i) {
    Track& t = s_.track[i];
    t.ball = t.ball.after(dt, o_.deceleration_mps2);
    if (t.rolls != 0) {
      math::Mat<4, 4> f = math::Mat<4, 4>::identity();
      f(0, 2) = f(1, 3) = dt;
      t.covariance = (f * t.covariance * f.transpose()).symmetric();
      t.covariance(2, 2) += o_.push_mps2 * o_.push_mps2 * dt, t.covariance(3, 3) += o_.push_mps2 * o_.push_mps2 * dt;
    }
    const double place = o_.rest_mps * o_.rest_mps * dt + o_.way_sigma * o_.way_sigma * way;
    t.covariance(0, 0) += place, t.covariance(1, 1) += place;
    t.confidence *= kept;
    t.log_weight *= faded;
    predicted_[i] = robot.in(t.ball.x_m, t.ball.y_m);
  }
  s_.robot = robot;
  s_.stamp_ns = std::max(s_.stamp_ns, sight.stamp.ns);
  return {predicted_.data(), s_.count};
}

void BallFilter::spawn(const FieldPoint& at, const msg::SeenBall& seen, const math::Mat<2, 2>& noise, bool rolls) {
  Track t;
  t.ball = {at.x_m, at.y_m, 0, 0};
  t.covariance.set_block(0, 0, noise);
  if (rolls) t.covariance(2, 2) = t.covariance(3, 3) = o_.kick_mps * o_.kick_mps;
  t.rolls = rolls ? 1 : 0;
  t.confidence = kFirst * static_cast<double>(seen.confidence);
  t.log_weight = -1 - (rolls ? kRollPenalty : 0);
  t.seen_ns = s_.stamp_ns;
  t.sightings = 1;
  if (s_.count < kMost) {
    s_.track[s_.count++] = t;
    return;
  }
  Track* worst = &s_.track[0];
  for (Track& o : s_.track)
    if (o.log_weight < worst->log_weight) worst = &o;
  if (worst->log_weight < t.log_weight) *worst = t;
}

void BallFilter::see(const msg::SoccerSight& sight, std::span<const bool> shown) {
  const std::size_t before = s_.count;
  const std::size_t balls = std::min<std::size_t>(sight.balls, sight.ball.size());
  std::array<bool, 4> explained{}, starts{};
  bool looked_and_missed = false;
  for (std::size_t i = 0; i < before; ++i) {
    Track& t = s_.track[i];
    double best = math::kInf, best_density = 0;
    std::size_t which = balls;
    for (std::size_t k = 0; k < balls; ++k) {
      const msg::SeenBall& b = sight.ball[k];
      if (!is_usable(b)) continue;
      const FieldPoint at = s_.robot.out(b.at.x_m, b.at.y_m);
      const math::Mat<2, 2> s = t.covariance.block<2, 2>(0, 0) + noise_of(b.at, s_.robot, o_.sight_scale, o_.floor_m);
      const auto factor = math::cholesky(s);
      if (!factor) continue;
      const math::Vec<2> e{at.x_m - t.ball.x_m, at.y_m - t.ball.y_m};
      const double chi2 = (e.transpose() * factor->solve(e)).a[0];
      if (chi2 < best) {
        best = chi2, which = k;
        best_density = math::exp(-0.5 * std::min(chi2, 60.0)) / (2 * math::kPi * factor->l(0, 0) * factor->l(1, 1));
      }
    }
    if (which < balls && best < o_.gate) {
      const msg::SeenBall& b = sight.ball[which];
      const FieldPoint at = s_.robot.out(b.at.x_m, b.at.y_m);
      const math::Mat<2, 2> s = t.covariance.block<2, 2>(0, 0) + noise_of(b.at, s_.robot, o_.sight_scale, o_.floor_m);
      const math::Mat<4, 2> pht = t.covariance.block<4, 2>(0, 0);
      const auto factor = math::cholesky(s);
      const math::Mat<4, 2> gain = factor->solve(pht.transpose()).transpose();
      const math::Vec<4> d = gain * math::Vec<2>{at.x_m - t.ball.x_m, at.y_m - t.ball.y_m};
      t.ball.x_m += d(0), t.ball.y_m += d(1);
      if (t.rolls != 0) t.ball.vx_mps += d(2), t.ball.vy_mps += d(3);
      t.covariance = (t.covariance - gain * pht.transpose()).symmetric();
      t.log_weight += math::log(kClutter + double{b.confidence} * best_density);
      const double p = std::max(t.confidence, 0.05), c = std::min(double{b.confidence}, kMostTold);
      t.confidence = std::min(kMostSure, p * c / (p * c + (1 - p) * (1 - c)));
      t.seen_ns = s_.stamp_ns;
      t.chi2 = best;
      ++t.sightings;
      explained[which] = true;
      starts[which] = starts[which] || (t.rolls == 0 && best > kStarts_chi2);
    } else {
      t.log_weight += math::log(kClutter);
      if (i >= shown.size() || !shown[i]) continue;
      const double missed = t.confidence * (1 - o_.seen_share);
      t.confidence = missed / (missed + 1 - t.confidence);
      t.log_weight += math::log(1 - o_.seen_share);
      looked_and_missed = looked_and_missed || i == 0;
    }
  }
  for (std::size_t k = 0; k < balls; ++k) {
    const msg::SeenBall& b = sight.ball[k];
    if (!is_usable(b) || (explained[k] && !starts[k])) continue;
    const FieldPoint at = s_.robot.out(b.at.x_m, b.at.y_m);
    const math::Mat<2, 2> noise = noise_of(b.at, s_.robot, o_.sight_scale, o_.floor_m);
    if (!explained[k]) spawn(at, b, noise, false);
    spawn(at, b, noise, true);
  }
  if (std::ranges::any_of(explained, [](bool e) { return e; })) ++s_.sightings;
  const Track* lead = best();
  if (lead && lead->confidence < kGone && looked_and_missed) s_.gone = 1;
  if (lead && lead->seen_ns == s_.stamp_ns) s_.gone = 0;
  tidy();
}

const BallFilter::Track* BallFilter::best() const { return s_.count > 0 ? &s_.track[0] : nullptr; }

void BallFilter::tidy() {
  // A filter that was confirmed goes before those that were not; then the weight decides.
  const auto rank = [](const Track& t) {
    return t.log_weight + math::log(std::max(1e-3, t.confidence)) + (t.sightings >= kSureSightings ? 0 : -6);
  };
  for (std::size_t i = 1; i < s_.count; ++i)
    for (std::size_t k = i; k > 0 && rank(s_.track[k]) > rank(s_.track[k - 1]); --k)
      std::swap(s_.track[k], s_.track[k - 1]);
  const double top = s_.count > 0 ? s_.track[0].log_weight : 0;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < s_.count; ++i) {
    Track t = s_.track[i];
    t.log_weight -= top;
    const bool last = i == 0;  // what is left of the last ball: where it was is where to look
    if (!last && (t.log_weight < kLeastBallWeight || t.confidence < kLeastBallConfidence)) continue;
    const bool doubled =
        std::any_of(s_.track.begin(), s_.track.begin() + static_cast<std::ptrdiff_t>(kept), [&](const Track& o) {
          const double speed = math::hypot(o.ball.vx_mps - t.ball.vx_mps, o.ball.vy_mps - t.ball.vy_mps);
          // A new one that has just begun to roll is no double of one that has been slow for long.
          return o.rolls == t.rolls && speed < 0.15 && t.covariance(2, 2) <= 4 * o.covariance(2, 2) &&
                 math::hypot(o.ball.x_m - t.ball.x_m, o.ball.y_m - t.ball.y_m) < kSameBall_m;
        });
    if (!doubled) s_.track[kept++] = t;
  }
  s_.count = static_cast<std::uint32_t>(kept);
}

void BallFilter::fill(msg::BallModel& out) const {
  out.sightings = s_.sightings;
  out.gone = s_.gone;
  const Track* t = best();
  if (!t || t->sightings < kSureSightings) return;
  const FieldPoint at = s_.robot.in(t->ball.x_m, t->ball.y_m);
  const math::SinCos turn = math::sincos(s_.robot.heading_rad);
  out.seen = {t->seen_ns};
  out.x_m = at.x_m, out.y_m = at.y_m;
  out.vx_mps = turn.cos * t->ball.vx_mps + turn.sin * t->ball.vy_mps;
  out.vy_mps = turn.cos * t->ball.vy_mps - turn.sin * t->ball.vx_mps;
  math::Mat<4, 4> r;
  const math::Mat<2, 2> back{turn.cos, turn.sin, -turn.sin, turn.cos};
  r.set_block(0, 0, back), r.set_block(2, 2, back);
  const math::Mat<4, 4> c = (r * t->covariance * r.transpose()).symmetric();
  for (std::size_t i = 0; i < 16; ++i) out.covariance[i] = c.a[i];
  out.confidence = t->confidence;
}

}  // namespace sinew::soccer
