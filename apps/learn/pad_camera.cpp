#include "apps/learn/pad_camera.hpp"

#include "robots/quad/devices.hpp"
#include "robots/quad/world/vehicle.hpp"

namespace sinew::learning {
namespace {

constexpr double kRing_m = 0.144;     // inner edge of the bright ring (vision::PadLook)
constexpr int kPoints = 24;           // looked at on each circle
constexpr double kLeastShare = 0.22;  // of a circle that the detector needs

math::Vec3 in_camera(const plant::CameraPose& camera, const math::Vec3& p_world_m) {
  return math::Quat(camera.q_world_optical).conjugate().rotate(p_world_m - math::Vec3(camera.p_world_m));
}

}  // namespace

double PadCamera::seen_share(const plant::CameraPose& camera, double radius_m) const {
  const double half_x = 0.5 * params_.width_px, half_y = 0.5 * params_.height_px;
  const double focal_px = plant::kFocalPerHeight * params_.height_px;
  int seen = 0;
  for (int i = 0; i < kPoints; ++i) {
    const math::SinCos turn = math::sincos(2 * math::kPi * i / kPoints);
    const math::Vec3 p = in_camera(camera, {radius_m * turn.cos, radius_m * turn.sin, 0});
    if (p.z > 0.01 && math::fabs(p.x / p.z * focal_px) < half_x && math::fabs(p.y / p.z * focal_px) < half_y) ++seen;
  }
  return double(seen) / kPoints;
}

msg::PadSighting PadCamera::look(const plant::CameraPose& camera, msg::Time stamp) {
  msg::PadSighting out;
  out.stamp = stamp;
  out.range_m = math::kNan;
  const double errors[3] = {noise_.normal(), noise_.normal(), noise_.normal()};  // as many, whatever is in sight
  const math::Vec3 p = in_camera(camera, {});
  const double edge = seen_share(camera, plant::kPadRadius), ring = seen_share(camera, kRing_m);
  if (!(p.z > 0.03) || (edge < kLeastShare && ring < kLeastShare)) return out;
  const double focal_px = plant::kFocalPerHeight * params_.height_px, radius_px = focal_px * plant::kPadRadius / p.z;
  const double spread_px = params_.centre_px + params_.centre_share * radius_px;
  const double x = p.x / p.z + errors[0] * spread_px / focal_px, y = p.y / p.z + errors[1] * spread_px / focal_px;
  const double n = math::sqrt(x * x + y * y + 1);
  out.found = 1;
  out.blobs = 1;
  out.u_px = x * focal_px + 0.5 * (params_.width_px - 1);
  out.v_px = y * focal_px + 0.5 * (params_.height_px - 1);
  out.radius_px = radius_px * (1 + params_.size_share * errors[2]) + params_.size_px;
  out.direction_optical = {x / n, y / n, 1 / n};
  out.range_m = focal_px * plant::kPadRadius / out.radius_px * n;
  out.confidence = 0.9;
  return out;
}

msg::Duration PadCamera::delay() const {
  return msg::Duration{plant::kCameraDelayNs + static_cast<std::int64_t>(params_.late_ms * 1e6)};
}

}  // namespace sinew::learning
