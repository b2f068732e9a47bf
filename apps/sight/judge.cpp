#include "apps/sight/judge.hpp"

#include <algorithm>
#include <cstdio>

#include "apps/sight/train.hpp"

namespace sinew::sight {
namespace {

using soccer::Field;
using soccer::GroundView;
using soccer::GroundXy;

constexpr double kLineFar_m = 4, kMarkFar_m = 3, kPostFar_m = 5, kRobotFar_m = 4;
constexpr int kRobotPixels = 120;  // of 320 x 240

double distance(const GroundXy& a, double x, double y) { return math::hypot(a.x_m - x, a.y_m - y); }

/// From a place in the frame "robot" to the field's.
GroundXy in_field(const Scene& s, double x, double y) {
  const math::SinCos t = math::sincos(s.robot.heading_rad);
  return {s.robot.x_m + t.cos * x - t.sin * y, s.robot.y_m + t.sin * x + t.cos * y};
}

/// Where the pixel, at which the robot believes this place is, truly shows the ground: the error of the camera's pose
/// is taken out, that of the picture stays.
std::optional<GroundXy> as_seen(const GroundView& believed, const GroundView& truly, double x, double y) {
  const soccer::PixelAt at = believed.pixel(GroundXy{x, y});
  if (!(at.depth_m > 0)) return {};
  return truly.ground(at.u_px, at.v_px);
}

double off_line(const soccer::FieldLine& l, const GroundXy& p) {
  const double dx = l.to.x_m - l.from.x_m, dy = l.to.y_m - l.from.y_m, n2 = dx * dx + dy * dy;
  const double s = std::clamp(((p.x_m - l.from.x_m) * dx + (p.y_m - l.from.y_m) * dy) / n2, 0.0, 1.0);
  return distance(p, l.from.x_m + s * dx, l.from.y_m + s * dy);
}

double pixel_m(const GroundView& v, double x, double y) {
  const double d2 = (x - v.camera_m().x) * (x - v.camera_m().x) + (y - v.camera_m().y) * (y - v.camera_m().y);
  const double h = v.height_m();
  return (d2 + h * h) / (h * v.camera().fx_px);
}

/// What the picture's label says where this place of the ground is.
int shown(const Scene& s, const GroundView& truly, const GroundXy& robot) {
  const soccer::PixelAt at = truly.pixel(robot);
  if (!(at.depth_m > 0)) return -1;
  const int x = static_cast<int>(at.u_px + 0.5), y = static_cast<int>(at.v_px + 0.5);
  if (at.u_px < 0 || at.v_px < 0 || x >= static_cast<int>(s.width) || y >= static_cast<int>(s.height)) return -1;
  return s.shown(x, y);
}

/// Whether a ring round a ball shows this, for a tenth of it.
template <class What>
bool has_beside(const Scene& s, const Scene::Ball& b, const What& what) {
  constexpr int kAround = 24;
  int count = 0;
  for (const double far : {1.15, 1.4})
    for (int k = 0; k < kAround; ++k) {
      const math::SinCos t = math::sincos(2 * math::kPi * k / kAround);
      const int x = static_cast<int>(b.u_px + (far * b.radius_px + 1) * t.cos + 0.5);
      const int y = static_cast<int>(b.v_px + (far * b.radius_px + 1) * t.sin + 0.5);
      count +=
          x >= 0 && y >= 0 && x < static_cast<int>(s.width) && y < static_cast<int>(s.height) && what(s.shown(x, y));
    }
  return count * 10 >= 2 * kAround;
}

Judgement::Ball fate_of(const Scene& s, const soccer::FieldSight& sight) {
  using Fate = Judgement::Fate;
  Judgement::Ball b;
  b.distance_m = math::hypot(s.ball->p_m.x, s.ball->p_m.y);
  b.diameter_px = 2 * s.ball->radius_px, b.visible = s.ball->visible, b.blur_px = s.blur_px;
  b.spotted = s.ball->spotted;
  b.at_line = has_beside(s, *s.ball, [](std::uint8_t w) { return w == plant::kShowsLine; });
  b.at_robot = has_beside(s, *s.ball, [](std::uint8_t w) { return w >= plant::kShowsRobot; });
  if (!sight.border().found()) return b;
  b.fate = Fate::no_candidate;
  for (const soccer::BallCandidate& c : sight.candidates().all()) {
    const Verdict v = verdict(c, s.ball);
    if (v == Verdict::not_ball) continue;
    b.fate = std::max(b.fate, v == Verdict::unclear                                   ? Fate::poor_candidate
                              : b.distance_m > soccer::SightOptions{}.ball_farthest_m ? Fate::physics
                                                                                      : Fate::doubted);
  }
  return b;
}

Judgement::Lure lure_of(const Scene& s, double u, double v) {
  using Lure = Judgement::Lure;
  const int x = std::clamp(static_cast<int>(u + 0.5), 0, static_cast<int>(s.width) - 1);
  const int y = std::clamp(static_cast<int>(v + 0.5), 0, static_cast<int>(s.height) - 1);
  const std::uint8_t what = s.shown(x, y);
  if (what == plant::kShowsRobot) return Lure::own_body;
  if (what > plant::kShowsRobot) return s.others[what - plant::kShowsRobot - 1U].upright ? Lure::upright : Lure::lying;
  switch (what) {
    case plant::kShowsCarpet:
      return Lure::carpet;
    case plant::kShowsLine:
      return Lure::line;
    case plant::kShowsGoal:
      return Lure::goal;
    case plant::kShowsBall:
      return Lure::ball;
    default:
      return Lure::beyond;
  }
}

/// What most of a thing's box shows, over its foot.
Judgement::Lure lure_of(const Scene& s, const soccer::Uprights::Thing& t) {
  std::array<int, 8> count{};
  const double high = std::max(4.0, 0.5 * (t.u1_px - t.u0_px));
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 8; ++x)
      ++count[static_cast<std::size_t>(
          lure_of(s, t.u0_px + (t.u1_px - t.u0_px) * (x + 0.5) / 8, t.foot_px - high * y / 12))];
  count[static_cast<std::size_t>(Judgement::Lure::carpet)] /= 3;  // it fills the corners of any box
  return static_cast<Judgement::Lure>(std::ranges::max_element(count) - count.begin());
}

/// A thing over this column.
Judgement::Upright fate_of(const soccer::FieldSight& sight, double u, bool post) {
  Judgement::Upright best = Judgement::Upright::nothing;
  for (const auto& t : sight.uprights().things())
    if (t.u0_px - 2 < u && u < t.u1_px + 2)
      best = std::max(best, t.is_post == post ? Judgement::Upright::elsewhere : Judgement::Upright::other_kind);
  return best;
}

void judge_balls(const Scene& s, const msg::SoccerSight& seen, const soccer::FieldSight& sight,
                 const JudgeOptions& options, Judgement& out) {
  const bool there = s.ball && s.ball->visible > 0.02;
  const bool asked = there && s.ball->visible >= options.least_visible &&
                     2 * s.ball->radius_px >= options.least_diameter_px && s.ball->u_px >= 0 &&
                     s.ball->u_px < s.width && s.ball->v_px >= 0 && s.ball->v_px < s.height;
  out.balls += asked;
  out.without_ball += !there;
  if (asked)
    out.balls_candidates += std::ranges::any_of(sight.candidates().all(),
                                                [&](const auto& c) { return verdict(c, s.ball) == Verdict::ball; });
  Judgement::Ball fate;
  if (asked) fate = fate_of(s, sight);
  bool taken = false;
  for (std::uint32_t i = 0; i < seen.balls; ++i) {
    const msg::SeenBall& b = seen.ball[i];
    const bool on = there && math::hypot(b.u_px - s.ball->u_px, b.v_px - s.ball->v_px) < 0.6 * s.ball->radius_px + 1.5;
    Judgement::Sighting g{b.confidence, on && asked && !taken, !on || taken, 0, 0, 0};
    if (on) {
      const double dx = b.at.x_m - s.ball->p_m.x, dy = b.at.y_m - s.ball->p_m.y;
      g.off_m = math::hypot(dx, dy), g.true_m = math::hypot(s.ball->p_m.x, s.ball->p_m.y);
      const double det = static_cast<double>(b.at.xx_m2) * b.at.yy_m2 - static_cast<double>(b.at.xy_m2) * b.at.xy_m2;
      g.chi2 = (dx * dx * b.at.yy_m2 - 2 * dx * dy * b.at.xy_m2 + dy * dy * b.at.xx_m2) / det;
    }
    if (asked && on && !taken) fate.fate = Judgement::Fate::seen, fate.confidence = b.confidence;
    taken = taken || on;
    if (g.is_wrong) out.mistakes.push_back({lure_of(s, b.u_px, b.v_px), b.confidence});
    out.sightings.push_back(g);
  }
  if (asked) out.asked.push_back(fate);
}

void judge_lines(const Scene& s, const Field& field, const GroundView& believed, const GroundView& truly,
                 const msg::SoccerSight& seen, const soccer::FieldSight& sight, Judgement& out) {
  for (std::uint32_t i = 0; i < seen.lines; ++i) {
    const auto a = as_seen(believed, truly, seen.line[i].from.x_m, seen.line[i].from.y_m);
    const auto b = as_seen(believed, truly, seen.line[i].to.x_m, seen.line[i].to.y_m);
    if (!a || !b) {
      out.lines_right.add(false);
      continue;
    }
    const GroundXy fa = in_field(s, a->x_m, a->y_m), fb = in_field(s, b->x_m, b->y_m);
    const double tol_a = 0.06 + 1.5 * pixel_m(truly, a->x_m, a->y_m),
                 tol_b = 0.06 + 1.5 * pixel_m(truly, b->x_m, b->y_m);
    out.lines_right.add(std::ranges::any_of(
        field.lines(), [&](const soccer::FieldLine& l) { return off_line(l, fa) < tol_a && off_line(l, fb) < tol_b; }));
  }
  // Each 10 cm of line that the picture shows: is it of a line that was seen?
  for (const soccer::FieldLine& l : field.lines()) {
    const double length = math::hypot(l.to.x_m - l.from.x_m, l.to.y_m - l.from.y_m);
    for (double t = 0.05; t < length; t += 0.1) {
      const GroundXy r = s.in_robot(l.from.x_m + t / length * (l.to.x_m - l.from.x_m),
                                    l.from.y_m + t / length * (l.to.y_m - l.from.y_m));
      if (distance(r, truly.camera_m().x, truly.camera_m().y) > kLineFar_m || shown(s, truly, r) != plant::kShowsLine)
        continue;
      const soccer::PixelAt at = truly.pixel(r);
      bool found = false;
      for (const soccer::LinePiece& p : sight.lines().lines()) {
        const double dx = p.u1_px - p.u0_px, dy = p.v1_px - p.v0_px, n2 = dx * dx + dy * dy;
        const double u = std::clamp(((at.u_px - p.u0_px) * dx + (at.v_px - p.v0_px) * dy) / n2, -0.1, 1.1);
        found = found || math::hypot(p.u0_px + u * dx - at.u_px, p.v0_px + u * dy - at.v_px) < 3.0 * s.width / 320;
      }
      out.line_length.add(found);
    }
  }
}

void judge_marks(const Scene& s, const Field& field, const GroundView& believed, const GroundView& truly,
                 const msg::SoccerSight& seen, Judgement& out) {
  struct True {
    GroundXy at;
    msg::FieldMark kind;
  };
  std::vector<True> all;
  for (const soccer::FieldCorner& c : field.corners()) all.push_back({s.in_robot(c.at.x_m, c.at.y_m), c.kind});
  for (const soccer::FieldPoint& m : field.penalty_marks())
    if (math::fabs(m.x_m) > 0.1) all.push_back({s.in_robot(m.x_m, m.y_m), msg::FieldMark::penalty_mark});
  all.push_back({s.in_robot(0, 0), msg::FieldMark::circle});
  const auto right = [&](const msg::SeenMark& m, const True& t) {
    const auto at = as_seen(believed, truly, m.at.x_m, m.at.y_m);
    const double tol = (t.kind == msg::FieldMark::circle ? 0.2 : 0.1) + 1.5 * pixel_m(truly, t.at.x_m, t.at.y_m);
    return at && m.kind == t.kind && distance(*at, t.at.x_m, t.at.y_m) < tol;
  };
  for (std::uint32_t i = 0; i < seen.marks; ++i) {
    const bool good = std::ranges::any_of(all, [&](const True& t) { return right(seen.mark[i], t); });
    out.marks_right.add(good);
    out.mark_kind_right[static_cast<std::size_t>(seen.mark[i].kind)].add(good);
  }
  for (const True& t : all) {
    if (t.kind == msg::FieldMark::circle || distance(t.at, truly.camera_m().x, truly.camera_m().y) > kMarkFar_m)
      continue;
    bool whole = shown(s, truly, t.at) == plant::kShowsLine;
    for (int k = 0; k < 8; ++k) {
      const double turn = k * math::kPi / 4;
      const int what = shown(s, truly, {t.at.x_m + 0.4 * math::cos(turn), t.at.y_m + 0.4 * math::sin(turn)});
      whole = whole && (what == plant::kShowsLine || what == plant::kShowsCarpet);
    }
    if (!whole) continue;
    bool found = false;
    for (std::uint32_t i = 0; i < seen.marks; ++i) found = found || right(seen.mark[i], t);
    out.marks_found.add(found);
  }
}

void judge_things(const Scene& s, const Field& field, const GroundView& believed, const GroundView& truly,
                  const msg::SoccerSight& seen, const soccer::FieldSight& sight, Judgement& out) {
  const auto off = [&](const msg::GroundPoint& p, const GroundXy& t) {
    const auto at = as_seen(believed, truly, p.x_m, p.y_m);
    return at ? distance(*at, t.x_m, t.y_m) : math::kInf;
  };
  std::vector<GroundXy> posts;
  for (const soccer::FieldPoint& p : field.posts()) posts.push_back(s.in_robot(p.x_m, p.y_m));
  const auto tol = [&](const GroundXy& p) { return 0.12 + 2.0 * pixel_m(truly, p.x_m, p.y_m); };
  for (std::uint32_t i = 0; i < seen.posts; ++i)
    out.posts_right.add(std::ranges::any_of(posts, [&](const GroundXy& p) { return off(seen.post[i], p) < tol(p); }));
  for (const GroundXy& p : posts) {
    if (distance(p, truly.camera_m().x, truly.camera_m().y) > kPostFar_m) continue;
    bool whole = true;  // its foot and its middle are seen
    for (const double z : {0.06, 0.3, 0.6}) {
      const soccer::PixelAt at = truly.pixel({p.x_m, p.y_m, z});
      const int x = static_cast<int>(at.u_px + 0.5), y = static_cast<int>(at.v_px + 0.5);
      whole = whole && at.depth_m > 0 && at.u_px > 12 && at.v_px > 0 && x < static_cast<int>(s.width) - 12 &&
              y < static_cast<int>(s.height) - 6 && s.shown(x, y) == plant::kShowsGoal;
    }
    if (!whole) continue;
    bool found = false;
    for (std::uint32_t i = 0; i < seen.posts; ++i) found = found || off(seen.post[i], p) < tol(p);
    out.posts_found.add(found);
    ++out.post_fates[static_cast<std::size_t>(found ? Judgement::Upright::found
                                                    : fate_of(sight, truly.pixel(p).u_px, true))];
  }
  const int pixels = kRobotPixels * static_cast<int>(s.width) / 320 * static_cast<int>(s.height) / 240;
  const auto near = [&](const msg::GroundPoint& p, const Scene::Other& o) {
    const double far = distance({o.x_m, o.y_m}, truly.camera_m().x, truly.camera_m().y);
    return off(p, {o.x_m, o.y_m}) < 0.3 + 0.1 * far;
  };
  for (std::uint32_t i = 0; i < seen.robots; ++i)
    out.robots_right.add(
        std::ranges::any_of(s.others, [&](const Scene::Other& o) { return near(seen.robot[i].at, o); }));
  for (const Scene::Other& o : s.others) {
    const soccer::PixelAt foot = truly.pixel(GroundXy{o.x_m, o.y_m});
    if (!o.upright || o.pixels < pixels ||
        distance({o.x_m, o.y_m}, truly.camera_m().x, truly.camera_m().y) > kRobotFar_m || !(foot.depth_m > 0) ||
        foot.u_px < 8 || foot.u_px > s.width - 8 || foot.v_px > s.height - 8)
      continue;
    bool found = false;
    for (std::uint32_t i = 0; i < seen.robots; ++i) {
      if (!near(seen.robot[i].at, o)) continue;
      if (!found && seen.robot[i].colour != msg::JerseyColour::unknown)
        out.jerseys_right.add((seen.robot[i].colour == msg::JerseyColour::red) == o.red);
      found = true;
    }
    out.robots_found.add(found);
    ++out.robot_fates[static_cast<std::size_t>(found ? Judgement::Upright::found : fate_of(sight, foot.u_px, false))];
  }
  for (const soccer::Uprights::Thing& t : sight.uprights().things()) {
    const bool right = t.is_post
                           ? std::ranges::any_of(
                                 posts, [&](const GroundXy& p) { return distance(p, t.feet.x_m, t.feet.y_m) < tol(p); })
                           : std::ranges::any_of(s.others, [&](const Scene::Other& o) {
                               msg::GroundPoint at;
                               at.x_m = static_cast<float>(t.feet.x_m), at.y_m = static_cast<float>(t.feet.y_m);
                               return near(at, o);
                             });
    if (!right) ++(t.is_post ? out.post_lures : out.robot_lures)[static_cast<std::size_t>(lure_of(s, t))];
  }
  for (const auto& p : sight.border().points()) {
    if (!p.measured) continue;
    const auto at = truly.ground(p.u_px, p.v_px);
    if (!at) {
      out.borders_right.add(false);
      continue;
    }
    const GroundXy f = in_field(s, at->x_m, at->y_m);
    const double to = std::min(math::fabs(5.5 - math::fabs(f.x_m)), math::fabs(4.0 - math::fabs(f.y_m)));
    out.borders_right.add(to < 0.1 + 2.5 * pixel_m(truly, at->x_m, at->y_m));
  }
}

}  // namespace

