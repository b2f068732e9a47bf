#include "vision/pad_finder.hpp"

#include "math/convert.hpp"
#include "math/elementary.hpp"

namespace sinew::vision {
namespace {

/// Brightness where no great precision is needed: Y, or the green of a colour triple.
int brightness(const ImageView& image, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* row = image.row(y);
  return image.format == msg::PixelFormat::yuyv ? row[2 * x] : row[3 * x + 1];
}

// So far from the edge that neither blur nor a shared chroma sample reaches it.
constexpr std::uint32_t kProbePx = 3;
constexpr StrayLimits kPadStrays{.smooth_rms_px = 0.6, .smooth_px = 1.5, .factor = 2.5, .min_points = 8};

}  // namespace

PadFinder::PadFinder(const PadLook& look, const SegmentationLimits& limits) : look_(look), segmentation_(limits) {
  table_.add(look.colour);
}

void PadFinder::collect_edges(const ImageView& image, const Blob& blob) {
  edge_count_ = 0;
  const auto add = [&](std::uint32_t x, std::uint32_t y, bool left) {  // x: the first pixel that is not the region's
    if (edge_count_ == kMaxEdges) return;
    const std::uint32_t in = left ? x + kProbePx : x - kProbePx;
    const bool room = left ? x + 1 >= kProbePx : x + kProbePx <= image.width;
    const std::uint32_t out = !room ? x : left ? x + 1 - kProbePx : x - 1 + kProbePx;
    const double border = left ? x + 0.5 : x - 0.5;
    edges_[edge_count_++] = {{border, double(y)}, left, brightness(image, out, y) > brightness(image, in, y)};
  };
  each_row(segmentation_.runs(blob.colour), blob.region, [&](std::uint32_t y, std::uint32_t x0, std::uint32_t x1) {
    if (x1 - x0 < 2 * kProbePx) return;  // too short to tell inside from outside
    if (x0 > 0) add(x0 - 1, y, true);
    if (x1 < image.width) add(x1, y, false);
  });
}

Circle PadFinder::fit(bool bright) {
  point_count_ = 0;
  for (std::size_t i = 0; i < edge_count_; ++i)
    if (edges_[i].bright == bright) points_[point_count_++] = edges_[i].at;
  const Outline outline = fit_outline({points_.data(), point_count_}, kPadStrays);
  point_count_ = outline.points;
  return outline.circle;
}

/// The share of the circle's visible part that has the pad's colour.
double PadFinder::fill(const ImageView& image, const Circle& c) const {
  const double top = math::floor(c.y - c.radius), bottom = math::ceil(c.y + c.radius);
  if (bottom < 0 || top > image.height) return 0;
  const auto runs = segmentation_.runs(1);
  double visible = 0, coloured = 0;
  std::size_t i = 0;
  for (auto y = math::to_integer<std::uint32_t>(top); y < image.height && y <= bottom; ++y) {
    const double dy = y - c.y, half = math::sqrt(math::fabs(c.radius * c.radius - dy * dy));
    if (math::fabs(dy) >= c.radius) continue;
    const double from = c.x - half > 0 ? c.x - half : 0, to = c.x + half < image.width ? c.x + half : image.width;
    if (from >= to) continue;
    visible += to - from;
    while (i < runs.size() && runs[i].y < y) ++i;
    for (; i < runs.size() && runs[i].y == y; ++i) {
      const double x0 = runs[i].x0 > from ? runs[i].x0 : from, x1 = runs[i].x1 < to ? runs[i].x1 : to;
      if (x1 > x0) coloured += x1 - x0;
    }
  }
  return visible > 0 ? coloured / visible : 0;
}

PadCircle PadFinder::judge(const ImageView& image, const Circle& circle, bool bright) const {
  PadCircle pad;
  if (!circle.valid || point_count_ < kPadStrays.min_points) return pad;
  // The region must lie inside of the circle: left ends left of the centre. (The outer edge of the ring is no circle
  // around the region that it bounds.)
  std::size_t same = 0, fitting = 0;
  for (std::size_t i = 0; i < edge_count_; ++i) {
    if (edges_[i].bright != bright) continue;
    ++same;
    fitting += edges_[i].left == (edges_[i].at.x < circle.x);
  }
  // A circle has two ends in each of its 2 r rows.
  pad.coverage = clamp_share(static_cast<double>(point_count_) / (4 * circle.radius));
  const double smooth = clamp_share(1.5 - circle.rms / (0.04 * circle.radius + 0.4));
  const double agreeing = clamp_share((static_cast<double>(point_count_) / static_cast<double>(same) - 0.4) / 0.3);
  // The paint inside (ring and H) leaves 0.89 of the pad and 0.86 of the ring's inside in the pad's colour.
  pad.fill = fill(image, circle);
  const double filled = clamp_share((pad.fill - 0.6) / 0.15);
  pad.confidence = smooth * agreeing * filled * clamp_share(pad.coverage / 0.2) * clamp_share(circle.radius / 5);
  pad.circle = circle;
  pad.is_mark = bright;
  pad.radius_m = bright ? look_.mark_radius_m : look_.radius_m;
  pad.found = 10 * fitting >= 8 * same && pad.confidence > 0.05;
  return pad;
}

namespace {

/// The measurement with more metres of visible outline is better, if the outline is round.
double pad_weight(const PadCircle& pad) { return pad.found ? pad.confidence * pad.coverage * pad.radius_m : 0; }

/// The image of a circle's centre is off the centre of the circle's image by k * radius^2. k is the same for all
/// circles in one plane: two concentric circles give k.
/// Source:  first order of the projection of a tilted circle: k = tilt * f / range^2.
void correct_perspective(const PadCircle& edge, const PadCircle& mark, PadCircle& best) {
  const double ratio = mark.circle.radius / edge.circle.radius, expected = mark.radius_m / edge.radius_m;
  if (edge.coverage < 0.6 || mark.coverage < 0.6 || math::fabs(ratio / expected - 1) > 0.15) return;
  const double share = mark.radius_m * mark.radius_m / (edge.radius_m * edge.radius_m - mark.radius_m * mark.radius_m);
  best.circle.x = mark.circle.x + share * (mark.circle.x - edge.circle.x);
  best.circle.y = mark.circle.y + share * (mark.circle.y - edge.circle.y);
}

}  // namespace

PadCircle PadFinder::outline(const ImageView& image) {
  const auto blobs = segmentation_.blobs();
  const auto candidates = largest<kCandidates>(blobs);
  PadCircle edge, mark;
  for (const Blob* blob : candidates) {
    if (blob == nullptr || 20 * blob->area_px < candidates[0]->area_px) break;  // crumbs beside the pad
    collect_edges(image, *blob);
    for (const bool bright : {false, true}) {
      if (bright && look_.mark_radius_m <= 0) continue;
      const PadCircle pad = judge(image, fit(bright), bright);
      PadCircle& best = bright ? mark : edge;
      if (pad_weight(pad) > pad_weight(best)) best = pad;
    }
  }
  PadCircle best = pad_weight(edge) >= pad_weight(mark) ? edge : mark;
  if (edge.found && mark.found) correct_perspective(edge, mark, best);
  best.blobs = static_cast<std::uint32_t>(blobs.size());
  return best;
}

}  // namespace sinew::vision
