#include "soccer/sight/field_border.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

constexpr int kLeastScore = 3;  // samples of carpet more than others
constexpr double kOnHull_px = 2.5;

}  // namespace

void FieldBorder::find(const Picture& picture, const GroundView& view) {
  const int w = picture.width(), h = picture.height();
  step_px_ = static_cast<double>(w - 1) / (kColumns - 1);
  const int stride = std::max(1, h / 240);
  std::array<double, kColumns> top{};
  int seen = 0;
  for (int i = 0; i < kColumns; ++i) {
    const int x = std::min(w - 1, static_cast<int>(i * step_px_ + 0.5));
    const int first = std::clamp(static_cast<int>(view.horizon_px(x)) + 1, 0, h);
    int score = 0, best = kLeastScore, row = h;
    for (int y = h - 1; y >= first; y -= stride) {
      score += picture.at(x, y) == Colour::carpet ? 1 : -1;
      score = std::max(score, -20);  // a robot before the camera hides what is behind it, not what is above it
      if (score > best || (score == best && row != h)) best = score, row = y;
    }
    top[static_cast<std::size_t>(i)] = row;
    seen += row < h;
  }
  found_ = seen >= 3;
  // A single column that is higher than both beside it is not the carpet's.
  std::array<double, kColumns> calm = top;
  for (std::size_t i = 1; i + 1 < kColumns; ++i) calm[i] = std::max(top[i], std::min(top[i - 1], top[i + 1]));
  // Upper hull, from left to right.
  std::array<std::size_t, kColumns> hull{};
  std::size_t n = 0;
  for (std::size_t i = 0; i < kColumns; ++i) {
    if (calm[i] >= h) continue;
    while (n >= 2) {
      const double ax = static_cast<double>(hull[n - 1] - hull[n - 2]), ay = calm[hull[n - 1]] - calm[hull[n - 2]];
      const double bx = static_cast<double>(i - hull[n - 2]), by = calm[i] - calm[hull[n - 2]];
      if (ax * by - ay * bx > 0) break;
      --n;
    }
    hull[n++] = i;
  }
  for (std::size_t i = 0; i < kColumns; ++i)
    point_[i] = {static_cast<double>(i) * step_px_, static_cast<double>(h), false};
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t to = k + 1 < n ? hull[k + 1] : hull[k];
    for (std::size_t i = hull[k]; i <= to; ++i) {
      const double share = to == hull[k] ? 0 : static_cast<double>(i - hull[k]) / static_cast<double>(to - hull[k]);
      point_[i].v_px = calm[hull[k]] + share * (calm[to] - calm[hull[k]]);
      point_[i].measured = point_[i].v_px > 2 * stride && math::fabs(calm[i] - point_[i].v_px) < kOnHull_px * stride;
    }
  }
}

double FieldBorder::row_px(double u_px) const {
  const double at = std::clamp(u_px / step_px_, 0.0, kColumns - 1.0);
  const auto i = std::min(static_cast<std::size_t>(at), std::size_t{kColumns - 2});
  const double share = at - static_cast<double>(i);
  return point_[i].v_px * (1 - share) + point_[i + 1].v_px * share;
}

}  // namespace sinew::soccer