double Share::bound(double sign) const {
  if (all == 0) return sign < 0 ? 0 : 1;
  const double n = static_cast<double>(all), p = value(), z = 1.959964, z2 = z * z;
  const double middle = p + z2 / (2 * n), half = z * math::sqrt(p * (1 - p) / n + z2 / (4 * n * n));
  return std::clamp((middle + sign * half) / (1 + z2 / n), 0.0, 1.0);
}

std::string text(const Share& s) {
  char line[120];
  std::snprintf(line, sizeof line, "%.1f %% (%.1f to %.1f; %llu of %llu)", 100 * s.value(), 100 * s.low(),
                100 * s.high(), static_cast<unsigned long long>(s.of), static_cast<unsigned long long>(s.all));
  return line;
}

Judgement::AtPrecision Judgement::at_confidence(double confidence) const {
  AtPrecision out;
  out.confidence = confidence;
  for (const Sighting& s : sightings) {
    if (s.confidence < confidence || (!s.is_ball && !s.is_wrong)) continue;
    out.recall.of += s.is_ball, out.precision.add(!s.is_wrong);
  }
  out.recall.all = balls;
  return out;
}

Judgement::AtPrecision Judgement::at_precision(double precision) const {
  std::vector<Sighting> sorted = sightings;
  std::ranges::sort(sorted, [](const Sighting& a, const Sighting& b) { return a.confidence > b.confidence; });
  double least = 1.1;
  std::uint64_t right = 0, wrong = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    right += sorted[i].is_ball, wrong += sorted[i].is_wrong;
    if (i + 1 < sorted.size() && sorted[i + 1].confidence == sorted[i].confidence) continue;
    if (static_cast<double>(right) >= precision * static_cast<double>(right + wrong)) least = sorted[i].confidence;
  }
  return at_confidence(least);
}

