#include "vision/circle_fit.hpp"

#include "math/elementary.hpp"

namespace sinew::vision {
namespace {

/// Mean products of the centred points; z = x^2 + y^2.
struct Moments {
  double xx = 0, yy = 0, xy = 0, xz = 0, yz = 0, zz = 0;
};

Moments moments(std::span<const PointPx> points, PointPx mean) {
  Moments m;
  for (const PointPx& p : points) {
    const double x = p.x - mean.x, y = p.y - mean.y, z = x * x + y * y;
    m.xx += x * x, m.yy += y * y, m.xy += x * y, m.xz += x * z, m.yz += y * z, m.zz += z * z;
  }
  const double n = static_cast<double>(points.size());
  m.xx /= n, m.yy /= n, m.xy /= n, m.xz /= n, m.yz /= n, m.zz /= n;
  return m;
}

/// Smallest root of Taubin's characteristic polynomial; from zero Newton's steps approach it from below.
double smallest_root(const Moments& m) {
  const double mz = m.xx + m.yy, cov = m.xx * m.yy - m.xy * m.xy, var_z = m.zz - mz * mz;
  const double a3 = 4 * mz, a2 = -3 * mz * mz - m.zz;
  const double a1 = var_z * mz + 4 * cov * mz - m.xz * m.xz - m.yz * m.yz;
  const double a0 = m.xz * (m.xz * m.yy - m.yz * m.xy) + m.yz * (m.yz * m.xx - m.xz * m.xy) - var_z * cov;
  double x = 0, y = a0;
  for (int i = 0; i < 30; ++i) {
    const double slope = a1 + x * (2 * a2 + 3 * a3 * x);
    const double next = x - y / slope;
    if (!math::is_finite(next) || next == x) break;
    const double y_next = a0 + next * (a1 + next * (a2 + next * a3));
    if (math::fabs(y_next) >= math::fabs(y)) break;
    x = next, y = y_next;
  }
  return x;
}

}  // namespace

Circle fit_circle(std::span<const PointPx> points) {
  Circle c;
  if (points.size() < 3) return c;
  PointPx mean;
  for (const PointPx& p : points) mean.x += p.x, mean.y += p.y;
  const double n = static_cast<double>(points.size());
  mean.x /= n, mean.y /= n;
  const Moments m = moments(points, mean);
  const double t = smallest_root(m), mz = m.xx + m.yy;
  const double det = t * t - t * mz + m.xx * m.yy - m.xy * m.xy;
  const double x = (m.xz * (m.yy - t) - m.yz * m.xy) / det / 2;
  const double y = (m.yz * (m.xx - t) - m.xz * m.xy) / det / 2;
  c.radius = math::sqrt(x * x + y * y + mz);
  c.x = x + mean.x, c.y = y + mean.y;
  if (!math::is_finite(c.radius) || c.radius > 1e6) return c;
  double square = 0;
  for (const PointPx& p : points) {
    const double dx = p.x - c.x, dy = p.y - c.y, d = math::sqrt(dx * dx + dy * dy) - c.radius;
    square += d * d;
  }
  c.rms = math::sqrt(square / n);
  c.valid = true;
  return c;
}

Outline fit_outline(std::span<PointPx> points, const StrayLimits& limits) {
  Outline outline{.circle = {}, .points = points.size()};
  for (int round = 0; round < 3; ++round) {
    if (outline.points < limits.min_points) return {.circle = {}, .points = outline.points};
    const Circle& c = outline.circle = fit_circle(points.first(outline.points));
    if (!c.valid) break;
    const double limit = c.rms < limits.smooth_rms_px ? limits.smooth_px : limits.factor * c.rms;
    std::size_t kept = 0;
    for (const PointPx& p : points.first(outline.points)) {
      const double dx = p.x - c.x, dy = p.y - c.y;
      if (math::fabs(math::sqrt(dx * dx + dy * dy) - c.radius) <= limit) points[kept++] = p;
    }
    if (kept == outline.points) break;
    outline.points = kept;
  }
  return outline;
}

}  // namespace sinew::vision
