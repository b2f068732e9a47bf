#include "soccer/world/locator.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

using Vec5 = math::Mat<1, 5>;

// Shares of sightings that are of nothing on the field: docs/soccer-vision.md.
constexpr double kWrongLine = 0.08, kWrongCorner = 0.05, kWrongCircle = 0.08, kWrongMark = 0.35, kWrongPost = 0.5;
constexpr double kLineFloor_m = 0.02, kCornerFloor_m = 0.03, kCircleFloor_m = 0.08, kPostFloor_m = 0.08;
constexpr double kLineTurn_rad = 0.5;  // beyond it a line is not that line
constexpr double kSticksOut_m = 0.25;  // standard deviation of how far pieces stick out over a line's ends
constexpr double kAmbiguous = 3;       // two lines that fit nearly the same tell nothing of where it is
constexpr double kFitShare = 0.03;     // of each sighting in the running share that agrees
constexpr double kSearchEvery = 5;     // pictures
constexpr double kStartPlace_m = 0.3, kStartHeading_rad = 0.15;
constexpr double kSame_m = 0.2, kSame_rad = 0.12;  // places that are one; two filters of one place come nearer
constexpr double kKnown_m = 0.3, kKnown_rad = 0.16;
constexpr double kBump_m = 0.05, kBump_rad = 0.05;     // of each picture most of which does not agree
constexpr double kProvenUsed = 80, kProvenFit = 0.75;  // before a place is the one that later ones are compared with
constexpr double kLeastWeight = -14, kOffCarpet_m = 1.3;
constexpr double kFound_m = 0.35, kFoundFit = 0.55, kFoundShare = 0.75, kFoundUsed = 20;
constexpr double kTriedUsed = 8;  // sightings, before a place may lead or raise a doubt about the leader
constexpr double kSlip_m = 0.8, kSlip_rad = 0.4;  // how far a place may have been off that is replaced by another
constexpr double kHalf_m = 0.12;                  // how well x is known when it is first found
constexpr double kCarried = 0.1;                  // probability that somebody carried the robot when its place jumps
constexpr double kSurely = 0.01;                  // probability that a rule is wrong

double quadratic(const msg::GroundPoint& p, double nx, double ny) {
  return nx * nx * p.xx_m2 + 2 * nx * ny * p.xy_m2 + ny * ny * p.yy_m2;
}

/// Kalman's update by one number: `row` times the state's error is `error`, known to `variance`.
void update(Locator::Hypothesis& h, const Vec5& row, double error, double variance) {
  math::Mat<5, 1> pj = h.covariance * row.transpose();
  const double s = (row * pj).a[0] + variance;
  const double gain = 1 / s;
  h.covariance -= (pj * pj.transpose()) * gain;
  h.covariance = h.covariance.symmetric();
  pj *= gain * error;
  h.at.x_m += pj(0), h.at.y_m += pj(1);
  h.at.heading_rad = math::wrap_pi(h.at.heading_rad + pj(2));
  h.tilt_x_rad += pj(3), h.tilt_y_rad += pj(4);
}

}  // namespace

/// How a place that was seen moves across `n` of the field when the state moves.
struct Locator::Step {
  FieldPoint at;  // on the field, with the tilts taken out
  double cos, sin, x, y;
  double camera_m;

  Step(const Hypothesis& h, const msg::GroundPoint& seen, double camera) : camera_m(camera) {
    const math::SinCos t = math::sincos(h.at.heading_rad);
    cos = t.cos, sin = t.sin;
    // Source: derivation: a ray to (x, y, -h) is turned by (tilt_x, tilt_y, 0) and cut with the ground again.
    const double sx = seen.x_m, sy = seen.y_m;
    x = sx + sx * sy / camera_m * h.tilt_x_rad - (camera_m + sx * sx / camera_m) * h.tilt_y_rad;
    y = sy + (camera_m + sy * sy / camera_m) * h.tilt_x_rad - sx * sy / camera_m * h.tilt_y_rad;
    at = {h.at.x_m + cos * x - sin * y, h.at.y_m + sin * x + cos * y};
  }
  Vec5 row(double nx, double ny) const {
    const double rx = cos * nx + sin * ny, ry = cos * ny - sin * nx;  // n in the robot's frame
    return {nx, ny, nx * (-sin * x - cos * y) + ny * (cos * x - sin * y),
            rx * x * y / camera_m + ry * (camera_m + y * y / camera_m),
            -rx * (camera_m + x * x / camera_m) - ry * x * y / camera_m};
  }
  /// n in the robot's frame.
  FieldPoint in_robot(double nx, double ny) const { return {cos * nx + sin * ny, cos * ny - sin * nx}; }
};

