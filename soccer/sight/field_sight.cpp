#include "soccer/sight/field_sight.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

constexpr double kFootHalf_m = 0.05;  // from a foot's front to its middle
constexpr double kSameBall = 1.3;     // radii within which two sightings are one

}  // namespace

FieldSight::FieldSight(const SightOptions& options)
    : o_(options), net_(trained_ball_weights()), picture_(options.most_width, options.most_height) {}

bool FieldSight::look(const vision::ImageView& image, const GroundView& view, msg::SoccerSight& out) {
  out.lines = out.marks = out.posts = out.balls = out.robots = out.borders = 0;
  if (!image || image.format != msg::PixelFormat::yuyv || image.width > o_.most_width ||
      image.height > o_.most_height || !view.is_upright())
    return false;
  meter_.measure(image, view, carpet_);
  colours_.set(carpet_);
  picture_.read(image, colours_);
  border_.find(picture_, view);
  if (!border_.found()) {
    lines_.find(picture_, view, {}, 0);
    return true;
  }
  line_points_.find(picture_, view, border_);
  lines_.find(picture_, view, line_points_.points(), o_.circle_radius_m);
  marks_.find(picture_, view, lines_, line_points_.points());
  uprights_.find(picture_, view, border_, carpet_);
  candidates_.find(picture_, view, border_, o_.ball_radius_m);
  put_balls(view, out);
  put_things(view, out);
  put_lines(view, out);
  return true;
}

void FieldSight::put_balls(const GroundView& view, msg::SoccerSight& out) {
  std::array<msg::SeenBall, BallCandidates::kMost> sure;
  std::size_t count = 0;
  for (const BallCandidate& c : candidates_.all()) {
    const auto at = view.at_height(c.u_px, c.v_px, o_.ball_radius_m);
    if (!at || math::hypot(at->x_m, at->y_m) > o_.ball_farthest_m) continue;
    BallPatch patch;
    take_patch(picture_, carpet_, c, patch);
    const double confidence = net_.confidence(patch);
    if (!(confidence >= o_.ball_confidence)) continue;
    msg::SeenBall ball;
    ball.at = view.with_covariance(*at, view.errors().pixel_px + 0.1 * c.radius_px, o_.ball_radius_m);
    ball.u_px = static_cast<float>(c.u_px), ball.v_px = static_cast<float>(c.v_px);
    ball.radius_px = static_cast<float>(c.radius_px);
    ball.confidence = static_cast<float>(confidence);
    // The surest first.
    std::size_t place = count++;
    for (; place > 0 && sure[place - 1].confidence < ball.confidence; --place) sure[place] = sure[place - 1];
    sure[place] = ball;
  }
  for (std::size_t i = 0; i < count && out.balls < out.ball.size(); ++i) {
    bool same = false;
    for (std::uint32_t k = 0; k < out.balls; ++k) {
      const double du = sure[i].u_px - out.ball[k].u_px, dv = sure[i].v_px - out.ball[k].v_px;
      const double r = kSameBall * std::max(sure[i].radius_px, out.ball[k].radius_px);
      same = same || du * du + dv * dv < r * r;
    }
    if (!same) out.ball[out.balls++] = sure[i];
  }
}

void FieldSight::put_things(const GroundView& view, msg::SoccerSight& out) const {
  for (const Uprights::Thing& t : uprights_.things()) {
    if (t.is_post) {
      if (out.posts < out.post.size()) out.post[out.posts++] = view.with_covariance(t.feet);
      continue;
    }
    // A ball before the carpet's edge comes down over it, too.
    bool ball = false;
    for (std::uint32_t i = 0; i < out.balls; ++i) {
      const msg::SeenBall& b = out.ball[i];
      ball = ball || (t.u0_px > b.u_px - 1.3 * b.radius_px && t.u1_px < b.u_px + 1.3 * b.radius_px &&
                      math::fabs(t.foot_px - b.v_px) < 1.6 * b.radius_px);
    }
    if (ball || out.robots == out.robot.size()) continue;
    msg::SeenRobot& r = out.robot[out.robots++];
    const double x = t.feet.x_m - view.camera_m().x, y = t.feet.y_m - view.camera_m().y, d = math::hypot(x, y);
    const double on = d > 1e-6 ? kFootHalf_m / d : 0;
    r.at = view.with_covariance({t.feet.x_m + on * x, t.feet.y_m + on * y}, 2 * view.errors().pixel_px);
    r.confidence = static_cast<float>(t.confidence);
    r.colour = std::max(t.blue, t.red) < 0.04 ? msg::JerseyColour::unknown
               : t.blue > t.red               ? msg::JerseyColour::blue
                                              : msg::JerseyColour::red;
  }
}

void FieldSight::put_lines(const GroundView& view, msg::SoccerSight& out) const {
  for (const LinePiece& l : lines_.lines()) {
    if (out.lines == out.line.size()) break;
    out.line[out.lines++] = {view.with_covariance(l.from), view.with_covariance(l.to)};
  }
  for (const msg::SeenMark& m : marks_.marks()) {
    // A ball is white with carpet all round it, too.
    bool ball = false;
    for (std::uint32_t i = 0; i < out.balls && m.kind == msg::FieldMark::penalty_mark; ++i)
      ball = ball || math::hypot(out.ball[i].at.x_m - m.at.x_m, out.ball[i].at.y_m - m.at.y_m) < 0.3;
    if (!ball && out.marks < out.mark.size()) out.mark[out.marks++] = m;
  }
  // Eight places spread over those that were measured.
  const auto& points = border_.points();
  const double first = 0, last = static_cast<double>(points.size() - 1);
  for (std::size_t k = 0; k < out.border.size(); ++k) {
    const double at = first + (last - first) * static_cast<double>(k) / static_cast<double>(out.border.size() - 1);
    const FieldBorder::Point& p = points[static_cast<std::size_t>(at + 0.5)];
    if (!p.measured) continue;
    if (const auto ground = view.ground(p.u_px, p.v_px)) out.border[out.borders++] = view.with_covariance(*ground);
  }
}

}  // namespace sinew::soccer
