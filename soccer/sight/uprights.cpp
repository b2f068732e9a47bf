#include "soccer/sight/uprights.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

constexpr double kPostWide_m = 0.1, kPostHigh_m = 1.2, kRobotHigh_m = 0.5;
constexpr double kNearest_m = 0.25;  // nearer is the robot itself
constexpr double kGap = 0.22;  // between a body and its legs, of the height of the camera over the body's lower edge
constexpr double kThinnest_m = 0.06, kWidestRobot_m = 0.75;
constexpr int kMostColumns = 640;

}  // namespace

void Uprights::find(const Picture& picture, const GroundView& view, const FieldBorder& border,
                    const CarpetLook& carpet_look) {
  count_ = 0;
  darker_ = static_cast<int>(0.92 * carpet_look.luma);
  const int w = picture.width(), h = picture.height(), pitch = std::max(1, w / 320), stride = std::max(1, h / 240);
  const int columns = std::min(kMostColumns, w / pitch);
  std::array<int, kMostColumns> foot{};
  for (int i = 0; i < columns; ++i) {
    const int x = i * pitch, top = std::clamp(static_cast<int>(border.row_px(x)), 0, h);
    const double horizon = view.horizon_px(x);
    int carpet = 0, last = -1, filled = 0;
    for (int y = top; y < h; ++y) {
      const Colour c = picture.at(x, y);
      if (c == Colour::carpet) {
        if (++carpet > 2 * stride + kGap * (y - horizon)) break;
        continue;
      }
      // Behind a gap only what is no line goes on: legs under a body.
      if (carpet > 2 * stride && c == Colour::white) break;
      carpet = 0, last = y, ++filled;
    }
    foot[static_cast<std::size_t>(i)] =
        last - top >= 3 * stride && filled >= 3 * stride && filled * 10 > (last - top) * 3 ? last : -1;
  }
  find_posts(picture, view, border, {foot.data(), static_cast<std::size_t>(columns)}, pitch);
  // Neighbours whose feet are at about one distance.
  for (int i = 0; i < columns;) {
    if (foot[static_cast<std::size_t>(i)] < 0) {
      ++i;
      continue;
    }
    int end = i + 1, lowest = foot[static_cast<std::size_t>(i)];
    const auto near = [&](int a, int b) {
      const double horizon = view.horizon_px(i * pitch);
      return std::abs(a - b) < 3 * stride + 0.2 * (std::max(a, b) - horizon);
    };
    while (end < columns && foot[static_cast<std::size_t>(end)] >= 0 &&
           near(foot[static_cast<std::size_t>(end)], foot[static_cast<std::size_t>(end - 1)])) {
      lowest = std::max(lowest, foot[static_cast<std::size_t>(end)]);
      ++end;
    }
    add(picture, view, border, i * pitch, end * pitch - 1, lowest);
    i = end;
  }
  // What goes on below the picture is nowhere on the ground; what is too thin is none.
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count_; ++i)
    if (thing_[i].is_post || (!thing_[i].is_cut && thing_[i].wide_m >= kThinnest_m)) thing_[kept++] = thing_[i];
  count_ = kept;
}

void Uprights::find_posts(const Picture& picture, const GroundView& view, const FieldBorder& border,
                          std::span<int> foot, int pitch) {
  const int w = picture.width(), h = picture.height();
  // A column through the middle of a post differs from those beside it, all the way up.
  const auto is_post = [&](int i, double& px_per_m, double& share) {
    const int x = i * pitch, y0 = foot[static_cast<std::size_t>(i)];
    const double edge = border.row_px(x);
    if (y0 < 0 || y0 >= h - 2 || edge < 3) return false;
    const auto feet = view.ground(x, y0 + 0.5);
    if (!feet || math::hypot(feet->x_m, feet->y_m) < kNearest_m) return false;
    const PixelAt at = view.pixel(*feet);
    if (!(at.depth_m > 0)) return false;
    px_per_m = view.camera().fx_px / at.depth_m;
    const int away = std::max(3, static_cast<int>(0.8 * kPostWide_m * px_per_m + 2.5));
    // What stands upright leans in the picture of a camera that looks down.
    constexpr int kPlaces = 16, kLeast = 5, kEdge = 5;
    int good = 0, coloured = 0, asked = 0, highest = y0;
    for (int k = 0; k < kPlaces; ++k) {
      const PixelAt up = view.pixel({feet->x_m, feet->y_m, kPostHigh_m * (0.03 + 0.87 * k / (kPlaces - 1))});
      if (!(up.depth_m > 0) || up.v_px < 1) break;
      const int px = static_cast<int>(up.u_px + 0.5), y = static_cast<int>(up.v_px + 0.5);
      if (px < away || px + away >= w || y >= h) return false;
      highest = std::min(highest, y);
      const int in = picture.luma(px, y), left = picture.luma(px - away, y), right = picture.luma(px + away, y);
      const Colour c = picture.at(px, y);
      ++asked;
      coloured += c == Colour::blue || c == Colour::red || c == Colour::carpet;
      good += (in > left + kEdge && in > right + kEdge) || (in < left - kEdge && in < right - kEdge) ||
              (c != Colour::carpet && picture.at(px - away, y) == Colour::carpet &&
               picture.at(px + away, y) == Colour::carpet);
    }
    share = static_cast<double>(good) / std::max(1, asked);
    return asked >= kLeast && highest < edge - 0.25 * px_per_m && good * 10 >= asked * 8 && coloured * 8 <= asked;
  };
  const int columns = static_cast<int>(foot.size());
  for (int i = 0; i < columns; ++i) {
    double px_per_m = 1, share = 0;
    if (!is_post(i, px_per_m, share)) continue;
    int end = i + 1;
    for (double other = 1, more = 0; end < columns && is_post(end, other, more); ++end) share = std::max(share, more);
    const double wide_m = (end - i) * pitch / px_per_m;
    const int middle = (i + end - 1) / 2, y0 = foot[static_cast<std::size_t>(middle)];
    const auto feet = view.ground(0.5 * (i + end - 1) * pitch, y0 + 0.5);
    if (wide_m < 2 * kPostWide_m && feet && count_ < kMost) {
      Thing& t = thing_[count_++];
      t = {};
      t.feet = *feet;
      t.u0_px = i * pitch, t.u1_px = end * pitch - 1, t.foot_px = y0;
      t.wide_m = wide_m, t.is_post = true, t.confidence = share;
      // These columns, and those of its sides, are of nothing else.
      const int side = static_cast<int>(0.7 * kPostWide_m * px_per_m / pitch) + 1;
      for (int k = std::max(0, middle - side); k < std::min(columns, middle + side + 1); ++k)
        foot[static_cast<std::size_t>(k)] = -1;
    }
    i = end;
  }
}

