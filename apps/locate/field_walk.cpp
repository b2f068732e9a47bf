#include "apps/locate/field_walk.hpp"

#include <algorithm>

namespace sinew::locate {

using soccer::FieldAt;
using soccer::FieldPoint;
using soccer::GroundView;
using soccer::GroundXy;

namespace {

constexpr double kCameraHigh_m = 0.45, kWidth = 320, kHeight = 240, kFocal = 0.875 * kHeight;
constexpr double kSeesLines_m = 5, kSeesCorners_m = 4, kSeesPenalty_m = 3, kSeesPosts_m = 5, kPiece_m = 0.05;

}  // namespace

FieldWalk::FieldWalk(const soccer::Field& field, std::uint64_t seed, const WalkErrors& errors)
    : field_(field), e_(errors), random_(seed, 7) {
  tilt_x_ = random_.normal(0, e_.tilt_rad), tilt_y_ = random_.normal(0, e_.tilt_rad);
  scale_forward_ = random_.normal(0, e_.forward_scale), scale_side_ = random_.normal(0, e_.side_scale);
  scale_turn_ = random_.normal(0, e_.turn_scale), slip_ = random_.normal(0, e_.slip);
  gyro_ = random_.normal(0, e_.gyro_radps);
  phase_ = random_.uniform(0, 2 * math::kPi);
  at_ = anywhere();
  aim_ = {at_.x_m, at_.y_m};
}

FieldAt FieldWalk::anywhere() {
  const soccer::FieldSize& f = field_.size();
  const double x = random_.uniform(-0.48, 0.48) * f.length_m, y = random_.uniform(-0.48, 0.48) * f.width_m;
  return {x, y, random_.uniform(-math::kPi, math::kPi)};
}

void FieldWalk::walk(double dt) {
  if (math::hypot(aim_.x_m - at_.x_m, aim_.y_m - at_.y_m) < 0.2) {
    const FieldAt next = anywhere();
    aim_ = {next.x_m, next.y_m};
    speed_mps_ = random_.uniform(0, 1) < 0.2 ? 0.08 : random_.uniform(0.15, 0.3);
    aside_ = random_.uniform(0, 1) < 0.3 ? random_.uniform(-1.2, 1.2) : 0;  // it walks sideways now and then
  }
  const double way = math::atan2(aim_.y_m - at_.y_m, aim_.x_m - at_.x_m);
  const double turn = std::clamp(math::wrap_pi(way + aside_ - at_.heading_rad), -0.8 * dt, 0.8 * dt);
  const double go = math::fabs(math::wrap_pi(way + aside_ - at_.heading_rad)) < 0.6 ? speed_mps_ * dt : 0;
  const double across = math::wrap_pi(way - at_.heading_rad);
  const double ahead = go * math::cos(across), left = go * math::sin(across);
  const double jitter = 0.01 * math::sqrt(math::hypot(ahead, left)) + 1e-4;
  at_ = at_.then({ahead * (1 + scale_forward_) + random_.normal(0, jitter),
                  left * (1 + scale_side_) + slip_ * ahead + random_.normal(0, jitter),
                  turn * (1 + scale_turn_) + random_.normal(0, 0.03 * math::sqrt(dt) * 0.3)});
  odometry_ = odometry_.then({ahead, left, turn + gyro_ * dt});
  if (random_.uniform(0, 1) * e_.bump_every_s < dt)
    at_ = at_.then({random_.normal(0, 0.07), random_.normal(0, 0.07), random_.normal(0, 0.15)});
  const double kept = math::exp(-dt / 0.3), fresh = e_.tilt_sway_rad * math::sqrt(1 - kept * kept);
  sway_x_ = kept * sway_x_ + random_.normal(0, fresh);
  sway_y_ = kept * sway_y_ + random_.normal(0, fresh);
}

const msg::SoccerSight& FieldWalk::step() {
  walk(kPictureS);
  look();
  return sight_;
}

void FieldWalk::look() {
  const std::int64_t now = sight_.stamp.ns + static_cast<std::int64_t>(1e9 * kPictureS);
  camera_ = 1 - camera_;
  sight_ = {};
  sight_.stamp = {now};
  sight_.camera = camera_;
  sight_.x_m = odometry_.x_m, sight_.y_m = odometry_.y_m, sight_.heading_rad = odometry_.heading_rad;

  const double pan = 1.1 * math::sin(2 * math::kPi * now_s() / 4 + phase_), down = camera_ == 0 ? 0.35 : 0.35 + 0.7;
  const math::Quat optical{0.5, -0.5, 0.5, -0.5};
  const math::Quat q =
      math::Quat::from_axis_angle({0, 0, 1}, pan) * math::Quat::from_axis_angle({0, 1, 0}, down) * optical;
  const auto pose = [&](const math::Quat& by) {
    msg::CameraPose p;
    p.p_world_m = {0, 0, kCameraHigh_m};
    p.q_world_optical = (by * q).to<msg::Quat>();
    return p;
  };
  const vision::Pinhole camera{kFocal, kFocal, 0.5 * (kWidth - 1), 0.5 * (kHeight - 1)};
  const GroundView believed(camera, pose({}), {}, {});
  const GroundView truly(
      camera, pose(math::Quat::exp({tilt_x_ + sway_x_, tilt_y_ + sway_y_, random_.normal(0, 0.006)})), {}, {});
  // Where a place of the field is in the picture, and where the robot takes it to be.
  const auto in_picture = [&](const FieldPoint& f, double margin_px, double farthest) {
    const FieldPoint r = at_.in(f.x_m, f.y_m);
    const soccer::PixelAt p = truly.pixel(GroundXy{r.x_m, r.y_m});
    return p.depth_m > 0 && math::hypot(r.x_m, r.y_m) < farthest && p.u_px > margin_px && p.u_px < kWidth - margin_px &&
           p.v_px > margin_px && p.v_px < kHeight - margin_px;
  };
  const auto seen_at = [&](const FieldPoint& f, double sigma_px, double sigma_m) -> std::optional<msg::GroundPoint> {
    const double dx = random_.normal(0, sigma_m), dy = random_.normal(0, sigma_m);
    const double du = random_.normal(0, sigma_px), dv = random_.normal(0, sigma_px);
    const FieldPoint r = at_.in(f.x_m + dx, f.y_m + dy);
    const soccer::PixelAt p = truly.pixel(GroundXy{r.x_m, r.y_m});
    const auto g = believed.ground(p.u_px + du, p.v_px + dv);
    if (!g) return {};
    return believed.with_covariance(*g, sigma_px);
  };
  const auto chance = [&](double share) { return random_.uniform(0, 1) < share; };
  const auto somewhere = [&]() -> std::optional<msg::GroundPoint> {
    const double u = random_.uniform(0, kWidth), v = random_.uniform(0, kHeight);
    const auto g = believed.ground(u, v);
    if (!g || math::hypot(g->x_m, g->y_m) > kSeesCorners_m) return {};
    return believed.with_covariance(*g);
  };

  for (const soccer::FieldLine& l : field_.lines()) {
    const double length = math::hypot(l.to.x_m - l.from.x_m, l.to.y_m - l.from.y_m);
    const auto at = [&](double s) {
      return FieldPoint{l.from.x_m + s / length * (l.to.x_m - l.from.x_m),
                        l.from.y_m + s / length * (l.to.y_m - l.from.y_m)};
    };
    double begin = -1, best = 0, best_begin = 0;
    for (double s = 0; s <= length + kPiece_m; s += kPiece_m) {
      const bool in = s <= length && in_picture(at(s), 3, kSeesLines_m);
      if (in && begin < 0) begin = s;
      if (!in && begin >= 0) {
        if (s - begin > best) best = s - begin, best_begin = begin;
        begin = -1;
      }
    }
    if (best < 0.3 || !chance(e_.line_seen) || sight_.lines == sight_.line.size()) continue;
    const double cut = random_.uniform(0, 0.3) * best, from = best_begin + random_.uniform(0, 1) * cut;
    const auto a = seen_at(at(from), 0.8, 0.005), b = seen_at(at(std::min(length, from + best - cut)), 0.8, 0.005);
    if (a && b) sight_.line[sight_.lines++] = {*a, *b};
    if (chance(e_.false_line) && sight_.lines < sight_.line.size())
      if (const auto c = somewhere(), d = somewhere(); c && d) sight_.line[sight_.lines++] = {*c, *d};
  }
  const auto mark = [&](const std::optional<msg::GroundPoint>& p, msg::FieldMark kind, double heading) {
    if (!p || sight_.marks == sight_.mark.size()) return;
    const double sigma = 0.03 + 0.03 * math::hypot(p->x_m, p->y_m);
    msg::SeenMark& m = sight_.mark[sight_.marks++];
    m = {*p, static_cast<float>(math::canonical(math::wrap_pi(heading + random_.normal(0, sigma)))),
         math::is_nan(heading) ? math::kNanF : static_cast<float>(sigma), kind};
  };
  for (const soccer::FieldCorner& c : field_.corners())
    if (c.kind != msg::FieldMark::corner_x && in_picture(c.at, 25, kSeesCorners_m) && chance(e_.mark_seen))
      mark(seen_at(c.at, 1.2, 0.01), c.kind, c.heading_rad - at_.heading_rad);
  for (const FieldPoint& p : field_.penalty_marks())
    if (math::fabs(p.x_m) > 0.1 && in_picture(p, 15, kSeesPenalty_m) && chance(e_.penalty_seen))
      mark(seen_at(p, 1.2, 0.01), msg::FieldMark::penalty_mark, math::kNan);
  if (in_picture({0, 0}, 20, kSeesCorners_m) && chance(e_.circle_seen)) {
    const double along = math::kPi / 2 + (chance(0.5) ? math::kPi : 0) - at_.heading_rad;
    const auto at = seen_at({0, 0}, 1.2, 0.05);
    mark(at, msg::FieldMark::circle, chance(0.8) ? along : math::kNan);
  }
  if (chance(e_.false_marks)) {
    const auto at = somewhere();
    const msg::FieldMark kind = chance(0.6)   ? msg::FieldMark::circle
                                : chance(0.5) ? msg::FieldMark::corner_l
                                              : msg::FieldMark::corner_t;
    mark(at, kind, random_.uniform(-math::kPi, math::kPi));
  }
  if (chance(e_.false_penalties)) mark(somewhere(), msg::FieldMark::penalty_mark, math::kNan);
  for (const FieldPoint& p : field_.posts())
    if (in_picture(p, 10, kSeesPosts_m) && chance(e_.post_seen) && sight_.posts < sight_.post.size())
      if (const auto g = seen_at(p, 1.5, 0.03)) sight_.post[sight_.posts++] = *g;
  if (chance(e_.false_posts) && sight_.posts < sight_.post.size())
    if (const auto g = somewhere()) sight_.post[sight_.posts++] = *g;
}

}  // namespace sinew::locate
