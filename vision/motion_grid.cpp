#include "vision/motion_grid.hpp"

#include "math/elementary.hpp"

namespace sinew::vision {
namespace {

/// Products of neighbours on one border of a cell. p, q: the pixels on either side of the border.
struct BorderSums {
  std::int64_t correlator = 0;  // of the pair across the border
  std::int64_t product = 0;     // newer p * q - older p * q
  std::int64_t gradient = 0;    // p + q of both frames

  void add(int p1, int q1, int p2, int q2) {
    correlator += p2 * q1 - p1 * q2;
    product += p2 * q2 - p1 * q1;
    gradient += p1 + q1 + p2 + q2;
  }
};

BorderSums column(const ImageView& older, const ImageView& newer, std::uint32_t x, std::uint32_t y0, std::uint32_t y1) {
  BorderSums s;
  for (std::uint32_t y = y0; y < y1; ++y) {
    const std::uint8_t *a = older.row(y) + x, *b = newer.row(y) + x;
    s.add(a[0], a[1], b[0], b[1]);
  }
  return s;
}

BorderSums row(const ImageView& older, const ImageView& newer, std::uint32_t y, std::uint32_t x0, std::uint32_t x1) {
  BorderSums s;
  const std::uint8_t *a = older.row(y), *b = newer.row(y), *a_next = older.row(y + 1), *b_next = newer.row(y + 1);
  for (std::uint32_t x = x0; x < x1; ++x) s.add(a[x], a_next[x], b[x], b_next[x]);
  return s;
}

struct Vector2 {
  double x = 0, y = 0;
};

/// (G + ridge) d = -4 t. The ridge keeps d finite along edges and small where there is only noise.
Vector2 solve(const CellMotion& m, double ridge) {
  const double a = m.gxx + ridge, b = m.gxy, c = m.gyy + ridge, det = a * c - b * b;
  if (!(det > 0)) return {};
  return {-4 * (c * m.tx - b * m.ty) / det, -4 * (a * m.ty - b * m.tx) / det};
}

}  // namespace

namespace detail {

CellMotion cell_motion(const ImageView& older, const ImageView& newer, const PixelRect& r, Simd simd) {
  const CellSums s = correlate_cell(older, newer, r, simd);
  const BorderSums left = column(older, newer, r.x0 - 1, r.y0, r.y1),
                   right = column(older, newer, r.x1 - 1, r.y0, r.y1);
  const BorderSums top = row(older, newer, r.y0 - 1, r.x0, r.x1), bottom = row(older, newer, r.y1 - 1, r.x0, r.x1);
  const std::int64_t tx = 2 * s.mx + left.correlator - right.correlator + right.product - left.product;
  const std::int64_t ty = 2 * s.my + top.correlator - bottom.correlator + bottom.product - top.product;
  // Sums of g telescope to the borders.
  const auto gx = static_cast<double>(right.gradient - left.gradient);
  const auto gy = static_cast<double>(bottom.gradient - top.gradient);
  CellMotion m;
  m.pixels = (r.x1 - r.x0) * (r.y1 - r.y0);
  const double n = m.pixels, brighter = static_cast<double>(s.newer - s.older);
  m.tx = static_cast<double>(tx) - brighter * gx / n;
  m.ty = static_cast<double>(ty) - brighter * gy / n;
  m.gxx = static_cast<double>(s.gxx) - gx * gx / n;
  m.gxy = static_cast<double>(s.gxy) - gx * gy / n;
  m.gyy = static_cast<double>(s.gyy) - gy * gy / n;
  return m;
}

}  // namespace detail

namespace {

constexpr std::uint32_t kCells = msg::kMotionColumns * msg::kMotionRows;

PixelRect cell_rect(const ImageView& image, std::uint32_t column, std::uint32_t row) {
  const std::uint32_t w = image.width - 2, h = image.height - 2;
  return {1 + w * column / msg::kMotionColumns, 1 + h * row / msg::kMotionRows,
          1 + w * (column + 1) / msg::kMotionColumns, 1 + h * (row + 1) / msg::kMotionRows};
}

void add(const CellMotion& from, CellMotion& to) {
  to.tx += from.tx, to.ty += from.ty;
  to.gxx += from.gxx, to.gxy += from.gxy, to.gyy += from.gyy;
  to.pixels += from.pixels;
}

}  // namespace

bool estimate_motion(const ImageView& older, const ImageView& newer, const MotionOptions& options,
                     msg::MotionField& out, Simd simd) {
  if (!older || !newer || older.width != newer.width || older.height != newer.height ||
      older.width < 8 * msg::kMotionColumns || older.height < 8 * msg::kMotionRows ||
      older.width > msg::kMaxImageWidth || older.height > msg::kMaxImageHeight)
    return false;
  // g is a difference of two sums of two pixels: noise puts 4 sigma^2 per pixel into its square. newer - older has
  // 2 sigma^2 (noise_grey is the deviation of a pixel, taken as independent in either frame).
  const double g_noise = 4 * options.noise_grey * options.noise_grey;
  const double difference_noise = 1.4142135623730951 * options.noise_grey;
  CellMotion all;
  std::uint32_t textured = 0, moving = 0;
  double sum_x = 0, sum_y = 0;
  for (std::uint32_t i = 0; i < kCells; ++i) {
    const PixelRect rect = cell_rect(older, i % msg::kMotionColumns, i / msg::kMotionColumns);
    const CellMotion m = detail::cell_motion(older, newer, rect, simd);
    const double energy = m.gxx + m.gyy, noise_energy = 2 * g_noise * m.pixels;
    out.x[i] = out.y[i] = 0;
    if (energy < 3 * noise_energy) continue;  // hardly more than noise: not enough texture
    const Vector2 d = solve(m, g_noise * m.pixels);
    out.x[i] = static_cast<float>(d.x), out.y[i] = static_cast<float>(d.y);
    sum_x += d.x, sum_y += d.y;
    add(m, all);
    ++textured;
    const double speed = math::sqrt(d.x * d.x + d.y * d.y);
    const double speed_noise = 4 * difference_noise / math::sqrt(energy);
    moving += speed >= options.min_speed_px && speed >= options.significance * speed_noise;
  }
  const Vector2 d = textured > 0 ? solve(all, 0) : Vector2{};
  out.mean_x = textured > 0 ? sum_x / textured : 0;
  out.mean_y = textured > 0 ? sum_y / textured : 0;
  out.speed_x_px = d.x, out.speed_y_px = d.y;
  out.moving_fraction = textured > 0 ? static_cast<double>(moving) / textured : 0;
  out.moving = textured >= kCells / 32 && out.moving_fraction >= options.moving_fraction;
  return true;
}

bool TravelDetector::update(const msg::MotionField& field, const Options& options) {
  x_px_ += options.smoothing * (field.speed_x_px - x_px_);
  y_px_ += options.smoothing * (field.speed_y_px - y_px_);
  return field.moving != 0 && math::sqrt(x_px_ * x_px_ + y_px_ * y_px_) >= options.speed_px;
}

}  // namespace sinew::vision
