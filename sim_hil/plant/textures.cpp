// The pictures on floor, walls and pad, painted by code. Integers, +, -, *, / and sqrt only: the same bytes everywhere.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sim_hil/plant/textures.hpp"

namespace sinew::plant {
namespace {

struct Rgb {
  double r, g, b;
};

Rgb mix(const Rgb& a, const Rgb& b, double share_of_b) {
  const double s = std::clamp(share_of_b, 0.0, 1.0);
  return {a.r + s * (b.r - a.r), a.g + s * (b.g - a.g), a.b + s * (b.b - a.b)};
}
Rgb shade(const Rgb& c, double factor) { return {c.r * factor, c.g * factor, c.b * factor}; }

/// A texture of the model as a canvas: x to the right, y up, as MuJoCo maps it onto a plane.
class Canvas {
 public:
  Canvas(mjModel& model, const char* name) {
    const int id = mj_name2id(&model, mjOBJ_TEXTURE, name);
    if (id < 0) return;
    width_ = model.tex_width[id];
    height_ = model.tex_height[id];
    rgb_ = model.tex_rgb + model.tex_adr[id];
  }
  int width() const { return width_; }
  int height() const { return height_; }
  template <class Paint>
  void fill(Paint&& paint) {
    fill_rows(0, height_, paint);
  }
  template <class Paint>
  void fill_rows(int begin, int end, Paint&& paint) {
    for (int y = begin; y < end; ++y)
      for (int x = 0; x < width_; ++x) put(x, y, paint(x, y));
  }

 private:
  void put(int x, int y, const Rgb& c) {
    mjtByte* p = rgb_ + 3 * (static_cast<std::ptrdiff_t>(height_ - 1 - y) * width_ + x);
    const auto byte = [](double v) { return static_cast<mjtByte>(std::clamp(v, 0.0, 255.0)); };
    p[0] = byte(c.r), p[1] = byte(c.g), p[2] = byte(c.b);
  }
  int width_ = 0, height_ = 0;
  mjtByte* rgb_ = nullptr;
};

std::uint32_t hash(int x, int y, std::uint32_t salt) {
  std::uint32_t h =
      static_cast<std::uint32_t>(x) * 0x8da6b343u ^ static_cast<std::uint32_t>(y) * 0xd8163841u ^ salt * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return h ^ (h >> 15);
}
double unit(std::uint32_t h) { return static_cast<double>(h & 0xffffff) / 16777216.0; }

/// Smooth noise in 0..1 for pixels 0..period-1, with cells of the given size (a power of two); repeats at the edges.
class Grain {
 public:
  Grain(int cell, int period, std::uint32_t salt) : cell_(cell), row_(period / cell + 1) {
    const int n = period / cell;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) lattice_.push_back(unit(hash(i % n, j % n, salt)));
    for (int i = 0; i < cell; ++i) {
      const double t = static_cast<double>(i) / cell;
      ease_.push_back(t * t * (3 - 2 * t));
    }
  }
  double operator()(int x, int y) const {
    const auto ux = static_cast<unsigned>(x), uy = static_cast<unsigned>(y), cell = static_cast<unsigned>(cell_);
    const int shift = std::countr_zero(cell);
    const double* at =
        &lattice_[static_cast<std::size_t>(uy >> shift) * static_cast<std::size_t>(row_) + (ux >> shift)];
    const double u = ease_[ux & (cell - 1)], v = ease_[uy & (cell - 1)];
    const double low = at[0] + u * (at[1] - at[0]), high = at[row_] + u * (at[row_ + 1] - at[row_]);
    return low + v * (high - low);
  }

 private:
  int cell_, row_;
  std::vector<double> lattice_, ease_;
};

/// Stone chips scattered over a square, one at most per cell of a grid. For each pixel: the chip that covers it best,
/// and how deep (0..1) the pixel lies in it. Repeats at the edges. Knows some rows at a time, since fresh memory for
/// the whole square would take longer than its chips.
class Chips {
 public:
  Chips(int size, int cell, std::uint32_t salt) : size_(size), cell_(cell), salt_(salt) {}