void Locator::forget(bool own_half) {
  s_ = {};
  s_.own_half = own_half ? 1 : 0;
}

void Locator::reenter() {
  s_.count = 0;
  s_.own_half = 1;
  s_.begin = s_.odometry;
  s_.anchor_m2 = 0, s_.anchor_rad2 = 0;
  s_.memory.forget();
  const FieldSize& f = field_.size();
  constexpr int kPlaces = kMost / 2;
  for (const double side : {-1.0, 1.0})
    for (int i = 0; i < kPlaces; ++i) {
      Hypothesis& h = s_.hypothesis[s_.count++];
      h = {};
      h.at = {-f.length_m / 2 * (i + 0.5) / kPlaces, side * f.width_m / 2, -side * math::kPi / 2};
      const double along = f.length_m / 4 / kPlaces;
      const double tilt = options_.tilt_rad * options_.tilt_rad;
      h.covariance = math::Mat<5, 5>::diagonal({along * along, 0.3 * 0.3, 0.3 * 0.3, tilt, tilt});
      h.mirrored = kSurely;
    }
}

void Locator::change_ends() {
  for (std::uint32_t i = 0; i < s_.count; ++i) s_.hypothesis[i].mirrored = 1 - s_.hypothesis[i].mirrored;
  s_.anchor_mirrored = 1 - s_.anchor_mirrored;
  s_.own_half = 0;  // the rule was of the other half
}

void Locator::move_to(const FieldAt& odometry, double dt_s, bool on_its_feet) {
  const FieldAt step = s_.odometry.way_to(odometry);
  const LocatorOptions& o = options_;
  const double way = math::hypot(step.x_m, step.y_m), turn = math::fabs(step.heading_rad);
  const double fall = on_its_feet ? 0 : 1;
  const double place = o.way_sigma * o.way_sigma * way + (o.sway_mps * o.sway_mps + fall * o.fall_m * o.fall_m) * dt_s;
  const double heading =
      o.turn_sigma * o.turn_sigma * turn + (o.drift_radps * o.drift_radps + fall * o.fall_rad * o.fall_rad) * dt_s;
  const double kept = math::exp(-dt_s / o.tilt_s);
  for (std::size_t i = 0; i < s_.count; ++i) {
    Hypothesis& h = s_.hypothesis[i];
    const math::SinCos t = math::sincos(h.at.heading_rad);
    math::Mat<5, 5> f = math::Mat<5, 5>::identity();
    f(0, 2) = -t.sin * step.x_m - t.cos * step.y_m;
    f(1, 2) = t.cos * step.x_m - t.sin * step.y_m;
    f(3, 3) = f(4, 4) = kept;
    h.at = h.at.then(step);
    h.tilt_x_rad *= kept, h.tilt_y_rad *= kept;
    h.covariance = (f * h.covariance * f.transpose()).symmetric();
    const double tilt = o.tilt_rad * o.tilt_rad * (1 - kept * kept);
    h.covariance(0, 0) += place, h.covariance(1, 1) += place, h.covariance(2, 2) += heading;
    h.covariance(3, 3) += tilt, h.covariance(4, 4) += tilt;
    h.log_weight *= math::exp(-dt_s / o.forget_s);
  }
  s_.odometry = odometry;
  s_.anchor = s_.anchor.then(step);
  if (s_.anchor_m2 > 0) s_.anchor_m2 += place, s_.anchor_rad2 += heading;
}

