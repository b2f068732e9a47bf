// Poses, velocities and transforms.
#include <optional>

#include "msg/flight.hpp"
#include "msg/team.hpp"
#include "net/ros2/pair_code.hpp"

namespace sinew::ros2::detail {
namespace {

Value& one_transform(const Context& c) {
  Value& transforms = at(c, "transforms");
  if (transforms.items.size() != 1) {
    transforms.items.resize(1);
    Message::make_default(*c.ros.type().fields[0].nested, transforms.items[0]);
  }
  return transforms.items[0];
}

void put_transform(const Context& c, std::int64_t stamp_ns, const math::Vec3& p, const math::Quat& q) {
  Value& t = one_transform(c);  // header, child_frame_id, transform
  put_time(t.items[0].items[0], stamp_ns + c.to_ros_ns);
  t.items[0].items[1].text = c.options.frame;
  t.items[1].text = c.options.child_frame;
  put_geometry(t.items[2].items[0], p);
  put_geometry(t.items[2].items[1], q);
}

}  // namespace

template <class M>
bool write_nav_pose(const Context& c, const void* own) {
  (void)c;
  return static_cast<const M*>(own)->position_valid != 0;
}

bool write_odometry(const Context& c, const void* own) {
  const auto& nav = *static_cast<const msg::NavState*>(own);
  if (nav.position_valid == 0) return false;
  const math::Quat to_base = math::Quat(nav.q_world_base).conjugate();
  put_geometry(at(c, "twist.twist.linear"), to_base.rotate(math::Vec3(nav.v_world_mps)));
  const double p2 = nav.p_std_m * nav.p_std_m, t2 = nav.tilt_std_rad * nav.tilt_std_rad,
               v2 = nav.v_std_mps * nav.v_std_mps;
  put_diagonal(at(c, "pose.covariance"), {p2, p2, kNoIdea, t2, t2, kNoIdea});
  put_diagonal(at(c, "twist.covariance"), {v2, v2, v2, kNoIdea, kNoIdea, kNoIdea});
  return true;
}

const char* read_odometry(const Context& c, void* own) {
  auto& nav = *static_cast<msg::NavState*>(own);
  const math::Quat q(nav.q_world_base);
  if (!is_rotation(q)) return kNoRotation;
  const math::Vec3 v = q.rotate(vec_of(at(c, "twist.twist.linear")));
  if (!math::is_finite(v)) return "a number that is not finite";
  nav.v_world_mps = v.to<msg::Vec3>();
  nav.height_m = nav.p_world_m.z;
  const auto std_of = [&](const char* path, double unknown) {
    const double variance = at(c, path).number();
    return variance > 0 && math::is_finite(variance) ? math::sqrt(variance) : unknown;
  };
  nav.p_std_m = std_of("pose.covariance[0]", 0);
  nav.tilt_std_rad = std_of("pose.covariance[21]", 0);
  nav.v_std_mps = std_of("twist.covariance[0]", 0);
  nav.attitude_valid = nav.height_valid = nav.position_valid = 1;
  return nullptr;
}

bool write_twist_stamped(const Context& c, const void* own) {
  const auto& nav = *static_cast<const msg::NavState*>(own);
  if (nav.position_valid == 0) return false;
  put_geometry(at(c, "twist.linear"), math::Quat(nav.q_world_base).conjugate().rotate(math::Vec3(nav.v_world_mps)));
  return true;
}

bool write_covariance(const Context& c, const void* own) {
  Value& covariance = at(c, "pose.covariance");
  for (std::size_t i = 0; i < 36; ++i) covariance.items[i].set(static_cast<const msg::TeamPose*>(own)->covariance[i]);
  return true;
}
const char* read_rotation(const Context&, void* own) {
  return is_rotation(math::Quat(static_cast<msg::TeamPose*>(own)->q_team_base)) ? nullptr : kNoRotation;
}
const char* read_covariance(const Context& c, void* own) {
  auto& pose = *static_cast<msg::TeamPose*>(own);
  const Value& covariance = at(c, "pose.covariance");
  for (std::size_t i = 0; i < 36; ++i) {
    const auto number = finite(covariance.items[i]);
    if (!number) return "a covariance that is not finite";
    pose.covariance[i] = *number;
  }
  return read_rotation(c, own);
}

bool write_tf_nav(const Context& c, const void* own) {
  const auto& nav = *static_cast<const msg::NavState*>(own);
  if (nav.position_valid == 0) return false;
  put_transform(c, nav.stamp.ns, math::Vec3(nav.p_world_m), math::Quat(nav.q_world_base));
  return true;
}
bool write_tf_team(const Context& c, const void* own) {
  const auto& pose = *static_cast<const msg::TeamPose*>(own);
  put_transform(c, pose.stamp.ns, math::Vec3(pose.p_team_m), math::Quat(pose.q_team_base));
  return true;
}
const char* read_tf_team(const Context& c, void* own) {
  auto& pose = *static_cast<msg::TeamPose*>(own);
  for (const Value& t : at(c, "transforms").items) {
    if (t.items[0].items[1].text != c.options.frame || t.items[1].text != c.options.child_frame) continue;
    const math::Vec3 p = vec_of(t.items[2].items[0]);
    const math::Quat q = quat_of(t.items[2].items[1]);
    if (!math::is_finite(p)) return "a number that is not finite";
    if (!is_rotation(q)) return kNoRotation;
    pose.p_team_m = p.to<msg::Vec3>();
    pose.q_team_base = q.to<msg::Quat>();
    pose.stamp.ns = time_of(t.items[0].items[0]).value_or(c.to_ros_ns) - c.to_ros_ns;
    return nullptr;
  }
  return kNothing;  // of other frames
}

template bool write_nav_pose<msg::NavState>(const Context&, const void*);

}  // namespace sinew::ros2::detail
