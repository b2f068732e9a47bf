#include "soccer/sight/line_points.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

constexpr int kColumns = 80, kLeastCarpet_px = 2;
constexpr double kRowRatio = 0.09;
constexpr double kWidest_m = 0.15;  // a line that a scan crosses at 20 degrees
constexpr double kPointFarthest_m = 7;

/// One scan: `at(i)` is the pixel of place i.
template <class At>
void scan(const Picture& picture, int from, int to, const At& at, const auto& found) {
  int begin = -1, carpet = 0;  // of the piece that is no carpet; carpet before it
  int before = 0, last_carpet = 0;
  for (int i = from; i < to; ++i) {
    const auto [x, y] = at(i);
    if (picture.at(x, y) == Colour::carpet) {
      if (begin >= 0) before = carpet, carpet = 0;
      ++carpet;
      last_carpet = i;
      if (begin >= 0 && carpet == 1) {
        // The piece ended; it counts when so much carpet follows.
        bool enough = before >= kLeastCarpet_px && i + kLeastCarpet_px <= to;
        for (int k = 0; enough && k < kLeastCarpet_px; ++k) {
          const auto [px, py] = at(i + k);
          enough = picture.at(px, py) == Colour::carpet;
        }
        if (enough) found(begin, i - 1);
        begin = -1;
      }
    } else if (begin < 0) {
      begin = i;
      (void)last_carpet;
    }
  }
}

}  // namespace

void LinePoints::find(const Picture& picture, const GroundView& view, const FieldBorder& border) {
  count_ = 0;
  const int w = picture.width(), h = picture.height();
  const auto add = [&](auto at, int first, int last, bool in_column) {
    if (count_ == kMost) return;
    // Brightness of the carpet on both sides, and where the brighter part between has its middle.
    const auto luma = [&](int i) {
      const auto [x, y] = at(i);
      return picture.luma(x, y);
    };
    const int side = std::max(luma(first - 2), luma(last + 2));
    int brightest = 0, bad = 0;
    double sum = 0, moment = 0;
    for (int i = first - 1; i <= last + 1; ++i) {
      const int y = luma(i);
      const auto [px, py] = at(i);
      const Colour c = picture.at(px, py);
      bad += c == Colour::dark || c == Colour::red || c == Colour::blue;
      brightest = std::max(brightest, y);
      const double more = std::max(0, y - side);
      sum += more, moment += more * i;
    }
    if (brightest < side + 8 + side / 8 || bad * 3 > last - first + 1 || !(sum > 0)) return;
    const double middle = moment / sum;
    const auto [x0, y0] = at(first);
    const auto [x1, y1] = at(last);
    const double du = in_column ? 0 : 0.5, dv = in_column ? 0.5 : 0;
    const auto a = view.ground(x0 - du, y0 - dv), b = view.ground(x1 + du, y1 + dv);
    const double u = in_column ? x0 : middle, v = in_column ? middle : y0;
    const auto p = view.ground(u, v);
    if (!a || !b || !p) return;
    const double wide_m = math::hypot(a->x_m - b->x_m, a->y_m - b->y_m);
    const double pixel_m = wide_m / (last - first + 1);
    if (wide_m > kWidest_m + 1.5 * pixel_m || wide_m + 2.5 * pixel_m < kLineWide_m) return;
    if (math::hypot(p->x_m - view.camera_m().x, p->y_m - view.camera_m().y) > kPointFarthest_m) return;
    point_[count_++] = {static_cast<float>(u),
                        static_cast<float>(v),
                        static_cast<float>(p->x_m),
                        static_cast<float>(p->y_m),
                        static_cast<float>(last - first + 1),
                        in_column};
  };
  const double step = static_cast<double>(w) / kColumns;
  for (int k = 0; k < kColumns; ++k) {
    const int x = static_cast<int>((k + 0.5) * step);
    const int top = std::clamp(static_cast<int>(border.row_px(x)), 0, h);
    const auto at = [x](int i) { return std::pair{x, i}; };
    scan(picture, top, h, at, [&](int first, int last) {
      if (first - 2 >= 0 && last + 2 < h) add(at, first, last, true);
    });
  }
  double lowest_horizon = std::max(view.horizon_px(0), view.horizon_px(w - 1));
  for (double row = std::max(0.0, lowest_horizon) + 2.0 * h / 120; row < h;
       row += std::max(h / 120.0, kRowRatio * (row - lowest_horizon))) {
    const int y = static_cast<int>(row);
    const auto at = [y](int i) { return std::pair{i, y}; };
    // Only what is below the border; it is convex, so a row enters it once and leaves it once.
    int from = 0, to = w;
    while (from < w && border.row_px(from) > y) from += 4;
    while (to > from && border.row_px(to - 1) > y) to -= 4;
    scan(picture, from, std::max(from, to), at, [&](int first, int last) {
      if (first - 2 >= 0 && last + 2 < w) add(at, first, last, false);
    });
  }
}

}  // namespace sinew::soccer
