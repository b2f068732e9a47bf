#include "identify/plane_slopes.hpp"

#include "identify/homography.hpp"

namespace sinew::identify {

using kinematics::Pose;
using math::Quat;
using math::Vec3;

bool predict(const LensCamera& c, const Pose& plane, const PlanePoint& p, LensCamera::Pixel& pixel, Slopes* slopes) {
  const Vec3 turned = plane.q.rotate({p.x_m, p.y_m, 0}), at = turned + plane.p_m;
  if (!(at.z > 1e-6)) return false;
  const double x = at.x / at.z, y = at.y / at.z;
  const auto d = c.lens.distorted(x, y);
  pixel = {c.cx_px + c.fx_px * d.x, c.cy_px + c.fy_px * d.y};
  if (!slopes) return true;
  const double r2 = x * x + y * y;
  slopes->camera[0] = {
      d.x, 0, 1, 0, c.fx_px * x * r2, c.fx_px * x * r2 * r2, c.fx_px * 2 * x * y, c.fx_px * (r2 + 2 * x * x)};
  slopes->camera[1] = {
      0, d.y, 0, 1, c.fy_px * y * r2, c.fy_px * y * r2 * r2, c.fy_px * (r2 + 2 * y * y), c.fy_px * 2 * x * y};
  const auto by_xy = c.lens.derivative(x, y);
  for (int k = 0; k < 2; ++k) {
    const double f = k == 0 ? c.fx_px : c.fy_px;
    const Vec3 by_at{f * by_xy(k, 0) / at.z, f * by_xy(k, 1) / at.z, -f * (by_xy(k, 0) * x + by_xy(k, 1) * y) / at.z};
    const Vec3 by_turn = cross(turned, by_at);  // by_at . (w x turned)
    slopes->pose[k] = {by_turn.x, by_turn.y, by_turn.z, by_at.x, by_at.y, by_at.z};
  }
  return true;
}

Pose moved(const Pose& p, const double* by) {
  return {p.p_m + Vec3{by[3], by[4], by[5]}, (Quat::exp({by[0], by[1], by[2]}) * p.q).normalized()};
}

std::optional<Pose> plane_pose(const LensCamera& camera, const PlaneView& view) {
  // The start is a pinhole's, from pixels as it would have them.
  PlaneView straight = view;
  for (PlanePoint& p : straight) {
    math::LensDistortion::Xy at{(p.u_px - camera.cx_px) / camera.fx_px, (p.v_px - camera.cy_px) / camera.fy_px};
    camera.lens.straighten(at);
    p.u_px = at.x, p.v_px = at.y;
  }
  const auto h = homography(straight);
  if (!h) return std::nullopt;
  auto pose = pose_of(*h, {1, 1, 0, 0, {}});
  if (!pose) return std::nullopt;
  double lambda = 1e-3, cost = math::kInf;
  Pose before;  // and the sum of squares there
  for (int round = 0; round < 30; ++round) {
    Dense normal(6, 6);
    std::vector<double> by(6);
    double here = 0;
    for (const PlanePoint& p : view) {
      LensCamera::Pixel at;
      Slopes slopes;
      if (!predict(camera, *pose, p, at, &slopes)) return std::nullopt;
      const double e[] = {p.u_px - at.u_px, p.v_px - at.v_px};
      for (int k = 0; k < 2; ++k) {
        here += e[k] * e[k];
        for (std::size_t a = 0; a < 6; ++a) {
          by[a] += slopes.pose[k][a] * e[k];
          for (std::size_t b = 0; b < 6; ++b) normal(a, b) += slopes.pose[k][a] * slopes.pose[k][b];
        }
      }
    }
    if (here > cost) return before;
    if (cost - here < 1e-12 * here) break;
    cost = here;
    before = *pose;
    for (std::size_t a = 0; a < 6; ++a) normal(a, a) *= 1 + lambda;
    const auto step = solve_positive(normal, by);
    if (!step) return std::nullopt;
    pose = moved(*pose, step->data());
    lambda *= 0.1;
  }
  return pose;
}

}  // namespace sinew::identify
