#include "vision/board_finder.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "math/elementary.hpp"

namespace sinew::vision {
namespace {

constexpr int kRing[16][2] = {{5, 0},  {5, 2},   {4, 4},   {2, 5},   {0, 5},  {-2, 5}, {-4, 4}, {-5, 2},
                              {-5, 0}, {-5, -2}, {-4, -4}, {-2, -5}, {0, -5}, {2, -5}, {4, -4}, {5, -2}};
constexpr int kMargin = 7;
constexpr double kLeastStrength = 16 * 12;  // of 16 differences of 12 grey levels
constexpr double kShareOfBest = 0.08;
constexpr std::size_t kMostCandidates = 4000, kMostSeeds = 200;
constexpr double kAside = 0.35;  // of a step: how far from where it is expected the next corner may be
constexpr double kLeastStep_px = 5;
constexpr int kSpan = 64;  // cells of the grid that grows, in each direction from the seed

}  // namespace

/// Which candidate is at (i, j) from the seed; -1: none.
struct BoardFinder::Grid {
  std::vector<int> cell = std::vector<int>(std::size_t{2 * kSpan + 1} * (2 * kSpan + 1), -1);
  int least_i = 0, most_i = 0, least_j = 0, most_j = 0;

  static bool inside(int i, int j) { return i >= -kSpan && i <= kSpan && j >= -kSpan && j <= kSpan; }
  int at(int i, int j) const {
    return inside(i, j) ? cell[static_cast<std::size_t>((j + kSpan) * (2 * kSpan + 1) + i + kSpan)] : -1;
  }
  void set(int i, int j, int candidate) {
    cell[static_cast<std::size_t>((j + kSpan) * (2 * kSpan + 1) + i + kSpan)] = candidate;
    least_i = std::min(least_i, i), most_i = std::max(most_i, i);
    least_j = std::min(least_j, j), most_j = std::max(most_j, j);
  }
};

double BoardFinder::grey(double u, double v) const {
  u = std::clamp(u, 0.0, width_ - 1.001), v = std::clamp(v, 0.0, height_ - 1.001);
  const auto x = static_cast<std::size_t>(u), y = static_cast<std::size_t>(v);
  const double a = u - static_cast<double>(x), b = v - static_cast<double>(y);
  const float* p = &grey_[y * width_ + x];
  return (1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * p[width_] + a * p[width_ + 1]);
}

/// By 1 2 1 in both directions.
void BoardFinder::smooth(const ImageView& mono) {
  width_ = mono.width, height_ = mono.height;
  grey_.resize(std::size_t{width_} * height_);
  soft_.assign(grey_.size(), 0);
  for (std::uint32_t y = 0; y < height_; ++y)
    for (std::uint32_t x = 0; x < width_; ++x) grey_[std::size_t{y} * width_ + x] = mono.row(y)[x];
  for (std::uint32_t y = 1; y + 1 < height_; ++y)
    for (std::uint32_t x = 1; x + 1 < width_; ++x) {
      const float* p = &grey_[std::size_t{y} * width_ + x];
      const auto row = [](const float* q) { return q[-1] + 2 * q[0] + q[1]; };
      soft_[std::size_t{y} * width_ + x] = (row(p - width_) + 2 * row(p) + row(p + width_)) / 16;
    }
}

void BoardFinder::find_candidates() {
  candidate_.clear();
  if (width_ < 4 * kMargin || height_ < 4 * kMargin) return;
  std::vector<float> strength(grey_.size(), 0);
  float best = 0;
  for (std::uint32_t y = kMargin; y < height_ - kMargin; ++y)
    for (std::uint32_t x = kMargin; x < width_ - kMargin; ++x) {
      const float* p = &soft_[std::size_t{y} * width_ + x];
      std::array<float, 16> ring;
      float mean = 0;
      for (std::size_t k = 0; k < 16; ++k) {
        ring[k] = p[kRing[k][1] * static_cast<int>(width_) + kRing[k][0]];
        mean += ring[k] / 16;
      }
      float sum = 0;
      for (std::size_t k = 0; k < 4; ++k) sum += std::abs(ring[k] + ring[k + 8] - ring[k + 4] - ring[k + 12]);
      for (std::size_t k = 0; k < 8; ++k) sum -= std::abs(ring[k] - ring[k + 8]);
      const auto w = static_cast<std::ptrdiff_t>(width_);
      const float middle = (p[0] + p[1] + p[-1] + p[w] + p[-w]) / 5;
      sum -= 4 * std::abs(middle - mean);
      if (sum <= 0) continue;
      strength[std::size_t{y} * width_ + x] = sum;
      best = std::max(best, sum);
    }
  const double least = std::max(kLeastStrength / 4, kShareOfBest * static_cast<double>(best));
  for (std::uint32_t y = kMargin; y < height_ - kMargin; ++y)
    for (std::uint32_t x = kMargin; x < width_ - kMargin; ++x) {
      const float s = strength[std::size_t{y} * width_ + x];
      if (s < least) continue;
      bool top = true;
      double sum = 0, u = 0, v = 0;
      for (int dy = -2; dy <= 2 && top; ++dy)
        for (int dx = -2; dx <= 2 && top; ++dx) {
          const float other = strength[(y + static_cast<std::size_t>(dy + 2) - 2) * width_ +
                                       (x + static_cast<std::size_t>(dx + 2) - 2)];
          top = other < s || (other == s && (dy > 0 || (dy == 0 && dx >= 0)));
          sum += other, u += other * static_cast<double>(dx), v += other * static_cast<double>(dy);
        }
      if (!top) continue;
      Candidate c{x + u / sum, y + v / sum, s, 0, 0};
      const float* p = &soft_[std::size_t{y} * width_ + x];
      for (std::size_t k = 0; k < 16; ++k) {
        const double value = p[kRing[k][1] * static_cast<int>(width_) + kRing[k][0]];
        const math::SinCos turn = math::sincos(static_cast<double>(k) * math::kPi / 4);
        c.cos2 += value * turn.cos, c.sin2 += value * turn.sin;
      }
      const double size = math::hypot(c.cos2, c.sin2);
      if (!(size > 0)) continue;
      c.cos2 /= size, c.sin2 /= size;
      candidate_.push_back(c);
    }
  std::stable_sort(candidate_.begin(), candidate_.end(),
                   [](const Candidate& a, const Candidate& b) { return a.strength > b.strength; });
  if (candidate_.size() > kMostCandidates) candidate_.resize(kMostCandidates);
}

/// Neighbours on a board have their bright quarters where the others' dark ones are. -1: there is none.
int BoardFinder::nearest(double u, double v, double within, const Candidate& like, bool opposite) const {
  int best = -1;
  double least = within * within;
  for (std::size_t i = 0; i < candidate_.size(); ++i) {
    const Candidate& c = candidate_[i];
    const double d2 = (c.u - u) * (c.u - u) + (c.v - v) * (c.v - v);
    const double same = c.cos2 * like.cos2 + c.sin2 * like.sin2;
    if (d2 < least && (opposite ? same < -0.5 : same > 0.5)) least = d2, best = static_cast<int>(i);
  }
  return best;
}

bool BoardFinder::grow(std::size_t seed, Grid& grid) const {
  const Candidate& s = candidate_[seed];
  // The edges are half way between the bright quarters' axis and the dark ones'.
  const double bright = 0.5 * math::atan2(s.sin2, s.cos2);
  std::array<int, 2> next{-1, -1};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const math::SinCos edge = math::sincos(bright + (axis == 0 ? -1 : 1) * math::kPi / 4);
    double least = 1e12;
    for (std::size_t i = 0; i < candidate_.size(); ++i) {
      const Candidate& c = candidate_[i];
      const double du = c.u - s.u, dv = c.v - s.v, along = du * edge.cos + dv * edge.sin,
                   across = dv * edge.cos - du * edge.sin, d2 = du * du + dv * dv;
      if (math::fabs(along) < 1.5 * math::fabs(across) || d2 < kLeastStep_px * kLeastStep_px || d2 >= least) continue;
      if (c.cos2 * s.cos2 + c.sin2 * s.sin2 > -0.5) continue;
      least = d2, next[axis] = static_cast<int>(i);
    }
    if (next[axis] < 0) return false;
  }
  grid.set(0, 0, static_cast<int>(seed)), grid.set(1, 0, next[0]), grid.set(0, 1, next[1]);
  std::vector<std::array<int, 2>> open{{0, 0}, {1, 0}, {0, 1}};
  std::vector<bool> used(candidate_.size());
  used[seed] = used[static_cast<std::size_t>(next[0])] = used[static_cast<std::size_t>(next[1])] = true;
  constexpr int kWays[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  for (bool any = true; any;) {
    any = false;
    for (std::size_t o = 0; o < open.size(); ++o) {
      const auto [i, j] = open[o];
      const Candidate& here = candidate_[static_cast<std::size_t>(grid.at(i, j))];
      for (const auto& way : kWays) {
        const int ni = i + way[0], nj = j + way[1];
        if (!Grid::inside(ni, nj) || grid.at(ni, nj) >= 0) continue;
        // The step before this one, or the same one in a row beside.
        const int steps[3][4] = {{i - way[0], j - way[1], i, j},
                                 {i + way[1], j + way[0], ni + way[1], nj + way[0]},
                                 {i - way[1], j - way[0], ni - way[1], nj - way[0]}};
        for (const auto& step : steps) {
          const int from = grid.at(step[0], step[1]), to = grid.at(step[2], step[3]);
          if (from < 0 || to < 0) continue;
          const Candidate &a = candidate_[static_cast<std::size_t>(from)],
                          &b = candidate_[static_cast<std::size_t>(to)];
          const double du = b.u - a.u, dv = b.v - a.v;
          const int found = nearest(here.u + du, here.v + dv, kAside * math::hypot(du, dv), here, true);
          if (found < 0 || used[static_cast<std::size_t>(found)]) continue;
          grid.set(ni, nj, found);
          used[static_cast<std::size_t>(found)] = true;
          open.push_back({ni, nj});
          any = true;
          break;
        }
      }
    }
  }
  return true;
}

/// The only part of the grid that is whole and has the board's size.
bool BoardFinder::take(const Grid& grid) {
  const int columns = static_cast<int>(size_.columns), rows = static_cast<int>(size_.rows);
  std::vector<std::array<int, 3>> found;  // i, j, turned
  for (const bool turned : {false, true}) {
    if (turned && columns == rows) break;
    const int wide = turned ? rows : columns, high = turned ? columns : rows;
    for (int j = grid.least_j; j + high - 1 <= grid.most_j; ++j)
      for (int i = grid.least_i; i + wide - 1 <= grid.most_i; ++i) {
        bool whole = true;
        for (int y = 0; y < high && whole; ++y)
          for (int x = 0; x < wide && whole; ++x) whole = grid.at(i + x, j + y) >= 0;
        if (whole) found.push_back({i, j, turned});
      }
  }
  if (found.size() != 1) return false;
  corners_.clear();
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const auto [i, j, turned] = found[0];
      const Candidate& c = candidate_[static_cast<std::size_t>(turned ? grid.at(i + y, j + x) : grid.at(i + x, j + y))];
      corners_.push_back({c.u, c.v});
    }
  return true;
}