bool Locator::use_line(Hypothesis& h, const msg::SeenLine& line, double& log_likelihood) {
  const LocatorOptions& o = options_;
  const Step a(h, line.from, o.camera_m), b(h, line.to, o.camera_m);
  const double dx = b.at.x_m - a.at.x_m, dy = b.at.y_m - a.at.y_m, length = math::hypot(dx, dy);
  if (!(length > 0.15)) return true;
  const bool by_x = math::fabs(dx) > math::fabs(dy);  // it runs along the field's x
  if (std::min(math::fabs(dx), math::fabs(dy)) > math::sin(kLineTurn_rad) * length) {
    log_likelihood += math::log(kWrongLine);
    return false;
  }
  const double nx = by_x ? 0 : 1, ny = by_x ? 1 : 0;
  const FieldPoint n = a.in_robot(nx, ny);
  const double scale = o.sight_scale * o.sight_scale, floor = kLineFloor_m * kLineFloor_m;
  const double ra = scale * quadratic(line.from, n.x_m, n.y_m) + floor,
               rb = scale * quadratic(line.to, n.x_m, n.y_m) + floor;
  const Vec5 row_a = a.row(nx, ny), row_b = b.row(nx, ny);
  const double sa = (row_a * h.covariance * row_a.transpose()).a[0] + ra;
  const double sb = (row_b * h.covariance * row_b.transpose()).a[0] + rb;
  const double low = by_x ? std::min(a.at.x_m, b.at.x_m) : std::min(a.at.y_m, b.at.y_m),
               high = low + (by_x ? math::fabs(dx) : math::fabs(dy));
  double best = math::kInf, second = math::kInf, best_at = 0;
  for (const FieldLine& l : field_.lines()) {
    if ((l.from.y_m == l.to.y_m) != by_x) continue;
    const double at = by_x ? l.from.y_m : l.from.x_m;
    const double from = by_x ? std::min(l.from.x_m, l.to.x_m) : std::min(l.from.y_m, l.to.y_m);
    const double to = by_x ? std::max(l.from.x_m, l.to.x_m) : std::max(l.from.y_m, l.to.y_m);
    const double ea = at - (by_x ? a.at.y_m : a.at.x_m), eb = at - (by_x ? b.at.y_m : b.at.x_m);
    const double out = std::max({0.0, from - low, high - to}) / kSticksOut_m;
    const double cost = ea * ea / sa + eb * eb / sb + out * out;
    if (cost < best)
      second = best, best = cost, best_at = at;
    else if (cost < second)
      second = cost;
  }
  log_likelihood += math::log((1 - kWrongLine) * math::exp(-0.5 * std::min(best, 60.0)) + kWrongLine);
  if (best > o.gate) return false;
  if (second < best + kAmbiguous) return true;
  update(h, row_a, best_at - (by_x ? a.at.y_m : a.at.x_m), ra);
  const Step again(h, line.to, o.camera_m);
  update(h, again.row(nx, ny), best_at - (by_x ? again.at.y_m : again.at.x_m), rb);
  return true;
}

/// `alike_rad`: headings are the same after turns by this.
bool Locator::use_place(Hypothesis& h, const msg::GroundPoint& seen, std::span<const FieldCorner> places,
                        double heading_rad, double heading_sigma_rad, double alike_rad, double floor_m, double wrong,
                        double& log_likelihood) {
  const LocatorOptions& o = options_;
  const Step step(h, seen, o.camera_m);
  // Along the line of sight and across it the errors are independent.
  const double far = math::hypot(step.x, step.y);
  if (!(far > 0.05)) return true;
  const double ux = (step.cos * step.x - step.sin * step.y) / far, uy = (step.sin * step.x + step.cos * step.y) / far;
  const double scale = o.sight_scale * o.sight_scale;
  const FieldPoint along = step.in_robot(ux, uy), across = step.in_robot(-uy, ux);
  const double r_along = scale * quadratic(seen, along.x_m, along.y_m) + floor_m * floor_m;
  const double r_across = scale * quadratic(seen, across.x_m, across.y_m) + floor_m * floor_m;
  const Vec5 row_along = step.row(ux, uy), row_across = step.row(-uy, ux);
  const double s_along = (row_along * h.covariance * row_along.transpose()).a[0] + r_along;
  const double s_across = (row_across * h.covariance * row_across.transpose()).a[0] + r_across;
  const bool turned = !math::is_nan(heading_rad);
  const double r_heading = turned ? heading_sigma_rad * heading_sigma_rad + 0.04 * 0.04 : 1;
  double best = math::kInf, e_along = 0, e_across = 0, e_heading = 0;
  for (const FieldCorner& c : places) {
    const double dx = c.at.x_m - step.at.x_m, dy = c.at.y_m - step.at.y_m;
    const double along_m = ux * dx + uy * dy, across_m = ux * dy - uy * dx;
    double turn = 0;
    if (turned) {
      turn = math::wrap_pi(c.heading_rad - h.at.heading_rad - heading_rad);
      turn -= alike_rad * math::round(turn / alike_rad);
    }
    const double cost =
        along_m * along_m / s_along + across_m * across_m / s_across + turn * turn / (r_heading + h.covariance(2, 2));
    if (cost < best) best = cost, e_along = along_m, e_across = across_m, e_heading = turn;
  }
  log_likelihood += math::log((1 - wrong) * math::exp(-0.5 * std::min(best, 60.0)) + wrong);
  if (best > o.gate) return false;
  update(h, row_along, e_along, r_along);
  const Step again(h, seen, o.camera_m);
  const double left = e_across - (again.at.y_m - step.at.y_m) * ux + (again.at.x_m - step.at.x_m) * uy;
  update(h, again.row(-uy, ux), left, r_across);
  if (turned) update(h, {0, 0, 1, 0, 0}, e_heading, r_heading);
  return true;
}