void judge(SceneMaker& maker, std::uint64_t first, std::uint64_t count, const JudgeOptions& options, Judgement& out) {
  Scene scene;
  const Field field;
  soccer::SightOptions so;
  so.ball_confidence = 0.02;
  soccer::FieldSight sight(so);
  msg::SoccerSight seen;
  for (std::uint64_t n = first; n < first + count; ++n) {
    maker.make(n, scene);
    const GroundView believed = scene.ground(false), truly = scene.ground(true);
    if (!sight.look(scene.view(), believed, seen)) continue;
    ++out.pictures;
    if (sight.border().found()) out.candidates += sight.candidates().all().size();
    judge_balls(scene, seen, sight, options, out);
    judge_lines(scene, field, believed, truly, seen, sight, out);
    judge_marks(scene, field, believed, truly, seen, out);
    judge_things(scene, field, believed, truly, seen, sight, out);
  }
}

std::string report(const Judgement& j) {
  std::string out;
  char line[240];
  const auto add = [&](const char* what, const std::string& value) {
    std::snprintf(line, sizeof line, "| %s | %s |\n", what, value.c_str());
    out += line;
  };
  const auto p99 = j.at_precision(0.99), fixed = j.at_confidence(0.5);
  std::snprintf(
      line, sizeof line,
      "%llu pictures, %llu without a ball, %llu balls that must be found\n\n| | share (95 %% interval) |\n|---|---|\n",
      static_cast<unsigned long long>(j.pictures), static_cast<unsigned long long>(j.without_ball),
      static_cast<unsigned long long>(j.balls));
  out += line;
  add("balls found, at 99 % precision", text(p99.recall));
  std::snprintf(line, sizeof line, "| least confidence for that | %.3f |\n", p99.confidence);
  out += line;
  add("balls found, confidence 0.5 and more", text(fixed.recall));
  add("sightings that are balls, confidence 0.5 and more", text(fixed.precision));
  add("balls that are among the candidates", text({j.balls_candidates, j.balls}));
  std::vector<double> off, chi2;
  for (const auto& s : j.sightings)
    if (s.is_ball) off.push_back(s.off_m / std::max(0.3, s.true_m)), chi2.push_back(s.chi2);
  if (!off.empty()) {
    std::ranges::sort(off), std::ranges::sort(chi2);
    std::snprintf(line, sizeof line, "| error of the ball's place, of its distance: median, p95 | %.1f %%, %.1f %% |\n",
                  100 * off[off.size() / 2], 100 * off[off.size() * 95 / 100]);
    out += line;
    std::snprintf(line, sizeof line,
                  "| squared error by covariance: median, p95 (chi2 of two: 1.39, 5.99) | %.2f, %.2f |\n",
                  chi2[chi2.size() / 2], chi2[chi2.size() * 95 / 100]);
    out += line;
  }
  add("lines that are lines", text(j.lines_right));
  add("length of lines within 4 m that was seen", text(j.line_length));
  add("marks that are right", text(j.marks_right));
  const char* const kinds[] = {"L", "T", "X", "penalty mark", "circle"};
  for (std::size_t k = 0; k < 5; ++k) add(("of these: " + std::string(kinds[k])).c_str(), text(j.mark_kind_right[k]));
  add("corners and marks within 3 m found", text(j.marks_found));
  add("posts that are posts", text(j.posts_right));
  add("posts within 5 m found", text(j.posts_found));
  add("robots that are robots", text(j.robots_right));
  add("upright robots within 4 m found", text(j.robots_found));
  add("jerseys told right", text(j.jerseys_right));
  add("border points on the carpet's edge", text(j.borders_right));
  return out;
}