/// Each corner to the point to which the gradients around it are normal.
void BoardFinder::refine() {
  const int columns = static_cast<int>(size_.columns), rows = static_cast<int>(size_.rows);
  const std::vector<BoardCorner> rough = corners_;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      double step = 1e9;
      for (const auto& way : {std::array{1, 0}, std::array{-1, 0}, std::array{0, 1}, std::array{0, -1}}) {
        const int i = x + way[0], j = y + way[1];
        if (i < 0 || j < 0 || i >= columns || j >= rows) continue;
        const BoardCorner &a = rough[static_cast<std::size_t>(y * columns + x)],
                          &b = rough[static_cast<std::size_t>(j * columns + i)];
        step = std::min(step, math::hypot(a.u_px - b.u_px, a.v_px - b.v_px));
      }
      BoardCorner& c = corners_[static_cast<std::size_t>(y * columns + x)];
      const BoardCorner begin = c;
      const int half = static_cast<int>(std::clamp(0.45 * step, 2.0, 7.0));
      for (int round = 0; round < 12; ++round) {
        double uu = 0, uv = 0, vv = 0, bu = 0, bv = 0;
        for (int dy = -half; dy <= half; ++dy)
          for (int dx = -half; dx <= half; ++dx) {
            const double u = c.u_px + dx, v = c.v_px + dy;
            const double gu = grey(u + 1, v) - grey(u - 1, v), gv = grey(u, v + 1) - grey(u, v - 1);
            const double w = (half + 1 - std::abs(dx)) * (half + 1 - std::abs(dy));
            uu += w * gu * gu, uv += w * gu * gv, vv += w * gv * gv;
            bu += w * gu * (gu * dx + gv * dy), bv += w * gv * (gu * dx + gv * dy);
          }
        const double det = uu * vv - uv * uv;
        if (!(det > 1e-6 * uu * vv)) break;
        const double mu = (vv * bu - uv * bv) / det, mv = (uu * bv - uv * bu) / det;
        const BoardCorner next{c.u_px + mu, c.v_px + mv};
        if (!(math::hypot(next.u_px - begin.u_px, next.v_px - begin.v_px) < 0.5 * step)) {
          c = begin;
          break;
        }
        c = next;
        if (mu * mu + mv * mv < 1e-6) break;
      }
    }
}

