#include "sim_hil/simspark/agent.hpp"

#include <algorithm>

#include "sim_hil/simspark/field.hpp"
#include "sim_hil/simspark/frame.hpp"
#include "sim_hil/simspark/vision.hpp"

namespace sinew::simspark {

using math::Vec3;
using wire::SparkError;
using wire::SparkSeen;

SparkAgent::SparkAgent(const SparkJointMap& map, const kinematics::Body& body)
    : map_(map), sole_(plant::soles_of(body)) {}

SparkError SparkAgent::take(std::string_view text) {
  if (const SparkError error = parse_spark_percepts(text, percepts_); error != SparkError::none) return error;
  const wire::SparkPercepts& p = percepts_;
  said_.play_mode = p.play_mode;
  if (!p.side.empty()) said_.side = p.side;
  if (p.number > 0) said_.number = p.number;
  said_.left_goals = static_cast<int>(p.left_goals);
  said_.right_goals = static_cast<int>(p.right_goals);
  said_.game_s = p.game_s;
  const double dt = p.now_s - felt_.now_s;
  felt_.now_s = p.now_s;
  if (p.has_gyro) felt_.gyro_radps = from_spark({p.gyro_dps[0], p.gyro_dps[1], p.gyro_dps[2]}) / kDegrees;
  if (p.has_acceleration)
    felt_.accel_mps2 = from_spark({p.acceleration_mps2[0], p.acceleration_mps2[1], p.acceleration_mps2[2]});
  if (p.joints > 0) ++felt_.cycles;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const wire::SparkJoint* joint = p.find_joint(spark_joints()[j].perceptor);
    if (!joint) continue;
    const double rad = map_.sign(j) * joint->degrees / kDegrees;
    double& now = felt_.joints_rad[map_.joint(j)];
    felt_.joints_radps[map_.joint(j)] = felt_.cycles > 1 && dt > 0 ? (rad - now) / dt : 0;
    now = rad;
  }
  felt_.cell_n = {};
  for (const wire::SparkForce& f : std::span(p.force).first(p.forces)) {
    const std::size_t side = f.name == "lf" ? 0 : 1;
    if ((f.name != "lf" && f.name != "rf") || !sole_[side]) continue;
    const Vec3 at = from_spark({f.center_m[0], f.center_m[1], f.center_m[2]});
    const auto shares = plant::cell_shares(*sole_[side], at);
    for (std::size_t k = 0; k < shares.size(); ++k) felt_.cell_n[side][k] = std::max(0.0, f.force_n[2]) * shares[k];
  }
  if (!p.has_see) return SparkError::none;
  sights_ = {};
  sights_.at_s = p.now_s;
  for (const SparkSeen& seen : std::span(p.seen).first(p.sightings)) {
    if (seen.kind == SparkSeen::Kind::ball) sights_.ball_m = point_of(seen.at);
    if (seen.kind != SparkSeen::Kind::landmark) continue;
    const auto mark = std::ranges::find(kLandmarks, seen.name, &Landmark::name);
    if (mark != kLandmarks.end())
      sights_.landmark_m[static_cast<std::size_t>(mark - kLandmarks.begin())] = point_of(seen.at);
  }
  return SparkError::none;
}

wire::SparkWriter& SparkAgent::command(std::span<const double> targets_rad, wire::SparkWriter& out) const {
  for (std::size_t j = 0; j < kJoints; ++j) {
    const std::size_t joint = map_.joint(j);
    const double target = joint < targets_rad.size() ? targets_rad[joint] : math::kNan;
    const double speed =
        math::is_finite(target) ? map_.sign(j) * kFollow_per_s * (target - felt_.joints_rad[joint]) : 0.0;
    out.effector(spark_joints()[j].effector, std::clamp(speed, -kMostSpeed_radps, kMostSpeed_radps));
  }
  return out;
}

std::optional<Vec3> place_of(const Sights& sights, double eye_height_m, const Vec3& guess_m) {
  constexpr int kMostSteps = 20;
  constexpr double kEnough_m = 1e-4, kFlat = 1e-6;
  Vec3 at = guess_m;
  for (int step = 0; step < kMostSteps; ++step) {
    double xx = 0, xy = 0, yy = 0, bx = 0, by = 0;
    int marks = 0;
    for (std::size_t i = 0; i < kLandmarks.size(); ++i) {
      if (!sights.landmark_m[i]) continue;
      ++marks;
      const Vec3& mark = kLandmarks[i].at_m;
      const double rise = mark.z - eye_height_m, far = norm(*sights.landmark_m[i]);
      const double flat = math::sqrt(std::max(0.0, far * far - rise * rise));
      const double dx = at.x - mark.x, dy = at.y - mark.y, distance = std::max(1e-3, math::hypot(dx, dy));
      const double ux = dx / distance, uy = dy / distance, error = flat - distance;
      xx += ux * ux, xy += ux * uy, yy += uy * uy, bx += ux * error, by += uy * error;
    }
    const double det = xx * yy - xy * xy;
    if (marks < 2 || det < kFlat) return std::nullopt;
    const double sx = (yy * bx - xy * by) / det, sy = (xx * by - xy * bx) / det;
    at.x += sx, at.y += sy;
    if (math::hypot(sx, sy) < kEnough_m) return at;
  }
  return std::nullopt;
}

}  // namespace sinew::simspark
