// Joints, setpoints and trajectories.
#include <algorithm>
#include <optional>

#include "msg/actuators.hpp"
#include "msg/joints.hpp"
#include "msg/motion.hpp"
#include "msg/safety.hpp"
#include "net/ros2/pair_code.hpp"

namespace sinew::ros2::detail {
namespace {

void put_names(const Context& c, const char* path, std::size_t count) {
  Value& names = at(c, path);
  names.items.resize(count);
  for (std::size_t i = 0; i < count; ++i) names.items[i].text = c.options.joints[i];
}

std::size_t joints_of(const Context& c, std::uint32_t count) {
  return std::min({std::size_t{count}, msg::kMaxChannels, c.options.joints.size()});
}

/// For each of our joints its place among `names`.
bool places_of(const Context& c, const Value& names, std::size_t (&place)[msg::kMaxChannels]) {
  for (std::size_t i = 0; i < c.options.joints.size(); ++i) {
    const auto it = std::find_if(names.items.begin(), names.items.end(),
                                 [&](const Value& name) { return name.text == c.options.joints[i]; });
    if (it == names.items.end()) return false;
    place[i] = static_cast<std::size_t>(it - names.items.begin());
  }
  return true;
}

/// The number at this place; `missing` where the list is empty, none where it is too short or not finite.
std::optional<double> joint_number(const Value& list, std::size_t place, std::optional<double> missing) {
  if (list.items.empty()) return missing;
  return place < list.items.size() ? finite(list.items[place]) : std::nullopt;
}

}  // namespace

bool write_joints(const Context& c, const void* own) {
  const auto& joints = *static_cast<const msg::JointState*>(own);
  const std::size_t count = joints_of(c, joints.count);
  put_names(c, "name", count);
  put_numbers(at(c, "position"), joints.position_rad, count);
  put_numbers(at(c, "velocity"), joints.velocity_radps, count);
  put_numbers(at(c, "effort"), joints.effort_nm, count);
  return true;
}
template <class M>
bool write_setpoints(const Context& c, const void* own) {
  const auto& setpoints = *static_cast<const M*>(own);
  const std::size_t count = joints_of(c, setpoints.count);
  put_names(c, "name", count);
  put_numbers(at(c, "position"), setpoints.value, count);
  return true;
}
template <class M>
bool write_array(const Context& c, const void* own) {
  const auto& setpoints = *static_cast<const M*>(own);
  put_numbers(at(c, "data"), setpoints.value, std::min(std::size_t{setpoints.count}, msg::kMaxChannels));
  return true;
}
const char* read_array(const Context& c, void* own) {
  auto& command = *static_cast<msg::ActuatorCommand*>(own);
  const auto& data = at(c, "data").items;
  if (data.empty() || data.size() > msg::kMaxChannels) return "1 to 8 numbers, one for each channel";
  for (const Value& v : data) {
    const auto number = finite(v);
    if (!number) return "a number that is not finite";
    command.value[command.count++] = *number;
  }
  command.armed = 1;
  return nullptr;
}

const char* read_joints(const Context& c, void* own) {
  auto& joints = *static_cast<msg::JointState*>(own);
  std::size_t place[msg::kMaxChannels]{};
  if (!places_of(c, at(c, "name"), place)) return "a joint is missing";
  joints.count = static_cast<std::uint32_t>(c.options.joints.size());
  for (std::size_t i = 0; i < joints.count; ++i) {
    const auto position = joint_number(at(c, "position"), place[i], {}),
               velocity = joint_number(at(c, "velocity"), place[i], 0.0),
               effort = joint_number(at(c, "effort"), place[i], 0.0);
    if (!position || !velocity || !effort) return "a joint without numbers, or with one that is not finite";
    joints.position_rad[i] = *position;
    joints.velocity_radps[i] = *velocity;
    joints.effort_nm[i] = *effort;
    joints.measured[i] = joints.stamp;
    joints.mode[i] = msg::JointMode::enabled;
    joints.ready |= 1U << i;
  }
  return nullptr;
}

const char* read_trajectory(const Context& c, void* own) {
  auto& trajectory = *static_cast<msg::JointTrajectory*>(own);
  std::size_t place[msg::kMaxChannels]{};
  if (!places_of(c, at(c, "joint_names"), place)) return "a joint is missing";
  const auto& points = at(c, "points").items;
  if (points.empty() || points.size() > msg::kMaxTrajectoryPoints) return "1 to 16 points";
  trajectory.count = static_cast<std::uint32_t>(c.options.joints.size());
  std::int64_t before = -1;
  for (const Value& ros : points) {  // positions, velocities, accelerations, effort, time_from_start
    msg::TrajectoryPoint& point = trajectory.point[trajectory.points++];
    point.from_start_ns = ros.items[4].items[0].integer() * 1'000'000'000 + ros.items[4].items[1].integer();
    if (point.from_start_ns <= before) return "points whose times do not rise";
    before = point.from_start_ns;
    for (std::size_t i = 0; i < trajectory.count; ++i) {
      const auto position = joint_number(ros.items[0], place[i], {}),
                 velocity = joint_number(ros.items[1], place[i], 0.0);
      if (!position || !velocity)
        return "a point without a position for each joint, or with numbers that are not finite";
      point.position_rad[i] = *position;
      point.velocity_radps[i] = *velocity;
    }
  }
  return nullptr;
}

template bool write_setpoints<msg::ActuatorCommand>(const Context&, const void*);
template bool write_setpoints<msg::GuardianState>(const Context&, const void*);
template bool write_array<msg::ActuatorCommand>(const Context&, const void*);
template bool write_array<msg::GuardianState>(const Context&, const void*);

}  // namespace sinew::ros2::detail