  void set_rows(int begin, int end) {
    begin_ = begin;
    end_ = end;
    depth_.assign(row(end), 0);
    id_.assign(row(end), 0);
    for (int y = 0; y < size_; y += cell_)
      for (int x = 0; x < size_; x += cell_) scatter(x, y, hash(x / cell_, y / cell_, salt_));
  }
  double depth(int x, int y) const { return depth_[row(y) + static_cast<std::size_t>(x)]; }
  std::uint32_t id(int x, int y) const { return id_[row(y) + static_cast<std::size_t>(x)]; }

 private:
  std::size_t row(int y) const { return static_cast<std::size_t>(y - begin_) * static_cast<std::size_t>(size_); }
  void scatter(int x0, int y0, std::uint32_t h) {
    const int reach = cell_ / 2 + cell_ / 4 + 1;
    const double py = y0 + (0.2 + 0.6 * unit(h * 7919u)) * cell_;
    const int bottom = static_cast<int>(py) - reach, top = static_cast<int>(py) + reach;
    // The rows may lie among those of the square below or above.
    if (!overlap(bottom, top) && !overlap(bottom + size_, top + size_) && !overlap(bottom - size_, top - size_)) return;
    const double px = x0 + (0.2 + 0.6 * unit(h)) * cell_;
    const double radius = cell_ * (0.18 + 0.34 * unit(h * 104729u)), slant = unit(h * 1299709u) - 0.5;
    for (int y = bottom; y <= top; ++y) {
      const int on_canvas = (y + size_) % size_;
      if (on_canvas < begin_ || on_canvas >= end_) continue;
      for (int x = static_cast<int>(px) - reach; x <= static_cast<int>(px) + reach; ++x) {
        // Corners instead of circles: the largest of three slanted distances is a rough hexagon.
        const double dx = x + 0.5 - px, dy = y + 0.5 - py;
        const double a = std::fabs(dx + slant * dy), b = std::fabs(0.5 * dx + 0.87 * dy),
                     c = std::fabs(0.5 * dx - 0.87 * dy);
        const double depth = 1.0 - std::max({a, b, c}) / radius;
        const std::size_t i = row(on_canvas) + static_cast<std::size_t>((x + size_) % size_);
        if (depth <= depth_[i]) continue;
        depth_[i] = depth;
        id_[i] = h;
      }
    }
  }
  bool overlap(int bottom, int top) const { return bottom < end_ && top >= begin_; }