/// The logarithm of how probable the picture is from here.
double Locator::use(Hypothesis& h, const msg::SoccerSight& sight) {
  double log_likelihood = 0;
  int agree = 0, all = 0;
  const auto agreed = [&](bool yes) {
    agree += yes, ++all;
    h.fit += kFitShare * ((yes ? 1 : 0) - h.fit);
    h.used += 1;
  };
  std::array<FieldCorner, 24> places;
  for (std::uint32_t i = 0; i < std::min<std::size_t>(sight.marks, sight.mark.size()); ++i) {
    const msg::SeenMark& m = sight.mark[i];
    std::size_t count = 0;
    const bool corner = m.kind != msg::FieldMark::circle && m.kind != msg::FieldMark::penalty_mark;
    if (corner)
      for (const FieldCorner& c : field_.corners())
        if (c.kind == m.kind) places[count++] = c;
    if (m.kind == msg::FieldMark::circle) places[count++] = {{0, 0}, math::kPi / 2, m.kind};
    if (m.kind == msg::FieldMark::penalty_mark)
      for (const FieldPoint& p : field_.penalty_marks()) places[count++] = {p, 0, m.kind};
    const bool circle = m.kind == msg::FieldMark::circle;
    const double alike = circle ? math::kPi : m.kind == msg::FieldMark::corner_x ? math::kPi / 2 : 2 * math::kPi;
    const double wrong = corner ? kWrongCorner : circle ? kWrongCircle : kWrongMark;
    const bool yes = use_place(h, m.at, {places.data(), count}, double{m.heading_rad}, double{m.heading_sigma_rad},
                               alike, circle ? kCircleFloor_m : kCornerFloor_m, wrong, log_likelihood);
    if (m.kind != msg::FieldMark::penalty_mark) agreed(yes);
  }
  for (std::uint32_t i = 0; i < std::min<std::size_t>(sight.lines, sight.line.size()); ++i)
    agreed(use_line(h, sight.line[i], log_likelihood));
  std::size_t posts = 0;
  for (const FieldPoint& p : field_.posts()) places[posts++] = {p, 0, msg::FieldMark::corner_x};
  for (std::uint32_t i = 0; i < std::min<std::size_t>(sight.posts, sight.post.size()); ++i)
    use_place(h, sight.post[i], {places.data(), posts}, math::kNan, 0, 1, kPostFloor_m, kWrongPost, log_likelihood);
  // Somebody ran into it, say: its odometry knows nothing of that.
  if (all >= 2 && 2 * agree < all) {
    h.covariance(0, 0) += kBump_m * kBump_m, h.covariance(1, 1) += kBump_m * kBump_m;
    h.covariance(2, 2) += kBump_rad * kBump_rad;
  }
  return log_likelihood;
}

/// It began in its own half. At the middle line that says nothing.
double Locator::mirrored_by_rule(const FieldAt& at) const {
  const double x_m = at.then(s_.odometry.way_to(s_.begin)).x_m;
  const double doubt = std::max(kSurely, 0.5 * math::exp(-0.5 * x_m * x_m / (kHalf_m * kHalf_m)));
  return x_m < 0 ? doubt : 1 - doubt;
}

