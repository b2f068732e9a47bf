#include "vision/ball_finder.hpp"

#include <algorithm>

#include "math/convert.hpp"
#include "math/elementary.hpp"

namespace sinew::vision {
namespace {

constexpr StrayLimits kBallStrays{.smooth_rms_px = 0.5, .smooth_px = 1.25, .factor = 1.8, .min_points = 6};
constexpr double kMinRadius_px = 1.5;
// At the border the end of any shape may look like part of a small ball, that is of one far away: the least radius
// there, in pixels and as a share of the width of the image.
constexpr double kMinCut_px = 6, kMinCutShare = 0.0235;

}  // namespace

BallFinder::BallFinder(const BallLook& look, const SegmentationLimits& limits) : look_(look), segmentation_(limits) {
  table_.add(look.colour);
}

PointPx BallFinder::Turned::from_image(double u, double v) const {
  const math::Vec3 d = q.rotate(math::Vec3(camera.direction(u, v)));
  return {focal_px() * d.x / d.z, focal_px() * d.y / d.z};
}

bool BallFinder::Turned::in_image(const PointPx& p) const {
  const math::Vec3 d = q.conjugate().rotate({p.x, p.y, focal_px()});
  const double u = camera.cx_px + camera.fx_px * d.x / d.z, v = camera.cy_px + camera.fy_px * d.y / d.z;
  return d.z > 0 && u >= 1 && v >= 1 && u <= image.width - 2 && v <= image.height - 2;
}

/// The outer ends of the region's rows; holes (a bright spot) do not matter.
void BallFinder::collect(const Turned& view, const Blob& blob) {
  point_count_ = 0;
  const auto add = [&](double u, double v) {
    if (point_count_ < kMaxPoints) points_[point_count_++] = view.from_image(u, v);
  };
  each_row(segmentation_.runs(blob.colour), blob.region, [&](std::uint32_t y, std::uint32_t x0, std::uint32_t x1) {
    if (x0 > 0) add(x0 - 0.5, y);
    if (x1 < view.image.width) add(x1 - 0.5, y);
  });
  outline_count_ = point_count_;
}

/// For each direction from the centre: does the region have points where the outline would be in the image?
double BallFinder::coverage(const Turned& view, const Circle& c, bool& cut) const {
  constexpr std::uint32_t kMost = 16;
  const std::uint32_t sectors = c.radius < 8 ? 8 : kMost;  // rows are a pixel apart
  std::array<bool, kMost> seen{};
  for (std::size_t i = 0; i < point_count_; ++i) {
    const double turn = math::atan2(points_[i].y - c.y, points_[i].x - c.x) / (2 * math::kPi) + 1;
    seen[math::to_integer<std::uint32_t>(math::floor(turn * sectors + 0.5)) % sectors] = true;
  }
  std::uint32_t inside = 0, covered = 0;
  for (std::uint32_t k = 0; k < sectors; ++k) {
    const math::SinCos to = math::sincos(2 * math::kPi * k / sectors);
    if (!view.in_image({c.x + c.radius * to.cos, c.y + c.radius * to.sin})) continue;
    ++inside;
    covered += seen[k];
  }
  cut = inside < sectors;
  return 5 * inside < 2 * sectors ? 0 : static_cast<double>(covered) / inside;  // less of the outline says too little
}

namespace {

/// Share of the disc for which `in_image` holds, by a grid of points.
template <class InImage>
double visible_share(const Circle& c, const InImage& in_image) {
  constexpr int kHalf = 8;
  int all = 0, inside = 0;
  for (int j = -kHalf; j <= kHalf; ++j)
    for (int i = -kHalf; i <= kHalf; ++i) {
      if (i * i + j * j > kHalf * kHalf) continue;
      ++all;
      inside += in_image(PointPx{c.x + c.radius * i / kHalf, c.y + c.radius * j / kHalf});
    }
  return static_cast<double>(inside) / all;
}

}  // namespace

BallImage BallFinder::judge(const Turned& view, const Blob& blob, const Circle& c) const {
  BallImage ball;
  if (!c.valid || point_count_ < kBallStrays.min_points || c.radius < kMinRadius_px) return ball;
  bool cut = false;
  ball.coverage = coverage(view, c, cut);
  const double f = view.focal_px();
  ball.direction = math::normalized(view.q.conjugate().rotate({c.x, c.y, f}));
  if (ball.direction.z <= 0) return ball;
  ball.u_px = view.camera.cx_px + view.camera.fx_px * ball.direction.x / ball.direction.z;
  ball.v_px = view.camera.cy_px + view.camera.fy_px * ball.direction.y / ball.direction.z;
  ball.radius_px = c.radius;
  ball.rms_px = c.rms;
  ball.angular_radius_rad = math::atan(c.radius / f);
  // Away from the axis the image of a small thing has 1/cos^3 of the area.
  const double z3 = ball.direction.z * ball.direction.z * ball.direction.z;
  const double share = cut ? visible_share(c, [&](const PointPx& p) { return view.in_image(p); }) : 1;
  ball.fill = share > 0 ? blob.area_px * z3 / (math::kPi * c.radius * c.radius * share) : 0;
  const double smooth = clamp_share(1.5 - c.rms / (0.03 * c.radius + 0.4));
  const double agreeing =
      clamp_share((static_cast<double>(point_count_) / static_cast<double>(outline_count_) - 0.4) / 0.3);
  ball.confidence = smooth * agreeing * clamp_share(ball.fill) * ball.coverage * clamp_share(c.radius / 4);
  // More area than the circle has: something else of the colour hangs on it. Small discs are ragged.
  const double most = 1.15 + 1 / c.radius;
  ball.found = ball.coverage >= look_.coverage_min && ball.fill >= look_.fill_min && ball.fill <= most && smooth > 0 &&
               agreeing > 0 &&
               (!cut || (c.radius >= std::max(kMinCut_px, kMinCutShare * view.image.width) && share >= 0.4));
  return ball;
}

BallImage BallFinder::outline(const ImageView& image, const Pinhole& camera) {
  const auto blobs = segmentation_.blobs();
  BallImage best;
  for (const Blob* blob : largest<kCandidates>(blobs)) {
    if (blob == nullptr) break;
    const math::Vec3 middle(camera.direction(blob->centre_x(), blob->centre_y()));
    const Turned view{image, camera, math::Quat::between(middle, {0, 0, 1})};
    collect(view, *blob);
    const Outline outline = fit_outline({points_.data(), point_count_}, kBallStrays);
    point_count_ = outline.points;
    const BallImage ball = judge(view, *blob, outline.circle);
    if (ball.found && (!best.found || ball.radius_px > best.radius_px)) best = ball;
  }
  best.blobs = static_cast<std::uint32_t>(blobs.size());
  return best;
}

}  // namespace sinew::vision