  int size_, cell_;
  std::uint32_t salt_;
  int begin_ = 0, end_ = 0;
  std::vector<double> depth_;
  std::vector<std::uint32_t> id_;
};

constexpr Rgb kStones[] = {{232, 229, 220}, {96, 102, 110},  {150, 158, 160}, {62, 70, 82},
                           {178, 174, 160}, {112, 128, 124}, {206, 206, 202}, {82, 96, 116}};

Rgb stone(std::uint32_t id) { return shade(kStones[(id >> 8) % 8], 0.9 + 0.2 * unit(id * 31u)); }

/// Terrazzo in slabs of one metre: contrast at every scale that a camera between 0.1 and 3 m sees. 4 m a side.
void paint_floor(Canvas canvas) {
  const int size = canvas.width(), slab = size / 4;
  const Grain coarse(64, size, 21), middle(16, size, 22), fine(4, size, 23);
  Chips layers[] = {{size, 32, 132}, {size, 16, 116}, {size, 8, 108}};  // of 13, 6 and 3 cm
  const auto colour = [&](int x, int y) {
    const std::uint32_t tile = hash(x / slab, y / slab, 11);
    const double clouds = 0.5 * coarse(x, y) + 0.3 * middle(x, y) + 0.2 * fine(x, y);
    Rgb c = shade({158, 155, 148}, 0.80 + 0.14 * unit(tile) + 0.24 * clouds);
    for (const Chips& chips : layers) {
      const std::uint32_t id = chips.id(x, y);
      const bool present = unit(id * 65537u) < (&chips == layers ? 0.45 : 0.7);
      if (present && chips.depth(x, y) > 0) c = mix(c, stone(id), 8.0 * chips.depth(x, y));
    }
    const int jx = x % slab, jy = y % slab, joint = std::min({jx, jy, slab - 1 - jx, slab - 1 - jy});
    return joint < 1 ? Rgb{70, 70, 72} : c;
  };
  constexpr int kRows = 64;
  for (int begin = 0; begin < canvas.height(); begin += kRows) {
    const int end = std::min(begin + kRows, canvas.height());
    for (Chips& chips : layers) chips.set_rows(begin, end);
    canvas.fill_rows(begin, end, colour);
  }
}

/// Wainscot, rail, plaster and two windows on eight by four metres.
Rgb wall_colour(double x_m, double y_m, double plaster, const Grain& hills) {
  const Rgb paint = shade({226, 224, 215}, 0.94 + 0.08 * plaster);
  if (y_m < 0.08) return {52, 56, 62};
  if (y_m < 1.0) {
    const double groove = x_m * 4 - std::floor(x_m * 4);
    return shade({92, 112, 126}, (groove < 0.04 ? 0.72 : 0.96) + 0.08 * plaster);
  }
  if (y_m < 1.06) return {236, 236, 232};
  for (const double centre : {2.2, 5.8}) {
    const double dx = std::fabs(x_m - centre), dy = std::fabs(y_m - 2.3);
    if (dx > 1.12 || dy > 0.82) continue;
    const bool frame = dx > 1.05 || dy > 0.75 || dx < 0.03 || std::fabs(y_m - 2.6) < 0.025;
    if (frame) return {244, 244, 242};
    const double up = (y_m - 1.55) / 1.5;
    const double hill = 0.16 + 0.10 * hills(static_cast<int>(x_m * 64), 7);
    if (up < hill) return shade({112, 140, 108}, 0.8 + 0.4 * plaster);
    return mix({222, 234, 242}, {140, 184, 226}, up);
  }
  return paint;
}

void paint_wall(Canvas canvas) {
  const double per_m = canvas.width() / 8.0;
  const Grain fine(4, 1024, 31), coarse(32, 1024, 32), hills(32, 512, 41);
  canvas.fill(
      [&](int x, int y) { return wall_colour(x / per_m, y / per_m, 0.6 * fine(x, y) + 0.4 * coarse(x, y), hills); });
}

/// Covers an edge of about one pixel: 1 inside, 0 outside.
double inside(double distance_px) { return std::clamp(0.5 - distance_px, 0.0, 1.0); }

/// The pad, 0.8 m a side: an orange disc of 0.30 m radius on a dark mat, with a white ring and an H inside. Everything
/// has its centroid in the centre.
void paint_pad(Canvas canvas) {
  const double per_m = canvas.width() / 0.8, middle = 0.5 * canvas.width();
  const Grain fibre(4, 512, 51);
  canvas.fill([&](int x, int y) {
    const double dx = x + 0.5 - middle, dy = y + 0.5 - middle, r = std::sqrt(dx * dx + dy * dy);
    const double grain = fibre(x, y);
    const Rgb white = shade({240, 240, 238}, 0.97 + 0.03 * grain);
    Rgb c = shade({44, 46, 52}, 0.85 + 0.3 * grain);
    c = mix(c, white, inside(std::fabs(std::max(std::fabs(dx), std::fabs(dy)) - 0.375 * per_m) - 0.006 * per_m));
    c = mix(c, shade({245, 66, 12}, 0.96 + 0.06 * grain), inside(r - 0.30 * per_m));
    c = mix(c, white, inside(std::fabs(r - 0.155 * per_m) - 0.011 * per_m));
    const double post =
        std::max(std::fabs(std::fabs(dx) - 0.045 * per_m) - 0.011 * per_m, std::fabs(dy) - 0.085 * per_m);
    const double bar = std::max(std::fabs(dx) - 0.045 * per_m, std::fabs(dy) - 0.011 * per_m);
    return mix(c, white, inside(std::min(post, bar)));
  });
}

/// Grass, soil and stones, 16 m a side: patches of strong and of weak contrast, from metres down to a hand.
void paint_meadow(Canvas canvas) {
  const int size = canvas.width();
  const Grain patches(256, size, 81), clumps(64, size, 82), tufts(16, size, 83), blades(4, size, 84),
      bare(128, size, 85);
  canvas.fill([&](int x, int y) {
    const double rough = 0.35 + 0.65 * patches(x, y);  // of the contrast
    const double grain = 0.25 * clumps(x, y) + 0.45 * tufts(x, y) + 0.3 * blades(x, y) - 0.5;
    const Rgb grass = shade({98, 120, 62}, 1.0 + 1.9 * rough * grain);
    const Rgb soil = shade({150, 122, 88}, 1.0 + 1.3 * rough * grain);
    return mix(grass, soil, 6 * (bare(x, y) - 0.5) + 0.5);
  });
}

/// Gravel on roofs and ramps, 16 m a side: darker and of less contrast than the floor, with a joint every 2 m.
void paint_roofs(Canvas canvas) {
  const int size = canvas.width(), slab = size / 8;
  const Grain stains(64, size, 91), stones(8, size, 92), grit(2, size, 93);
  canvas.fill([&](int x, int y) {
    const double tile = unit(hash(x / slab, y / slab, 94));
    const double grain = 0.35 * stains(x, y) + 0.45 * stones(x, y) + 0.2 * grit(x, y) - 0.5;
    const int jx = x % slab, jy = y % slab;
    if (std::min(jx, jy) < 2) return Rgb{58, 56, 54};
    return shade({128, 118, 108}, 0.85 + 0.2 * tile + 0.9 * grain);
  });
}

/// A wall of a tall building, 16 m a side: five floors with windows, some of them lit, and no two bays alike.
void paint_facade(Canvas canvas) {
  const int size = canvas.width(), floor = size / 5, bay = size / 8;
  const Grain stains(64, size, 101), grit(4, size, 102);
  canvas.fill([&](int x, int y) {
    const int bx = x % bay, by = y % floor;
    const double grain = 0.6 * stains(x, y) + 0.4 * grit(x, y) - 0.5;
    const bool window = bx > bay / 5 && bx < bay - bay / 5 && by > floor * 3 / 10 && by < floor * 8 / 10;
    const bool frame = window && (bx < bay / 5 + 3 || bx > bay - bay / 5 - 3 || by < floor * 3 / 10 + 3 ||
                                  by > floor * 8 / 10 - 3 || std::abs(bx - bay / 2) < 2);
    if (frame) return Rgb{226, 224, 218};
    const double pane = unit(hash(x / bay, y / floor, 103));
    if (window && pane > 0.8) return shade({236, 206, 138}, 0.9 + 0.2 * grain);
    if (window) return shade({62, 84, 104}, 0.75 + 0.5 * pane + 0.4 * by / floor);
    if (by < 4) return shade({120, 114, 108}, 1 + 0.4 * grain);
    return shade({178, 168, 154}, 1 + 0.5 * grain);
  });
}

void paint_rug(Canvas canvas) {
  const Grain yarn(2, 256, 61);
  canvas.fill([&](int x, int y) {
    const double weave = 0.85 + 0.3 * yarn(x, y);
    const int edge = std::min({x, y, 255 - x, 255 - y});
    if (edge < 10) return shade({224, 220, 206}, weave);
    const int zig = (x + std::abs(y % 32 - 16)) % 48;
    Rgb yarn_colour{64, 132, 140};
    if (zig < 28) yarn_colour = {214, 212, 200};
    if (zig < 16) yarn_colour = {38, 72, 118};
    return shade(yarn_colour, weave);
  });
}

/// Six faces below each other, all alike: a grey transport box with a frame and a band.
void paint_crate(Canvas canvas) {
  const int n = canvas.width();
  const Grain scratches(8, n, 71);
  canvas.fill([&](int x, int y) {
    const int v = y % n, edge = std::min({x, v, n - 1 - x, n - 1 - v});
    const double wear = 0.9 + 0.2 * scratches(x, v);
    if (edge < 12) return shade({96, 104, 112}, edge < 2 ? 0.6 : wear);
    if (std::abs(v - n / 2) < 10) return shade({52, 128, 138}, wear);
    return shade({150, 154, 156}, (x / 6 % 2 ? 0.94 : 1.0) * wear);
  });
}

}  // namespace

void paint_room(mjModel_& model) {
  const auto paint = [&](const char* name, void (*with)(Canvas)) {
    if (mj_name2id(&model, mjOBJ_TEXTURE, name) >= 0) with({model, name});
  };
  paint("floor", paint_floor);
  paint("wall", paint_wall);
  paint("pad", paint_pad);
  paint("rug", paint_rug);
  paint("meadow", paint_meadow);
  paint("roofs", paint_roofs);
  paint("crate", paint_crate);
  paint("facade", paint_facade);
}

}  // namespace sinew::plant