/// Of a new place. Until the first is found a rule says the half; then the last place that it was sure of, if the new
/// one is near that or near its mirror image. Slips are near; where somebody carries the robot to is anywhere.
double Locator::mirrored_of(const FieldAt& at) const {
  if (s_.own_half != 0) return mirrored_by_rule(at);
  if (!(s_.anchor_m2 > 0)) return 0.5;
  const double area = (field_.size().length_m + 2) * (field_.size().width_m + 2);
  const double spread = kSlip_m * kSlip_m + s_.anchor_m2, turn = kSlip_rad * kSlip_rad + s_.anchor_rad2;
  const double share = (1 - kCarried) / (2 * math::kPi * spread * math::sqrt(2 * math::kPi * turn));
  const double anywhere = 0.5 * kCarried / (area * 2 * math::kPi);
  const auto by_slip = [&](const FieldAt& p) {
    const double d = distance_m(p, s_.anchor), t = turn_between_rad(p, s_.anchor);
    return share * math::exp(-0.5 * (d * d / spread + t * t / turn));
  };
  const double near = by_slip(at), far = by_slip(at.mirrored());
  const double here = anywhere + (1 - s_.anchor_mirrored) * near + s_.anchor_mirrored * far;
  const double there = anywhere + (1 - s_.anchor_mirrored) * far + s_.anchor_mirrored * near;
  return there / (here + there);
}

void Locator::insert(const FieldAt& at, double log_weight) {
  Hypothesis n;
  n.at = at;
  n.mirrored = mirrored_of(at);
  if (n.mirrored > 0.5) n.at = at.mirrored(), n.mirrored = 1 - n.mirrored;
  const double place = kStartPlace_m * kStartPlace_m, heading = kStartHeading_rad * kStartHeading_rad;
  const double tilt = options_.tilt_rad * options_.tilt_rad;
  n.covariance = math::Mat<5, 5>::diagonal({place, place, heading, tilt, tilt});
  n.log_weight = log_weight;
  if (s_.count < kMost) {
    s_.hypothesis[s_.count++] = n;
    return;
  }
  std::size_t worst = 1;
  for (std::size_t i = 2; i < s_.count; ++i)
    if (s_.hypothesis[i].log_weight < s_.hypothesis[worst].log_weight) worst = i;
  if (s_.hypothesis[worst].log_weight < log_weight) s_.hypothesis[worst] = n;
}

void Locator::look_elsewhere() {
  if (!search_.choose(s_.memory.all(), s_.odometry)) return;
  math::Random random(1, 0, s_.pictures);
  const auto found = search_.search(random);
  if (found.empty()) return;
  const auto known = [&](const FieldAt& at) {
    return std::ranges::any_of(hypotheses(), [&](const Hypothesis& h) {
      const FieldAt m = at.mirrored();
      return (distance_m(at, h.at) < kKnown_m && turn_between_rad(at, h.at) < kKnown_rad) ||
             (distance_m(m, h.at) < kKnown_m && turn_between_rad(m, h.at) < kKnown_rad);
    });
  };
  if (s_.count == 0) {
    for (const PoseSearch::Found& f : found) insert(f.at, -0.5 * (f.cost - found[0].cost));
    return;
  }
  std::array<FieldAt, 1> lead{s_.hypothesis[0].at};
  std::array<double, 1> lead_cost{};
  search_.cost_of(lead, lead_cost);
  const double leader = s_.hypothesis[0].log_weight;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, found.size()); ++i) {
    const double gain = 0.5 * (lead_cost[0] - found[i].cost) - options_.search_penalty;
    if (gain < kLeastWeight / 2 || known(found[i].at)) continue;
    insert(found[i].at, leader + std::min(gain, -0.5));
  }
}

void Locator::tidy() {
  // Drops doubles, the improbable, and what walked off the carpet; then the leader first, the best weight 0.
  double best = -math::kInf;
  for (const Hypothesis& h : hypotheses()) best = std::max(best, h.log_weight);
  std::size_t kept = 0;
  const std::size_t before = s_.count;
  for (std::size_t i = 0; i < before; ++i) {
    Hypothesis h = s_.hypothesis[i];
    h.log_weight -= best;
    if (h.log_weight < kLeastWeight || !field_.holds({h.at.x_m, h.at.y_m}, kOffCarpet_m)) {
      s_.relocations += i == 0;
      continue;
    }
    bool doubled = false;
    for (std::size_t k = 0; k < kept && !doubled; ++k) {
      Hypothesis& o = s_.hypothesis[k];
      const FieldAt m = h.at.mirrored();
      const bool here = distance_m(h.at, o.at) < kSame_m && turn_between_rad(h.at, o.at) < kSame_rad;
      const bool there = distance_m(m, o.at) < kSame_m && turn_between_rad(m, o.at) < kSame_rad;
      if (!here && !there) continue;
      doubled = true;
      if (k > 0 && h.log_weight > o.log_weight) o = h;  // the leader stays
    }
    if (!doubled) s_.hypothesis[kept++] = h;
  }
  s_.count = static_cast<std::uint32_t>(kept);
  for (std::size_t i = 1; i < s_.count; ++i) {
    const Hypothesis& h = s_.hypothesis[i];
    if (h.used < kTriedUsed || h.log_weight < s_.hypothesis[0].log_weight + options_.lead) continue;
    std::swap(s_.hypothesis[0], s_.hypothesis[i]);
    ++s_.relocations;
  }
}

