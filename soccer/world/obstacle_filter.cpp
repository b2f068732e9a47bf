#include "soccer/world/obstacle_filter.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

constexpr double kLeastEvidence = 0.1;
constexpr double kStartSpeed_mps = 0.3;
constexpr double kJersey = 0.5;  // so much more of one colour than of the other

bool is_usable(const msg::SeenRobot& r) {
  return math::is_finite(double{r.at.x_m} + r.at.y_m + r.at.xx_m2 + r.at.xy_m2 + r.at.yy_m2 + r.confidence) &&
         math::fabs(double{r.at.x_m}) < 20 && math::fabs(double{r.at.y_m}) < 20;
}

}  // namespace

void ObstacleFilter::move(const msg::SoccerSight& sight) {
  const FieldAt robot{sight.x_m, sight.y_m, sight.heading_rad};
  const bool first = s_.stamp_ns == 0;
  const double dt = first ? 0 : std::clamp(1e-9 * static_cast<double>(sight.stamp.ns - s_.stamp_ns), 0.0, 10.0);
  const double way = first ? 0 : distance_m(robot, s_.robot);
  const double faded = math::exp(-dt / o_.forget_s), calm = math::exp(-dt / o_.calm_s);
  math::Mat<4, 4> f = math::Mat<4, 4>::identity();
  f(0, 2) = f(1, 3) = dt;
  f(2, 2) = f(3, 3) = calm;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < s_.count; ++i) {
    Track t = s_.track[i];
    t.state = f * t.state;
    t.covariance = (f * t.covariance * f.transpose()).symmetric();
    for (int k = 0; k < 2; ++k) {
      t.covariance(k, k) += o_.way_sigma * o_.way_sigma * way;
      t.covariance(k + 2, k + 2) += o_.push_mps2 * o_.push_mps2 * dt;
    }
    t.evidence *= faded, t.red *= faded;
    if (t.evidence > kLeastEvidence) s_.track[kept++] = t;
  }
  s_.count = static_cast<std::uint32_t>(kept);
  s_.robot = robot;
  s_.stamp_ns = std::max(s_.stamp_ns, sight.stamp.ns);
}

void ObstacleFilter::add(const msg::SeenRobot& seen) {
  const FieldPoint at = s_.robot.out(seen.at.x_m, seen.at.y_m);
  const math::SinCos turn = math::sincos(s_.robot.heading_rad);
  const math::Mat<2, 2> r{turn.cos, -turn.sin, turn.sin, turn.cos};
  math::Mat<2, 2> noise = r * math::Mat<2, 2>{seen.at.xx_m2, seen.at.xy_m2, seen.at.xy_m2, seen.at.yy_m2} *
                          r.transpose() * (o_.sight_scale * o_.sight_scale);
  noise(0, 0) += o_.floor_m * o_.floor_m, noise(1, 1) += o_.floor_m * o_.floor_m;
  noise = noise.symmetric();
  Track* best = nullptr;
  double best_chi2 = o_.gate;
  for (std::size_t i = 0; i < s_.count; ++i) {
    Track& t = s_.track[i];
    const auto factor = math::cholesky(t.covariance.block<2, 2>(0, 0) + noise);
    if (!factor) continue;
    const math::Vec<2> e{at.x_m - t.state(0), at.y_m - t.state(1)};
    const double chi2 = (e.transpose() * factor->solve(e)).a[0];
    if (chi2 < best_chi2) best = &t, best_chi2 = chi2;
  }
  const double red = seen.colour == msg::JerseyColour::red ? 1 : seen.colour == msg::JerseyColour::blue ? -1 : 0;
  if (best) {
    const math::Mat<4, 2> pht = best->covariance.block<4, 2>(0, 0);
    const auto factor = math::cholesky(best->covariance.block<2, 2>(0, 0) + noise);
    const math::Mat<4, 2> gain = factor->solve(pht.transpose()).transpose();
    best->state += gain * math::Vec<2>{at.x_m - best->state(0), at.y_m - best->state(1)};
    best->covariance = (best->covariance - gain * pht.transpose()).symmetric();
  } else {
    if (s_.count == kMost) {
      ++s_.dropped;
      return;
    }
    best = &s_.track[s_.count++];
    *best = {};
    best->state = {at.x_m, at.y_m, 0, 0};
    best->covariance.set_block(0, 0, noise);
    best->covariance(2, 2) = best->covariance(3, 3) = kStartSpeed_mps * kStartSpeed_mps;
  }
  best->evidence += double{seen.confidence};
  best->red += red;
  best->seen_ns = s_.stamp_ns;
  ++best->sightings;
}

void ObstacleFilter::see(const msg::SoccerSight& sight) {
  move(sight);
  for (std::uint32_t i = 0; i < std::min<std::size_t>(sight.robots, sight.robot.size()); ++i)
    if (is_usable(sight.robot[i])) add(sight.robot[i]);
}

void ObstacleFilter::fill(msg::ObstacleModel& out) {
  std::array<double, 12> far{};
  const math::SinCos turn = math::sincos(s_.robot.heading_rad);
  std::uint32_t dropped = s_.dropped;
  for (std::size_t i = 0; i < s_.count; ++i) {
    const Track& t = s_.track[i];
    if (t.evidence < o_.least_sightings) continue;
    const FieldPoint at = s_.robot.in(t.state(0), t.state(1));
    const double d = math::hypot(at.x_m, at.y_m);
    std::size_t place = out.obstacles;
    if (place == out.obstacle.size()) {
      ++dropped;
      if (!(d < far[place - 1])) continue;
      --place;
    } else {
      ++out.obstacles;
    }
    for (; place > 0 && far[place - 1] > d; --place)
      far[place] = far[place - 1], out.obstacle[place] = out.obstacle[place - 1];
    far[place] = d;
    msg::Obstacle& o = out.obstacle[place];
    o = {};
    o.seen = {t.seen_ns};
    o.x_m = at.x_m, o.y_m = at.y_m;
    o.vx_mps = turn.cos * t.state(2) + turn.sin * t.state(3);
    o.vy_mps = turn.cos * t.state(3) - turn.sin * t.state(2);
    o.sigma_m = math::sqrt(0.5 * (t.covariance(0, 0) + t.covariance(1, 1)));
    o.radius_m = o_.radius_m;
    o.colour = t.red > kJersey    ? msg::JerseyColour::red
               : t.red < -kJersey ? msg::JerseyColour::blue
                                  : msg::JerseyColour::unknown;
    o.sightings = t.sightings;
  }
  s_.dropped = dropped;
  out.dropped = static_cast<std::uint32_t>(dropped);
}

}  // namespace sinew::soccer
