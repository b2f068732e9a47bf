#pragma once
// What the rows of the table of pairs cannot say, as code, and what it is written with. Inside of the room only.
#include <cstddef>

#include "math/linear.hpp"
#include "net/ros2/plan.hpp"

namespace sinew::ros2::detail {

/// Of what is not estimated: larger than any room, finite for filters that invert the matrix.
inline constexpr double kNoIdea = 1e6;

inline Value& at(const Context& c, std::string_view path) { return *c.ros.find(path); }

inline void put_geometry(Value& xyz, const math::Vec3& v) {
  for (int i = 0; i < 3; ++i) xyz.items[static_cast<std::size_t>(i)].set(v[i]);
}
inline void put_geometry(Value& xyzw, const math::Quat& q) {
  const double numbers[] = {q.x, q.y, q.z, q.w};
  for (std::size_t i = 0; i < 4; ++i) xyzw.items[i].set(numbers[i]);
}
inline math::Vec3 vec_of(const Value& xyz) {
  return {xyz.items[0].number(), xyz.items[1].number(), xyz.items[2].number()};
}
inline math::Quat quat_of(const Value& xyzw) {
  return {xyzw.items[3].number(), xyzw.items[0].number(), xyzw.items[1].number(), xyzw.items[2].number()};
}

/// Of length 1 to within 1 %, as ROS tools check it.
inline bool is_rotation(const math::Quat& q) {
  const double n2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return math::is_finite(n2) && n2 > 0.98 && n2 < 1.02;
}
inline constexpr const char* kNoRotation = "an orientation that is not of length 1";

/// The diagonal of a 6x6; the rest 0.
inline void put_diagonal(Value& covariance, const double (&diagonal)[6]) {
  for (Value& v : covariance.items) v.set(0);
  for (std::size_t i = 0; i < 6; ++i) covariance.items[7 * i].set(diagonal[i]);
}
template <class Numbers>
void put_numbers(Value& list, const Numbers& numbers, std::size_t count) {
  list.items.resize(count);
  for (std::size_t i = 0; i < count; ++i) list.items[i].set(numbers[i]);
}

// Of poses.
template <class M>
bool write_nav_pose(const Context& c, const void* own);
bool write_odometry(const Context& c, const void* own);
const char* read_odometry(const Context& c, void* own);
bool write_twist_stamped(const Context& c, const void* own);
bool write_covariance(const Context& c, const void* own);
const char* read_rotation(const Context& c, void* own);
const char* read_covariance(const Context& c, void* own);
bool write_tf_nav(const Context& c, const void* own);
bool write_tf_team(const Context& c, const void* own);
const char* read_tf_team(const Context& c, void* own);

// Of sensors.
bool write_range(const Context& c, const void* own);
const char* read_range(const Context& c, void* own);
bool write_battery(const Context& c, const void* own);
const char* read_battery(const Context& c, void* own);
bool write_fix(const Context& c, const void* own);
const char* read_fix(const Context& c, void* own);
const char* read_pressure(const Context& c, void* own);
const char* read_joy(const Context& c, void* own);

// Of joints.
bool write_joints(const Context& c, const void* own);
template <class M>
bool write_setpoints(const Context& c, const void* own);
template <class M>
bool write_array(const Context& c, const void* own);
const char* read_array(const Context& c, void* own);
const char* read_joints(const Context& c, void* own);
const char* read_trajectory(const Context& c, void* own);

// Of pictures.
bool write_image(const Context& c, const void* own);
const char* read_image(const Context& c, void* own);
bool write_picture(const Context& c, const void* own);
const char* read_picture(const Context& c, void* own);
bool write_camera_info(const Context& c, const void* own);
bool write_camera_model(const Context& c, const void* own);
const char* read_camera_info(const Context& c, void* own);

// Of detections.
template <class Sighting>
bool write_detection(const Context& c, const void* own);
template <class Sighting>
const char* read_detection(const Context& c, void* own);

}  // namespace sinew::ros2::detail