void Locator::see(const msg::SoccerSight& sight, bool on_its_feet) {
  const FieldAt odometry{sight.x_m, sight.y_m, sight.heading_rad};
  const double dt =
      s_.stamp_ns == 0 ? 0 : std::clamp(1e-9 * static_cast<double>(sight.stamp.ns - s_.stamp_ns), 0.0, 5.0);
  if (s_.stamp_ns == 0) s_.odometry = s_.begin = odometry;
  move_to(odometry, dt, on_its_feet);
  s_.stamp_ns = std::max(s_.stamp_ns, sight.stamp.ns);
  if (!on_its_feet) return;  // a lying robot's camera is elsewhere than its pose says
  s_.memory.see(sight, options_.memory_s);
  for (std::size_t i = 0; i < s_.count; ++i)
    s_.hypothesis[i].log_weight += options_.temper * use(s_.hypothesis[i], sight);
  if (s_.pictures++ % static_cast<std::uint32_t>(kSearchEvery) == 0) look_elsewhere();
  tidy();
  if (!is_sure()) return;
  Hypothesis& lead = s_.hypothesis[0];
  if (lead.used < kProvenUsed || lead.fit < kProvenFit) return;
  if (s_.own_half != 0) lead.mirrored = mirrored_by_rule(lead.at);
  s_.own_half = 0;
  s_.anchor = lead.at, s_.anchor_mirrored = lead.mirrored;
  s_.anchor_m2 = 0.5 * (lead.covariance(0, 0) + lead.covariance(1, 1)), s_.anchor_rad2 = lead.covariance(2, 2);
}

void Locator::weigh_halves(double log_factor) {
  for (std::size_t i = 0; i < s_.count; ++i) {
    Hypothesis& h = s_.hypothesis[i];
    const double p = std::clamp(h.mirrored, 1e-6, 1 - 1e-6);
    h.mirrored = 1 / (1 + (1 - p) / p * math::exp(std::clamp(log_factor, -20.0, 20.0)));
    h.mirrored = std::clamp(h.mirrored, 1e-4, 1 - 1e-4);
  }
}

void Locator::fill(msg::FieldPose& out) const {
  out.relocations = static_cast<std::uint32_t>(s_.relocations);
  out.found = 0;
  out.mirrored = 0.5;
  if (s_.count == 0) {
    out.covariance = {9, 0, 0, 0, 9, 0, 0, 0, 9};
    return;
  }
  const Hypothesis& h = s_.hypothesis[0];
  const bool other = h.mirrored > 0.5;
  const FieldAt at = other ? h.at.mirrored() : h.at;
  out.x_m = at.x_m, out.y_m = at.y_m, out.heading_rad = at.heading_rad;
  out.mirrored = other ? 1 - h.mirrored : h.mirrored;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out.covariance[static_cast<std::size_t>(3 * r + c)] = h.covariance(r, c);
  out.found = is_sure() ? 1 : 0;
}

bool Locator::is_sure() const {
  if (s_.count == 0) return false;
  const Hypothesis& h = s_.hypothesis[0];
  double all = 0;
  for (const Hypothesis& o : hypotheses())
    if (o.used >= kTriedUsed) all += math::exp(o.log_weight);
  return h.covariance(0, 0) < kFound_m * kFound_m && h.covariance(1, 1) < kFound_m * kFound_m && h.fit > kFoundFit &&
         math::exp(h.log_weight) > kFoundShare * all && h.used >= kFoundUsed;
}

}  // namespace sinew::soccer
