#include "soccer/world/locate.hpp"

#include <algorithm>

#include "math/linear.hpp"
#include "rt/zone.hpp"

namespace sinew::soccer {

using namespace std::chrono_literals;

namespace {

constexpr double kBallIsFresh_s = 1, kMostEvidence = 1;  // of one report; its errors last over several
constexpr double kMateIsSure = 0.2;                      // at most so probably a mate is in the other half itself
constexpr double kBallIsSure = 0.8;
constexpr double kFromMiddle_m = 0.8;  // a ball nearer to it is at nearly the same place in both halves
constexpr double kChangesEnds_s = 2;
constexpr double kTilt_rad = 0.02;  // lasting error of the own cameras: the ball's filter does not know it

double chi2(double dx, double dy, double xx, double xy, double yy) {
  const double det = xx * yy - xy * xy;
  return det > 0 ? (dx * dx * yy - 2 * dx * dy * xy + dy * dy * xx) / det : 0;
}

}  // namespace

void Locate::declare(rt::Declaration& d) {
  d.in("sight", sight_, {.depth = 4});
  d.in("sight2", sight2_, {.depth = 4, .optional = true});
  d.in("gait", gait_, {.max_age = 200ms});
  d.in("referee", referee_, {.max_age = 3s, .optional = true});
  d.in("ball", ball_, {.max_age = 1s, .optional = true, .previous = true});
  d.in("mates", mates_, {.depth = 8, .optional = true});
  d.out("pose", pose_);
  d.out("nav", nav_);
  LocatorOptions& o = locator_.options();
  d.param("own_half", own_half_, {.doc = "it begins in its own half"});
  d.param("way_sigma_m", o.way_sigma, {.unit = "m", .min = 0.01, .max = 1, .doc = "error of the odometry after 1 m"});
  d.param("turn_sigma_rad", o.turn_sigma, {.unit = "rad", .min = 0.005, .max = 1, .doc = "and after a turn of 1 rad"});
  d.param("sway_mps", o.sway_mps, {.unit = "m/s", .min = 0, .max = 0.5, .doc = "and after 1 s"});
  d.param("drift_radps", o.drift_radps, {.unit = "rad/s", .min = 0, .max = 0.5, .doc = "of the heading, after 1 s"});
  d.param("fall_m", o.fall_m, {.unit = "m", .min = 0, .max = 2, .doc = "after 1 s that it is not on its feet"});
  d.param("fall_rad", o.fall_rad, {.unit = "rad", .min = 0, .max = 3, .doc = "of the heading, the same"});
  d.param("sight_scale", o.sight_scale,
          {.min = 0.05, .max = 5, .doc = "share of the sightings' standard deviations that does not last"});
  d.param("tilt_rad", o.tilt_rad, {.unit = "rad", .min = 0, .max = 0.2, .doc = "lasting error of the cameras' tilt"});
  d.param("tilt_s", o.tilt_s, {.unit = "s", .min = 0.1, .max = 1000, .doc = "in which it changes"});
  d.param("camera_m", o.camera_m, {.unit = "m", .min = 0.1, .max = 3, .doc = "of the cameras over the ground"});
  d.param("gate", o.gate, {.min = 2, .max = 200, .doc = "squared error beyond which a sighting is of another thing"});
  d.param("temper", o.temper, {.min = 0.01, .max = 1, .doc = "share of a picture's evidence that is new"});
  d.param("forget_s", o.forget_s, {.unit = "s", .min = 0.2, .max = 100, .doc = "in which evidence fades"});
  d.param("memory_s", o.memory_s, {.unit = "s", .min = 0.2, .max = 30, .doc = "sightings that the search uses"});
  d.param("search_penalty", o.search_penalty,
          {.min = 0, .max = 50, .doc = "logarithm: how improbable a new place is before it is tried"});
  d.param("lead", o.lead, {.min = 0, .max = 20, .doc = "logarithm: a place that is better by this takes over"});
  d.state(locator_.state(), heard_, began_);
}

void Locate::reset() {
  locator_.forget(own_half_);
  heard_ = {};
  began_ = 0;
}

void Locate::heed_referee(rt::Time now) {
  const msg::RefereeState* said = referee_.fresh(now);
  if (!said) return;
  const bool penalised = said->penalty != msg::GamePenalty::none;
  if (heard_.penalised != 0 && !penalised) locator_.reenter();
  if (heard_.half != 0 && said->half != heard_.half) locator_.change_ends(), heard_.ends_ns = now.ns;
  heard_.penalised = penalised ? 1 : 0;
  heard_.half = said->half;
  heard_.attacks_right = said->attacks_right;
}

/// A ball that it sees and that a mate sees is in one of the two halves only.
void Locate::heed_mates() {
  const msg::BallModel* ball = ball_.get();
  const std::span<const Locator::Hypothesis> all = locator_.hypotheses();
  if (!ball || all.empty()) return;
  for (const msg::FromMate<msg::SoccerReport>& m : mates_) {
    const msg::SoccerReport& r = m.message;
    const auto is_fresh = [&](msg::Time seen) {
      return seen.ns > 0 && msg::seconds(ball->stamp - seen) < kBallIsFresh_s;
    };
    // Of the other half of the game: a mate may hear of the change a little later.
    if (heard_.ends_ns != 0 && msg::seconds(r.ball_seen - msg::Time{heard_.ends_ns}) < kChangesEnds_s) continue;
    if (r.plays == 0 || double{r.mirrored} > kMateIsSure || !(double{r.ball_confidence} > kBallIsSure) ||
        !is_fresh(r.ball_seen) || !is_fresh(ball->seen) || !(ball->confidence > kBallIsSure) ||
        math::hypot(r.ball.x_m, r.ball.y_m) < kFromMiddle_m)
      continue;
    const FieldAt& at = all[0].at;
    const math::SinCos t = math::sincos(at.heading_rad);
    const auto off = [&](const FieldAt& from) {
      const FieldPoint own = from.out(ball->x_m, ball->y_m);
      // The own covariance, turned; that of the mate; and that of where this robot is.
      const double xx = ball->covariance[0], xy = ball->covariance[1], yy = ball->covariance[5];
      const double far2 = ball->x_m * ball->x_m + ball->y_m * ball->y_m;
      const double high = locator_.options().camera_m, tilt_m = (far2 + high * high) / high * kTilt_rad;
      const double place =
          all[0].covariance(0, 0) + all[0].covariance(1, 1) + far2 * all[0].covariance(2, 2) + 0.04 + tilt_m * tilt_m;
      return chi2(own.x_m - double{r.ball.x_m}, own.y_m - double{r.ball.y_m},
                  t.cos * t.cos * xx - 2 * t.cos * t.sin * xy + t.sin * t.sin * yy + double{r.ball.xx_m2} + place,
                  t.cos * t.sin * (xx - yy) + (t.cos * t.cos - t.sin * t.sin) * xy + double{r.ball.xy_m2},
                  t.sin * t.sin * xx + 2 * t.cos * t.sin * xy + t.cos * t.cos * yy + double{r.ball.yy_m2} + place);
    };
    constexpr double kGate = 9, kFits = 4;
    const double here = std::min(off(at), kGate), there = std::min(off(at.mirrored()), kGate);
    if (std::min(here, there) > kFits) continue;  // what neither explains tells nothing
    // weigh_halves() speaks for the filter's own pose, whichever half is published.
    locator_.weigh_halves(std::clamp(0.5 * (there - here), -kMostEvidence, kMostEvidence));
  }
}

rt::StepStatus Locate::step(const rt::Step& step) noexcept {
  const msg::GaitState* gait = gait_.fresh(step.now);
  if (began_ == 0) locator_.forget(own_half_), began_ = 1;
  heed_referee(step.now);
  if (!gait || (sight_.empty() && sight2_.empty())) return rt::StepStatus::stale;
  const bool up = msg::on_its_feet(gait->mode);
  msg::Time stamp{0};
  {
    const rt::Zone zone(step, "locate");
    const auto take = [&](const rt::InQueue<msg::SoccerSight>& sights) {
      for (const msg::SoccerSight& s : sights) locator_.see(s, up), stamp = std::max(stamp, s.stamp);
    };
    take(sight_), take(sight2_);
    heed_mates();
  }
  msg::FieldPose& out = pose_.loan();
  out.stamp = {locator_.state().stamp_ns};
  locator_.fill(out);
  msg::NavState& nav = nav_.loan();
  nav.stamp = out.stamp;
  const bool turned = heard_.attacks_right == 0;
  const FieldAt own{out.x_m, out.y_m, out.heading_rad}, at = turned ? own.mirrored() : own;
  nav.p_world_m = {at.x_m, at.y_m, gait->height_m};
  nav.q_world_base = math::Quat::from_axis_angle({0, 0, 1}, at.heading_rad).to<msg::Quat>();
  nav.position_valid = nav.attitude_valid = out.found;
  nav.p_std_m = math::sqrt(0.5 * (out.covariance[0] + out.covariance[4]));
  return rt::StepStatus::ok;
}

}  // namespace sinew::soccer
