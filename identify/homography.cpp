#include "identify/homography.hpp"

#include <algorithm>

namespace sinew::identify {
namespace {

using math::Mat3;
using math::Vec3;

constexpr double kLeastSpread = 1e-7;  // second smallest to largest eigenvalue: less is points in a line

/// Moves points to their middle and scales them to a mean distance of sqrt(2).
struct Normaliser {
  double x = 0, y = 0, scale = 1;

  template <class GetX, class GetY>
  Normaliser(const PlaneView& view, const GetX& get_x, const GetY& get_y) {
    const auto n = static_cast<double>(view.size());
    for (const PlanePoint& p : view) x += get_x(p) / n, y += get_y(p) / n;
    double away = 0;
    for (const PlanePoint& p : view) away += math::hypot(get_x(p) - x, get_y(p) - y) / n;
    if (away > 0) scale = math::sqrt(2.0) / away;
  }
  Mat3 matrix() const { return {scale, 0, -scale * x, 0, scale, -scale * y, 0, 0, 1}; }
  Mat3 back() const { return {1 / scale, 0, x, 0, 1 / scale, y, 0, 0, 1}; }
};

/// Two of Zhang's rows: h_i^T B h_j = v_ij b, b = (B11, B12, B22, B13, B23, B33).
std::array<double, 6> row_of(const Mat3& h, int i, int j) {
  return {h(0, i) * h(0, j),
          h(0, i) * h(1, j) + h(1, i) * h(0, j),
          h(1, i) * h(1, j),
          h(2, i) * h(0, j) + h(0, i) * h(2, j),
          h(2, i) * h(1, j) + h(1, i) * h(2, j),
          h(2, i) * h(2, j)};
}

bool inside(const LensCamera& c, double width_px, double height_px) {
  const auto focal = [&](double f) { return f > 0.15 * width_px && f < 30 * width_px; };
  return focal(c.fx_px) && focal(c.fy_px) && c.fx_px < 2 * c.fy_px && c.fy_px < 2 * c.fx_px && c.cx_px > 0 &&
         c.cx_px < width_px && c.cy_px > 0 && c.cy_px < height_px;
}

/// Of homographies into pixels that were moved by (cx, cy) and divided by s.
std::optional<LensCamera> zhang(std::span<const Mat3> all) {
  Dense sum(6, 6);
  const auto add = [&](const std::array<double, 6>& r) {
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j < 6; ++j) sum(i, j) += r[i] * r[j];
  };
  for (const Mat3& h : all) {
    add(row_of(h, 0, 1));
    const auto a = row_of(h, 0, 0), b = row_of(h, 1, 1);
    std::array<double, 6> d;
    for (std::size_t i = 0; i < 6; ++i) d[i] = a[i] - b[i];
    add(d);
  }
  // No skew: B12 = 0.
  Dense five(5, 5);
  constexpr std::size_t kOf[] = {0, 2, 3, 4, 5};
  for (std::size_t i = 0; i < 5; ++i)
    for (std::size_t j = 0; j < 5; ++j) five(i, j) = sum(kOf[i], kOf[j]);
  const SymmetricEigen eigen = symmetric_eigen(five);
  const double sign = eigen.vectors(0, 0) < 0 ? -1 : 1;
  const double b11 = sign * eigen.vectors(0, 0), b22 = sign * eigen.vectors(1, 0), b13 = sign * eigen.vectors(2, 0),
               b23 = sign * eigen.vectors(3, 0), b33 = sign * eigen.vectors(4, 0);
  if (!(b11 > 0) || !(b22 > 0)) return std::nullopt;
  LensCamera c;
  c.cx_px = -b13 / b11, c.cy_px = -b23 / b22;
  const double scale = b33 - b13 * b13 / b11 - b23 * b23 / b22;
  if (!(scale > 0)) return std::nullopt;
  c.fx_px = math::sqrt(scale / b11), c.fy_px = math::sqrt(scale / b22);
  return c;
}

/// One focal length; the axis at 0, 0.
std::optional<double> focal(std::span<const Mat3> all) {
  double up = 0, down = 0;
  const auto add = [&](double a, double b) { up -= a * b, down += a * a; };  // a / f^2 + b = 0
  for (const Mat3& h : all) {
    add(h(0, 0) * h(0, 1) + h(1, 0) * h(1, 1), h(2, 0) * h(2, 1));
    add(h(0, 0) * h(0, 0) + h(1, 0) * h(1, 0) - h(0, 1) * h(0, 1) - h(1, 1) * h(1, 1),
        h(2, 0) * h(2, 0) - h(2, 1) * h(2, 1));
  }
  if (!(up > 0) || !(down > 0)) return std::nullopt;
  return math::sqrt(down / up);
}

}  // namespace

