#include "vision/ground_shift.hpp"

#include <algorithm>
#include <array>

#include "math/elementary.hpp"
#include "vision/motion_grid.hpp"

namespace sinew::vision {
namespace {

struct GreySums {
  double mean = 0, variance = 0;
};

GreySums grey_sums(const ImageView& image) {
  std::int64_t sum = 0, squares = 0;
  for (std::uint32_t y = 0; y < image.height; ++y) {
    const std::uint8_t* row = image.row(y);
    std::uint32_t row_sum = 0, row_squares = 0;
    for (std::uint32_t x = 0; x < image.width; ++x) {
      row_sum += row[x];
      row_squares += std::uint32_t{row[x]} * row[x];
    }
    sum += row_sum, squares += row_squares;
  }
  const double n = static_cast<double>(image.width) * image.height;
  const double mean = static_cast<double>(sum) / n;
  return {mean, std::max(0.0, static_cast<double>(squares) / n - mean * mean)};
}

/// Sums of the first and last column (row) over the rows (columns) that have both neighbours.
struct Ends {
  std::int64_t first = 0, last = 0;
};
Ends columns(const ImageView& image) {
  Ends ends;
  for (std::uint32_t y = 0; y + 1 < image.height; ++y) {
    ends.first += image.row(y)[0];
    ends.last += image.row(y)[image.width - 1];
  }
  return ends;
}
Ends rows(const ImageView& image) {
  Ends ends;
  for (std::uint32_t x = 0; x + 1 < image.width; ++x) {
    ends.first += image.row(0)[x];
    ends.last += image.row(image.height - 1)[x];
  }
  return ends;
}

/// Sum of b * a' - a * b' of grey values without their mean m: the terms with m telescope to the ends.
double without_mean(std::int64_t sum, double mean, const Ends& older, const Ends& newer) {
  return static_cast<double>(sum) - mean * static_cast<double>((newer.first - newer.last) - (older.first - older.last));
}

CellMotion whole_picture(const ImageView& older, const ImageView& newer) {
  CellMotion all;
  for (std::uint32_t y = 1; y < older.height - 1; y += kMaxCell)
    for (std::uint32_t x = 1; x < older.width - 1; x += kMaxCell) {
      const PixelRect rect{x, y, std::min(x + kMaxCell, older.width - 1), std::min(y + kMaxCell, older.height - 1)};
      const CellMotion cell = detail::cell_motion(older, newer, rect, best_simd());
      all.tx += cell.tx, all.ty += cell.ty;
      all.gxx += cell.gxx, all.gxy += cell.gxy, all.gyy += cell.gyy;
      all.pixels += cell.pixels;
    }
  return all;
}

/// Noise adds to the gradient's squares and nothing to the correlators: taken off, as far as something is left.
PixelShift quotient(const CellMotion& all, double noise) {
  const double a = std::max(all.gxx - noise, 0.5 * all.gxx), b = all.gxy, c = std::max(all.gyy - noise, 0.5 * all.gyy);
  const double det = a * c - b * b;
  if (!(det > 0)) return {};
  return {-4 * (c * all.tx - b * all.ty) / det, -4 * (a * all.ty - b * all.tx) / det};
}

/// The median of the quotients of 4 x 3 parts: a lone edge, such as a joint along the way, or a part of the ground at
/// another height does not decide it. Parts without texture do not count.
PixelShift median_quotient(const ImageView& older, const ImageView& newer, double noise_grey) {
  constexpr std::uint32_t kColumns = 4, kRows = 3;
  std::array<double, kColumns * kRows> x{}, y{};
  std::size_t count = 0;
  const std::uint32_t w = older.width - 2, h = older.height - 2;
  for (std::uint32_t i = 0; i < kColumns * kRows; ++i) {
    const std::uint32_t c = i % kColumns, r = i / kColumns;
    const PixelRect rect{1 + w * c / kColumns, 1 + h * r / kRows, 1 + w * (c + 1) / kColumns, 1 + h * (r + 1) / kRows};
    if (rect.x1 - rect.x0 < 2 || rect.y1 - rect.y0 < 2 || rect.x1 - rect.x0 > kMaxCell || rect.y1 - rect.y0 > kMaxCell)
      return quotient(whole_picture(older, newer), 0);
    const CellMotion m = detail::cell_motion(older, newer, rect, best_simd());
    const double noise = 4 * noise_grey * noise_grey * m.pixels;
    if (m.gxx + m.gyy < 3 * 2 * noise) continue;
    const PixelShift d = quotient(m, noise);
    x[count] = d.x_px, y[count] = d.y_px;
    ++count;
  }
  if (count == 0) return {};
  const auto median = [count](std::array<double, kColumns * kRows>& v) {
    std::sort(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(count));
    return 0.5 * (v[(count - 1) / 2] + v[count / 2]);
  };
  return {median(x), median(y)};
}

/// The part of `from` that starts at (x, y), which need not be whole, by linear interpolation.
void take_part(const ImageView& from, double x, double y, std::uint32_t width, std::uint32_t height,
               std::uint8_t* out) {
  const auto x0 = static_cast<std::uint32_t>(x), y0 = static_cast<std::uint32_t>(y);
  const auto fx = static_cast<std::uint32_t>((x - x0) * 256), fy = static_cast<std::uint32_t>((y - y0) * 256);
  for (std::uint32_t v = 0; v < height; ++v) {
    const std::uint8_t *a = from.row(y0 + v) + x0, *b = from.row(y0 + v + 1) + x0;
    for (std::uint32_t u = 0; u < width; ++u) {
      const std::uint32_t top = a[u] * (256 - fx) + a[u + 1] * fx, bottom = b[u] * (256 - fx) + b[u + 1] * fx;
      out[std::size_t{v} * width + u] = static_cast<std::uint8_t>((top * (256 - fy) + bottom * fy + 32768) >> 16);
    }
  }
}

/// What is left after both pictures have moved by half of `d` towards each other, added to it, several times.
PixelShift refined(const ImageView& older, const ImageView& newer, PixelShift d, double noise_grey,
                   std::span<std::uint8_t> scratch) {
  constexpr int kTimes = 5;
  constexpr double kTrust = 0.75;  // of what is left: a quotient is up to twice too large
  if (scratch.size() < 2 * std::size_t{older.width} * older.height) return d;
  const double most_px = 0.25 * std::min(older.width, older.height);
  for (int i = 0; i < kTimes; ++i) {
    const double far_px = std::max(math::fabs(d.x_px), math::fabs(d.y_px));
    if (!(far_px < most_px)) return d;
    const auto margin = static_cast<std::uint32_t>(0.5 * far_px) + 1;
    const std::uint32_t width = older.width - 2 * margin - 1, height = older.height - 2 * margin - 1;
    std::uint8_t *a = scratch.data(), *b = a + std::size_t{width} * height;
    take_part(older, margin - 0.5 * d.x_px, margin - 0.5 * d.y_px, width, height, a);
    take_part(newer, margin + 0.5 * d.x_px, margin + 0.5 * d.y_px, width, height, b);
    const PixelShift more = median_quotient({a, width, height, width, msg::PixelFormat::mono8},
                                            {b, width, height, width, msg::PixelFormat::mono8}, noise_grey);
    d.x_px += kTrust * more.x_px, d.y_px += kTrust * more.y_px;
  }
  return d;
}

}  // namespace

std::optional<ShiftBy> shift_by(std::string_view name) {
  if (name == "raw") return ShiftBy::raw;
  if (name == "contrast") return ShiftBy::contrast;
  if (name == "gradient") return ShiftBy::gradient;
  return std::nullopt;
}

std::optional<ShiftReading> read_shift(const ImageView& older, const ImageView& newer, ShiftBy by, double noise_grey,
                                       std::span<std::uint8_t> scratch) {
  constexpr std::uint32_t kLeast = 8;
  using msg::PixelFormat;
  if (!older || !newer || older.width != newer.width || older.height != newer.height || older.width < kLeast ||
      older.height < kLeast || older.format != PixelFormat::mono8 || newer.format != PixelFormat::mono8)
    return std::nullopt;
  const CellMotion all = whole_picture(older, newer);
  const GreySums grey = grey_sums(older);
  ShiftReading out;
  out.contrast_grey = math::sqrt(grey.variance);
  const double noise = 4 * noise_grey * noise_grey * all.pixels;  // of the gradient's square: motion_grid.cpp
  out.seen = all.gxx + all.gyy > 3 * 2 * noise;
  if (by == ShiftBy::gradient) {
    const PixelShift d = refined(older, newer, quotient(all, noise), noise_grey, scratch);
    out.x = d.x_px, out.y = d.y_px;
    return out;
  }
  const CorrelatorSums sums = correlate_sums(older, newer);
  const double pixels = static_cast<double>(older.width - 1) * (older.height - 1);
  if (by == ShiftBy::raw) {
    out.x = -static_cast<double>(sums.x) / pixels;
    out.y = -static_cast<double>(sums.y) / pixels;
    return out;
  }
  const double variance = std::max(grey.variance, noise_grey * noise_grey);
  out.x = -without_mean(sums.x, grey.mean, columns(older), columns(newer)) / (pixels * variance);
  out.y = -without_mean(sums.y, grey.mean, rows(older), rows(newer)) / (pixels * variance);
  return out;
}

PixelShift shift_of_turn(const math::Vec3& turn, double width_px, double height_px, double focal_px) {
  const double f2 = 12 * focal_px * focal_px;
  return {-focal_px * turn.y * (1 + width_px * width_px / f2), focal_px * turn.x * (1 + height_px * height_px / f2)};
}

std::uint32_t bin_for(double motion_radps, double frame_s, double focal_px, double most_px) {
  const double shift_px = motion_radps * frame_s * focal_px;
  for (std::uint32_t bin = 1; bin < 8; bin *= 2)
    if (shift_px <= most_px * bin) return bin;
  return 8;
}

}  // namespace sinew::vision