void Uprights::add(const Picture& picture, const GroundView& view, const FieldBorder& border, int x0, int x1,
                   int foot) {
  const int h = picture.height();
  const double middle = 0.5 * (x0 + x1);
  const auto feet = view.ground(middle, foot + 0.5);
  if (!feet || math::hypot(feet->x_m, feet->y_m) < kNearest_m) return;
  const PixelAt at = view.pixel(*feet);
  if (!(at.depth_m > 0)) return;
  const double px_per_m = view.camera().fx_px / at.depth_m;
  Thing t;
  t.feet = *feet;
  t.px_per_m = px_per_m, t.is_cut = foot >= h - 2;
  t.u0_px = x0, t.u1_px = x1, t.foot_px = foot;
  t.wide_m = (x1 - x0 + 1) / px_per_m;
  // Colours of a box as high as a robot.
  const int high = static_cast<int>(kRobotHigh_m * px_per_m);
  int all = 0, dark = 0, blue = 0, red = 0, body = 0, inside = 0;
  const int edge = static_cast<int>(border.row_px(middle));
  const int step = std::max(1, high / 40);
  for (int y = std::max(0, foot - high); y <= foot; y += step)
    for (int x = x0; x <= x1; x += step) {
      const Colour c = picture.at(x, y);
      ++all, dark += c == Colour::dark, blue += c == Colour::blue, red += c == Colour::red;
      if (y < edge || c == Colour::carpet) continue;  // what is beyond the carpet says nothing of what stands on it
      ++inside;
      body += c == Colour::dark || c == Colour::blue || c == Colour::red ||
              (c == Colour::other && picture.luma(x, y) < darker_);
    }
  t.dark = static_cast<double>(dark) / all, t.blue = static_cast<double>(blue) / all;
  t.red = static_cast<double>(red) / all;
  // Most of a robot, and little of a line.
  const double coloured = static_cast<double>(body) / std::max(1, inside);
  if (coloured < 0.4 || foot - edge < 4.0 * h / 240) return;
  t.confidence = 0.15 + 0.45 * coloured;  // about half of such things are robots: docs/soccer-vision.md
  // Legs, body and arms of one robot: columns beside each other, at the scale of the part that is nearer, whose foot
  // is the robot's.
  for (std::size_t i = 0; i < count_; ++i) {
    Thing& o = thing_[i];
    const double scale = std::max(px_per_m, o.px_per_m);
    const double gap = std::max(t.u0_px - o.u1_px, o.u0_px - t.u1_px);
    const double wide = std::max(t.u1_px, o.u1_px) - std::min(t.u0_px, o.u0_px);
    if (o.is_post || gap > 0.12 * scale + 2 || wide > kWidestRobot_m * scale) continue;
    const double share = (t.u1_px - t.u0_px + 1) / (o.u1_px - o.u0_px + t.u1_px - t.u0_px + 2);
    o.foot_px = std::max(o.foot_px, t.foot_px), o.is_cut = o.is_cut || t.is_cut, o.px_per_m = scale;
    o.u0_px = std::min(o.u0_px, t.u0_px), o.u1_px = std::max(o.u1_px, t.u1_px);
    const auto both = view.ground(0.5 * (o.u0_px + o.u1_px), o.foot_px + 0.5);
    if (both) o.feet = *both;
    o.dark += share * (t.dark - o.dark), o.blue += share * (t.blue - o.blue), o.red += share * (t.red - o.red);
    o.wide_m = wide / scale;
    o.confidence = std::max(o.confidence, t.confidence);
    return;
  }
  if (count_ < kMost) thing_[count_++] = t;
}

}  // namespace sinew::soccer