void BoardFinder::order() {
  const std::size_t columns = size_.columns, rows = size_.rows;
  const auto at = [&](std::size_t x, std::size_t y) -> BoardCorner& { return corners_[y * columns + x]; };
  const BoardCorner o = at(0, 0), i = at(columns - 1, 0), j = at(0, rows - 1);
  if ((i.u_px - o.u_px) * (j.v_px - o.v_px) - (i.v_px - o.v_px) * (j.u_px - o.u_px) < 0)
    for (std::size_t y = 0; y < rows; ++y)
      for (std::size_t x = 0; x < columns / 2; ++x) std::swap(at(x, y), at(columns - 1 - x, y));
  // Dark or bright: all squares are asked, the first one's colour wins.
  double first = 0;
  for (std::size_t y = 0; y + 1 < rows; ++y)
    for (std::size_t x = 0; x + 1 < columns; ++x) {
      double u = 0, v = 0;
      for (const BoardCorner& c : {at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)})
        u += c.u_px / 4, v += c.v_px / 4;
      first += ((x + y) % 2 == 0 ? 1 : -1) * grey(u, v);
    }
  // With an even number of squares the sum has as many of both; with an odd one the first colour has one more.
  double all = 0;
  if ((columns - 1) * (rows - 1) % 2 == 1) {
    for (std::size_t y = 0; y + 1 < rows; ++y)
      for (std::size_t x = 0; x + 1 < columns; ++x) {
        double u = 0, v = 0;
        for (const BoardCorner& c : {at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)})
          u += c.u_px / 4, v += c.v_px / 4;
        all += grey(u, v) / static_cast<double>((columns - 1) * (rows - 1));
      }
  }
  if (first - all > 0) std::reverse(corners_.begin(), corners_.end());
}

bool BoardFinder::find(const ImageView& mono) {
  corners_.clear();
  if (!mono || mono.format != msg::PixelFormat::mono8 || size_.columns < 3 || size_.rows < 3 || size_.columns > 32 ||
      size_.rows > 32)
    return false;
  smooth(mono);
  find_candidates();
  const std::size_t needed = std::size_t{size_.columns} * size_.rows;
  if (candidate_.size() < needed) return false;
  std::vector<bool> tried(candidate_.size());
  for (std::size_t seed = 0; seed < std::min(candidate_.size(), kMostSeeds); ++seed) {
    if (tried[seed]) continue;
    Grid grid;
    if (!grow(seed, grid)) continue;
    if (take(grid)) {
      refine();
      order();
      return true;
    }
    for (const int c : grid.cell)
      if (c >= 0) tried[static_cast<std::size_t>(c)] = true;
  }
  return false;
}

}  // namespace sinew::vision