std::optional<Mat3> homography(const PlaneView& view) {
  if (view.size() < 4) return std::nullopt;
  const Normaliser from(
      view, [](const PlanePoint& p) { return p.x_m; }, [](const PlanePoint& p) { return p.y_m; });
  const Normaliser to(
      view, [](const PlanePoint& p) { return p.u_px; }, [](const PlanePoint& p) { return p.v_px; });
  Dense normal(9, 9);
  for (const PlanePoint& p : view) {
    const double x = from.scale * (p.x_m - from.x), y = from.scale * (p.y_m - from.y);
    const double u = to.scale * (p.u_px - to.x), v = to.scale * (p.v_px - to.y);
    const std::array<double, 9> rows[] = {{x, y, 1, 0, 0, 0, -u * x, -u * y, -u},
                                          {0, 0, 0, x, y, 1, -v * x, -v * y, -v}};
    for (const auto& r : rows)
      for (std::size_t i = 0; i < 9; ++i)
        for (std::size_t j = 0; j < 9; ++j) normal(i, j) += r[i] * r[j];
  }
  const SymmetricEigen eigen = symmetric_eigen(normal);
  if (!(eigen.values[1] > kLeastSpread * eigen.values[8])) return std::nullopt;
  Mat3 h;
  for (int i = 0; i < 9; ++i) h(i / 3, i % 3) = eigen.vectors(static_cast<std::size_t>(i), 0);
  const Mat3 whole = to.back() * h * from.matrix();
  for (const double a : whole.a)
    if (!math::is_finite(a)) return std::nullopt;
  return whole;
}

std::optional<LensCamera> closed_form_camera(std::span<const Mat3> all, double width_px, double height_px) {
  // Pixels around the middle in units of the width, so that all rows are of one size.
  const double cx = 0.5 * (width_px - 1), cy = 0.5 * (height_px - 1);
  const Mat3 to{1 / width_px, 0, -cx / width_px, 0, 1 / width_px, -cy / width_px, 0, 0, 1};
  std::vector<Mat3> scaled;
  for (const Mat3& h : all) {
    Mat3 s = to * h;
    double size = 0;
    for (int i = 0; i < 3; ++i) size += s(i, 0) * s(i, 0) + s(i, 1) * s(i, 1);
    for (double& a : s.a) a /= math::sqrt(size);
    scaled.push_back(s);
  }
  if (auto c = zhang(scaled)) {
    *c = {c->fx_px * width_px, c->fy_px * width_px, c->cx_px * width_px + cx, c->cy_px * width_px + cy, {}};
    if (inside(*c, width_px, height_px)) return c;
  }
  const auto f = focal(scaled);
  if (!f) return std::nullopt;
  const LensCamera c{*f * width_px, *f * width_px, cx, cy, {}};
  return inside(c, width_px, height_px) ? std::optional(c) : std::nullopt;
}

std::optional<kinematics::Pose> pose_of(const Mat3& h, const LensCamera& c) {
  const auto column = [&](int i) {
    return Vec3{(h(0, i) - c.cx_px * h(2, i)) / c.fx_px, (h(1, i) - c.cy_px * h(2, i)) / c.fy_px, h(2, i)};
  };
  Vec3 x = column(0), y = column(1), t = column(2);
  const double size = math::sqrt(norm(x) * norm(y));
  if (!(size > 0) || !math::is_finite(size)) return std::nullopt;
  const double s = t.z < 0 ? -1 / size : 1 / size;
  x *= s, y *= s, t *= s;
  // The nearest two normal to each other, of unit length: turned apart by the same angle.
  const Vec3 sum = math::normalized(math::normalized(x) + math::normalized(y)),
             apart = math::normalized(math::normalized(x) - math::normalized(y));
  const double r = math::sqrt(0.5);
  x = (sum + apart) * r, y = (sum - apart) * r;
  const Vec3 z = cross(x, y);
  if (!math::is_finite(t) || !math::is_finite(z) || !(t.z > 0)) return std::nullopt;
  return kinematics::Pose{t, math::Quat::from_matrix({x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z})};
}

}  // namespace sinew::identify