std::string losses(const Judgement& j) {
  using Fate = Judgement::Fate;
  const double least = j.at_precision(0.99).confidence;
  std::string out =
      "| balls that must be found | all | found | no carpet | no candidate | poor candidate | too far | doubted | "
      "below |\n|---|---|---|---|---|---|---|---|---|\n";
  char line[240];
  const auto row = [&](const char* what, const auto& is) {
    std::size_t all = 0, found = 0, below = 0, at[5] = {};
    for (const Judgement::Ball& b : j.asked) {
      if (!is(b)) continue;
      ++all;
      if (b.fate != Fate::seen)
        ++at[static_cast<std::size_t>(b.fate)];
      else
        ++(b.confidence >= least ? found : below);
    }
    std::snprintf(line, sizeof line, "| %s | %zu | %.1f %% | %zu | %zu | %zu | %zu | %zu | %zu |\n", what, all,
                  all > 0 ? 100.0 * static_cast<double>(found) / static_cast<double>(all) : 0.0, at[0], at[1], at[2],
                  at[3], at[4], below);
    out += line;
  };
  using B = const Judgement::Ball&;
  row("all", [](B) { return true; });
  row("nearer than 1 m", [](B b) { return b.distance_m < 1; });
  row("1 to 2 m", [](B b) { return b.distance_m >= 1 && b.distance_m < 2; });
  row("2 to 3 m", [](B b) { return b.distance_m >= 2 && b.distance_m < 3; });
  row("farther than 3 m", [](B b) { return b.distance_m >= 3; });
  row("8 to 12 px", [](B b) { return b.diameter_px < 12; });
  row("12 to 24 px", [](B b) { return b.diameter_px >= 12 && b.diameter_px < 24; });
  row("24 px and more", [](B b) { return b.diameter_px >= 24; });
  row("visible to 60 to 80 %", [](B b) { return b.visible < 0.8; });
  row("to 80 to 95 %", [](B b) { return b.visible >= 0.8 && b.visible < 0.95; });
  row("to more", [](B b) { return b.visible >= 0.95; });
  row("blur less than a quarter of the diameter", [](B b) { return b.blur_px < 0.25 * b.diameter_px; });
  row("more blur", [](B b) { return b.blur_px >= 0.25 * b.diameter_px; });
  row("at a line", [](B b) { return b.at_line; });
  row("at a robot", [](B b) { return b.at_robot; });
  row("in the open", [](B b) { return !b.at_line && !b.at_robot; });
  row("spotted", [](B b) { return b.spotted; });
  row("plain", [](B b) { return !b.spotted; });
  out += "\n| taken for a ball | at this confidence | at 0.5 and more |\n|---|---|---|\n";
  constexpr const char* kLures[] = {"a ball, twice", "carpet",      "line",     "goal",
                                    "robot",         "lying robot", "own body", "beyond the carpet"};
  for (std::size_t k = 0; k < std::size(kLures); ++k) {
    std::size_t sure = 0, half = 0;
    for (const Judgement::Mistake& m : j.mistakes)
      if (static_cast<std::size_t>(m.lure) == k) sure += m.confidence >= least, half += m.confidence >= 0.5;
    std::snprintf(line, sizeof line, "| %s | %zu | %zu |\n", kLures[k], sure, half);
    out += line;
  }
  out +=
      "\n| that must be found | nothing seen in their columns | at another place | of another kind | found |\n"
      "|---|---|---|---|---|\n";
  const auto fates = [&](const char* what, const std::array<std::uint64_t, 4>& n) {
    std::snprintf(line, sizeof line, "| %s | %llu | %llu | %llu | %llu |\n", what,
                  static_cast<unsigned long long>(n[0]), static_cast<unsigned long long>(n[1]),
                  static_cast<unsigned long long>(n[2]), static_cast<unsigned long long>(n[3]));
    out += line;
  };
  fates("upright robots", j.robot_fates), fates("posts", j.post_fates);
  out += "\n| on | taken for a robot there | taken for a post there |\n|---|---|---|\n";
  for (std::size_t k = 0; k < std::size(kLures); ++k) {
    std::snprintf(line, sizeof line, "| %s | %llu | %llu |\n", k == 0 ? "a ball" : kLures[k],
                  static_cast<unsigned long long>(j.robot_lures[k]), static_cast<unsigned long long>(j.post_lures[k]));
    out += line;
  }
  std::snprintf(line, sizeof line, "\n%.1f candidates in a picture\n",
                static_cast<double>(j.candidates) / static_cast<double>(std::max<std::uint64_t>(1, j.pictures)));
  return out + line;
}

}  // namespace sinew::sight
