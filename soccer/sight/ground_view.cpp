#include "soccer/sight/ground_view.hpp"

#include <algorithm>

namespace sinew::soccer {

using math::Vec3;

GroundView::GroundView(const vision::Pinhole& camera, const msg::CameraPose& pose, const RobotAt& robot,
                       const ViewErrors& errors)
    : camera_(camera), errors_(errors) {
  const math::SinCos t = math::sincos(robot.heading_rad);
  const Vec3 way{pose.p_world_m.x - robot.x_m, pose.p_world_m.y - robot.y_m, pose.p_world_m.z};
  at_ = {t.cos * way.x + t.sin * way.y, t.cos * way.y - t.sin * way.x, way.z};
  const math::Mat3 back{t.cos, t.sin, 0, -t.sin, t.cos, 0, 0, 0, 1};
  turn_ = back * math::Quat(pose.q_world_optical).matrix();
  upright_ = math::is_finite(at_) && at_.z > 0.05 && turn_(2, 1) < -0.15 && math::fabs(turn_(2, 0)) < 0.6;
}

std::optional<GroundXy> GroundView::at_height(double u_px, double v_px, double z_m) const {
  const double a = (u_px - camera_.cx_px) / camera_.fx_px, b = (v_px - camera_.cy_px) / camera_.fy_px;
  const double down = -(turn_(2, 0) * a + turn_(2, 1) * b + turn_(2, 2));
  const double above = at_.z - z_m;
  if (!(down > 0) || !(above > 0)) return {};
  const double s = above / down;
  const double x = s * (turn_(0, 0) * a + turn_(0, 1) * b + turn_(0, 2));
  const double y = s * (turn_(1, 0) * a + turn_(1, 1) * b + turn_(1, 2));
  if (!(x * x + y * y < kFarthest_m * kFarthest_m)) return {};
  return GroundXy{at_.x + x, at_.y + y};
}

PixelAt GroundView::pixel(const Vec3& p) const {
  const Vec3 way = p - at_;
  const double x = turn_(0, 0) * way.x + turn_(1, 0) * way.y + turn_(2, 0) * way.z;
  const double y = turn_(0, 1) * way.x + turn_(1, 1) * way.y + turn_(2, 1) * way.z;
  const double z = turn_(0, 2) * way.x + turn_(1, 2) * way.y + turn_(2, 2) * way.z;
  if (!(z > 1e-3)) return {0, 0, 0};
  return {camera_.cx_px + camera_.fx_px * x / z, camera_.cy_px + camera_.fy_px * y / z, z};
}

double GroundView::horizon_px(double u_px) const {
  const double a = (u_px - camera_.cx_px) / camera_.fx_px;
  return camera_.cy_px - camera_.fy_px * (turn_(2, 0) * a + turn_(2, 2)) / turn_(2, 1);
}

std::optional<double> GroundView::ball_radius_px(double u_px, double v_px, double radius_m) const {
  const auto p = at_height(u_px, v_px, radius_m);
  if (!p) return {};
  const Vec3 way{p->x_m - at_.x, p->y_m - at_.y, radius_m - at_.z};
  const double square = math::squared_norm(way) - radius_m * radius_m;
  if (!(square > 0)) return {};
  return camera_.fx_px * radius_m / math::sqrt(square);
}

msg::GroundPoint GroundView::with_covariance(const GroundXy& p, double pixel_px, double z_m) const {
  const double x = p.x_m - at_.x, y = p.y_m - at_.y, h = std::max(0.02, at_.z - z_m);
  const double d2 = x * x + y * y, far2 = d2 + h * h;
  const double of_pixel = pixel_px / camera_.fx_px;
  const double along = far2 * far2 / (h * h) * (errors_.tilt_rad * errors_.tilt_rad + of_pixel * of_pixel);
  const double across = far2 * (errors_.heading_rad * errors_.heading_rad + of_pixel * of_pixel);
  const double d = math::sqrt(d2);
  const double c = d > 1e-9 ? x / d : 1, s = d > 1e-9 ? y / d : 0;
  msg::GroundPoint out;
  out.x_m = static_cast<float>(p.x_m), out.y_m = static_cast<float>(p.y_m);
  out.xx_m2 = static_cast<float>(along * c * c + across * s * s);
  out.xy_m2 = static_cast<float>((along - across) * c * s);
  out.yy_m2 = static_cast<float>(along * s * s + across * c * c);
  return out;
}

}  // namespace sinew::soccer
