#include "apps/locate/study.hpp"

#include <algorithm>
#include <cstdio>

namespace sinew::locate {

using soccer::FieldAt;

namespace {

constexpr double kFound_m = 0.4, kFound_rad = 0.25, kStays_s = 2, kCarried_s = 15, kWatched_s = 40;

FieldAt pose_of(const msg::FieldPose& p) { return {p.x_m, p.y_m, p.heading_rad}; }

double quantile(std::vector<double>& v, double q) {
  if (v.empty()) return math::kNan;
  std::ranges::sort(v);
  return v[std::min(v.size() - 1, static_cast<std::size_t>(q * static_cast<double>(v.size())))];
}

}  // namespace

void PoseErrors::add(const msg::FieldPose& believed, const FieldAt& truth) {
  ++poses;
  if (believed.found == 0) {
    ++lost;
    return;
  }
  const FieldAt at = pose_of(believed);
  const bool other = distance_m(at.mirrored(), truth) + turn_between_rad(at.mirrored(), truth) <
                     distance_m(at, truth) + turn_between_rad(at, truth);
  wrong_half += other;
  const FieldAt best = other ? at.mirrored() : at;
  off_m.push_back(distance_m(best, truth));
  off_rad.push_back(turn_between_rad(best, truth));
}

void PoseErrors::add(const PoseErrors& o) {
  off_m.insert(off_m.end(), o.off_m.begin(), o.off_m.end());
  off_rad.insert(off_rad.end(), o.off_rad.begin(), o.off_rad.end());
  poses += o.poses, wrong_half += o.wrong_half, lost += o.lost, beyond += o.beyond;
}

std::string text(PoseErrors e) {
  char line[240];
  const double deg = 180 / math::kPi, all = static_cast<double>(std::max<std::uint64_t>(1, e.poses));
  std::snprintf(
      line, sizeof line,
      "%llu poses: off %.3f m median, %.3f p95; %.2f degrees median, %.2f p95; wrong half %.3f %%; not found %.2f %%",
      static_cast<unsigned long long>(e.poses), quantile(e.off_m, 0.5), quantile(e.off_m, 0.95),
      quantile(e.off_rad, 0.5) * deg, quantile(e.off_rad, 0.95) * deg, 100 * static_cast<double>(e.wrong_half) / all,
      100 * static_cast<double>(e.lost) / all);
  std::string out = line;
  if (e.beyond > 0) out += "; " + std::to_string(e.beyond) + " more off the carpet";
  return out;
}

PoseErrors study_walks(const StudyOptions& o) {
  const soccer::Field field;
  PoseErrors all;
  for (std::uint64_t run = 0; run < o.runs; ++run) {
    FieldWalk walk(field, o.first_seed + run, o.errors);
    FieldAt start = walk.truth();
    if (start.x_m > 0) start = start.mirrored();
    walk.put(start);
    soccer::Locator locator(field, o.locator);
    locator.forget(true);
    PoseErrors own;
    while (walk.now_s() < o.seconds) {
      locator.see(walk.step(), true);
      msg::FieldPose pose;
      locator.fill(pose);
      if (walk.now_s() >= o.settle_s) own.add(pose, walk.truth());
    }
    all.add(own);
  }
  return all;
}

Kidnappings study_kidnappings(const StudyOptions& o, bool reentry) {
  const soccer::Field field;
  Kidnappings out;
  for (std::uint64_t run = 0; run < o.runs; ++run) {
    FieldWalk walk(field, o.first_seed + run, o.errors);
    FieldAt start = walk.truth();
    if (start.x_m > 0) start = start.mirrored();
    walk.put(start);
    soccer::Locator locator(field, o.locator);
    locator.forget(true);
    while (walk.now_s() < kCarried_s) locator.see(walk.step(), true);
    const double side = walk.random().uniform() < 0.5 ? -1 : 1;
    const FieldAt touch{walk.random().uniform(-field.size().length_m / 2, -0.4), side * field.size().width_m / 2,
                        -side * math::kPi / 2};
    walk.put(reentry ? touch : walk.anywhere());
    if (reentry) locator.reenter();
    double found = math::kInf, right = math::kInf, told_s = kCarried_s + 10;
    while (walk.now_s() < kCarried_s + kWatched_s) {
      locator.see(walk.step(), true);
      msg::FieldPose pose;
      locator.fill(pose);
      if (!reentry && walk.now_s() > told_s) {
        // A mate's ball, as soccer::Locate takes it.
        told_s += 0.5;
        const FieldAt at = pose_of(pose), other = at.mirrored();
        const soccer::FieldPoint ball{1.3, 0.4}, own = walk.truth().in(ball.x_m, ball.y_m);
        if (pose.found != 0 && math::hypot(own.x_m, own.y_m) < 5) {
          const soccer::FieldPoint a = at.out(own.x_m, own.y_m), b = other.out(own.x_m, own.y_m);
          const auto chi2 = [&](const soccer::FieldPoint& p) {
            const double dx = p.x_m - ball.x_m, dy = p.y_m - ball.y_m;
            return std::min(9.0, (dx * dx + dy * dy) / (0.5 * 0.5));
          };
          // The pose that was published is the more probable of both.
          const double for_this = std::clamp(0.5 * (chi2(b) - chi2(a)), -1.0, 1.0);
          locator.weigh_halves(locator.hypotheses()[0].mirrored > 0.5 ? -for_this : for_this);
        }
      }
      const double since = walk.now_s() - kCarried_s;
      const FieldAt at = pose_of(pose);
      const auto near = [&](const FieldAt& p) {
        return distance_m(p, walk.truth()) < kFound_m && turn_between_rad(p, walk.truth()) < kFound_rad;
      };
      const bool here = pose.found != 0 && near(at), there = pose.found != 0 && near(at.mirrored());
      if (!here && !there) found = math::kInf;
      if (!here) right = math::kInf;
      if ((here || there) && found == math::kInf) found = since;
      if (here && right == math::kInf) right = since;
      if (found < since - kStays_s && right < since - kStays_s) break;
    }
    out.found_s.push_back(found);
    out.right_half_s.push_back(right);
  }
  return out;
}

}  // namespace sinew::locate
