// The table of translations. Units and frames are those of REP-103 and of the .msg files' comments.
// Source:  ROS REP-103 (units, axes), REP-105 (map, odom, base_link), REP-117 (ranges without an echo are +Inf),
//          REP-145 (IMU), comments of common_interfaces.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "math/linear.hpp"
#include "msg/flight.hpp"
#include "msg/head.hpp"
#include "msg/image.hpp"
#include "msg/joints.hpp"
#include "msg/motion.hpp"
#include "msg/ros2_image.hpp"
#include "msg/sensors.hpp"
#include "msg/team.hpp"
#include "net/ros2/plan.hpp"

namespace sinew::ros2::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
/// Of what is not estimated: larger than any room, finite for filters that invert the matrix.
constexpr double kNoIdea = 1e6;

constexpr Row time(std::string_view ros = "header.stamp", std::string_view own = "stamp") {
  return {What::time, ros, own};
}
constexpr Row frame(std::string_view ros = "header.frame_id") { return {What::frame, ros}; }
constexpr Row child(std::string_view ros = "child_frame_id") { return {What::child_frame, ros}; }
constexpr Row number(std::string_view ros, std::string_view own) { return {What::number, ros, own}; }
constexpr Row vector(std::string_view ros, std::string_view own) { return {What::vector, ros, own}; }
constexpr Row quat(std::string_view ros, std::string_view own) { return {What::quaternion, ros, own}; }
constexpr Row constant(std::string_view ros, double value) { return {What::constant, ros, {}, value}; }

Value& at(const Context& c, std::string_view path) { return *c.ros.find(path); }

void put(Value& xyz, const math::Vec3& v) {
  for (int i = 0; i < 3; ++i) xyz.items[static_cast<std::size_t>(i)].set(v[i]);
}
void put(Value& xyzw, const math::Quat& q) {
  const double numbers[] = {q.x, q.y, q.z, q.w};
  for (std::size_t i = 0; i < 4; ++i) xyzw.items[i].set(numbers[i]);
}
math::Vec3 vec_of(const Value& xyz) { return {xyz.items[0].number(), xyz.items[1].number(), xyz.items[2].number()}; }
math::Quat quat_of(const Value& xyzw) {
  return {xyzw.items[3].number(), xyzw.items[0].number(), xyzw.items[1].number(), xyzw.items[2].number()};
}

/// Of length 1 to within 1 %, as ROS tools check it.
bool is_rotation(const math::Quat& q) {
  const double n2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return math::is_finite(n2) && n2 > 0.98 && n2 < 1.02;
}
constexpr const char* kNoRotation = "an orientation that is not of length 1";

/// The diagonal of a 6x6; the rest 0.
void put_diagonal(Value& covariance, const double (&diagonal)[6]) {
  for (Value& v : covariance.items) v.set(0);
  for (std::size_t i = 0; i < 6; ++i) covariance.items[7 * i].set(diagonal[i]);
}

// ---- poses

template <class M>
bool write_nav_pose(const Context& c, const void* own) {
  (void)c;
  return static_cast<const M*>(own)->position_valid != 0;
}

bool write_odometry(const Context& c, const void* own) {
  const auto& nav = *static_cast<const msg::NavState*>(own);
  if (nav.position_valid == 0) return false;
  const math::Quat to_base = math::Quat(nav.q_world_base).conjugate();
  put(at(c, "twist.twist.linear"), to_base.rotate(math::Vec3(nav.v_world_mps)));
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
  put(at(c, "twist.linear"), math::Quat(nav.q_world_base).conjugate().rotate(math::Vec3(nav.v_world_mps)));
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
  put(t.items[2].items[0], p);
  put(t.items[2].items[1], q);
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

// ---- sensors

bool write_range(const Context& c, const void* own) {
  const double range = static_cast<const msg::RangeSample*>(own)->range_m;
  at(c, "field_of_view").set(c.options.field_of_view_rad);
  at(c, "min_range").set(c.options.min_m);
  at(c, "max_range").set(c.options.max_m);
  at(c, "range").set(std::isnan(range) ? kInfinity : range);
  return true;
}
const char* read_range(const Context& c, void* own) {
  const double range = at(c, "range").number();
  if (!math::is_finite(range) || range < at(c, "min_range").number() || range > at(c, "max_range").number())
    return kNothing;
  static_cast<msg::RangeSample*>(own)->range_m = range;
  return nullptr;
}

bool write_battery(const Context& c, const void* own) {
  const auto& battery = *static_cast<const msg::BatterySample*>(own);
  constexpr double kDischarging = 2, kCharging = 1, kUnknown = 0;
  at(c, "power_supply_status")
      .set_integer(static_cast<std::int64_t>(battery.current_a > 0   ? kDischarging
                                             : battery.current_a < 0 ? kCharging
                                                                     : kUnknown));
  at(c, "voltage").set(battery.voltage_v);
  at(c, "current").set(-battery.current_a);
  at(c, "percentage").set(battery.charge);
  for (const char* unknown : {"temperature", "charge", "capacity", "design_capacity"}) at(c, unknown).set(kNan);
  return true;
}
const char* read_battery(const Context& c, void* own) {
  auto& battery = *static_cast<msg::BatterySample*>(own);
  const auto voltage = finite(at(c, "voltage")), charge = finite(at(c, "percentage"));
  if (!voltage) return "voltage is not known";
  if (!charge) return "percentage is not known";
  battery.voltage_v = *voltage;
  battery.charge = *charge;
  battery.current_a = -finite(at(c, "current")).value_or(0);
  return nullptr;
}

bool write_fix(const Context& c, const void* own) {
  const auto& g = *static_cast<const msg::GnssSample*>(own);
  constexpr std::int64_t kNoFix = -1, kFix = 0, kGbas = 2, kGps = 1;
  std::int64_t status = kNoFix;
  if (g.fix == msg::GnssFix::flat || g.fix == msg::GnssFix::full) status = kFix;
  if (g.fix == msg::GnssFix::rtk_float || g.fix == msg::GnssFix::rtk_fixed) status = kGbas;
  at(c, "status.status").set_integer(status);
  at(c, "status.service").set_integer(kGps);
  at(c, "altitude").set(g.altitude_m + c.options.geoid_m);  // NaN without: the altitude is not known
  const double h2 = g.horizontal_accuracy_m * g.horizontal_accuracy_m,
               v2 = g.vertical_accuracy_m * g.vertical_accuracy_m;
  const bool known = math::is_finite(h2) && math::is_finite(v2);
  for (Value& v : at(c, "position_covariance").items) v.set(0);
  at(c, "position_covariance[0]").set(known ? h2 : 0);
  at(c, "position_covariance[4]").set(known ? h2 : 0);
  at(c, "position_covariance[8]").set(known ? v2 : 0);
  at(c, "position_covariance_type").set_integer(known ? 1 : 0);  // approximated; unknown
  return true;
}
const char* read_fix(const Context& c, void* own) {
  auto& g = *static_cast<msg::GnssSample*>(own);
  if (at(c, "status.status").integer() < 0) return kNothing;
  const auto altitude = finite(at(c, "altitude"));
  if (!altitude) return "altitude is not known";
  g.altitude_m = *altitude - c.options.geoid_m;
  g.fix = at(c, "status.status").integer() == 2 ? msg::GnssFix::rtk_float : msg::GnssFix::full;
  const bool known = at(c, "position_covariance_type").integer() != 0;
  const auto accuracy = [&](const char* path) {
    const double variance = at(c, path).number();
    return known && variance >= 0 && math::is_finite(variance) ? math::sqrt(variance) : kNoIdea;
  };
  g.horizontal_accuracy_m = accuracy("position_covariance[0]");
  g.vertical_accuracy_m = accuracy("position_covariance[8]");
  g.speed_accuracy_mps = kNoIdea;
  return nullptr;
}

constexpr double kStandardTemperatureC = 15;  // ISO 2533 at sea level
const char* read_pressure(const Context&, void* own) {
  static_cast<msg::BaroSample*>(own)->temperature_c = kStandardTemperatureC;
  return nullptr;
}

const char* read_joy(const Context& c, void* own) {
  auto& rc = *static_cast<msg::RcSample*>(own);
  const auto add = [&rc](double value) {
    if (rc.count < msg::kMaxRcChannels) rc.channel[rc.count++] = value;
  };
  for (const Value& axis : at(c, "axes").items) {
    const auto number = finite(axis);
    if (!number) return "an axis that is not finite";
    add(std::clamp(*number, -1.0, 1.0));
  }
  for (const Value& button : at(c, "buttons").items) add(button.integer() != 0 ? 1 : -1);
  rc.link_quality = 1;
  return nullptr;
}

// ---- joints

void put_names(const Context& c, const char* path, std::size_t count) {
  Value& names = at(c, path);
  names.items.resize(count);
  for (std::size_t i = 0; i < count; ++i) names.items[i].text = c.options.joints[i];
}
template <class Numbers>
void put_numbers(Value& list, const Numbers& numbers, std::size_t count) {
  list.items.resize(count);
  for (std::size_t i = 0; i < count; ++i) list.items[i].set(numbers[i]);
}
std::size_t joints_of(const Context& c, std::uint32_t count) {
  return std::min({std::size_t{count}, msg::kMaxChannels, c.options.joints.size()});
}

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

// ---- pictures

struct EncodingOf {
  msg::PixelFormat format;
  std::string_view other;  // another name for the same bytes
};
constexpr EncodingOf kEncodings[] = {{msg::PixelFormat::mono8, "8UC1"},
                                     {msg::PixelFormat::rgb8, "rgb8"},
                                     {msg::PixelFormat::bgr8, "8UC3"},
                                     {msg::PixelFormat::yuyv, "yuv422_yuy2"}};

bool write_image(const Context& c, const void* own) {
  const auto& image = *static_cast<const msg::Image*>(own);
  if (!image.is_whole(image.bulk_used())) return false;
  at(c, "encoding").text = msg::ros2_encoding(image.format);
  at(c, "data").bytes = {image.pixels(), image.bulk_used()};
  return true;
}

const char* read_image(const Context& c, void* own) {
  auto& image = *static_cast<msg::Image*>(own);
  const std::string& encoding = at(c, "encoding").text;
  const auto found = std::find_if(std::begin(kEncodings), std::end(kEncodings), [&](const EncodingOf& e) {
    return encoding == msg::ros2_encoding(e.format) || encoding == e.other;
  });
  if (found == std::end(kEncodings)) return "an encoding other than mono8, rgb8, bgr8 and yuv422_yuy2";
  const std::int64_t width = at(c, "width").integer(), height = at(c, "height").integer(),
                     step = at(c, "step").integer();
  const std::span<const std::uint8_t> data = at(c, "data").bytes;
  if (width > msg::kMaxImageWidth || height > msg::kMaxImageHeight) return "an image of more than 1280 x 960";
  if (!image.format_as(found->format, static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)))
    return "an image of no size, or larger than its topic takes";
  if (step < image.stride || static_cast<std::uint64_t>(step) * static_cast<std::uint64_t>(height) > data.size())
    return "rows that are not all there";
  for (std::uint32_t y = 0; y < image.height; ++y)
    std::memcpy(image.row(y), data.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(step), image.stride);
  return nullptr;
}

bool write_picture(const Context& c, const void*) {
  if (c.picture.empty()) return false;
  at(c, "format").text = "jpeg";
  at(c, "data").bytes = c.picture;
  return true;
}

bool write_camera_info(const Context& c, const void*) {
  const std::vector<double>& camera = c.options.camera;  // fx, fy, cx, cy
  const double fx = camera[0], fy = camera[1], cx = camera[2], cy = camera[3];
  at(c, "distortion_model").text = "plumb_bob";
  std::vector<double> d = c.options.distortion;
  d.resize(5);
  put_numbers(at(c, "d"), d, d.size());
  const double k[] = {fx, 0, cx, 0, fy, cy, 0, 0, 1}, r[] = {1, 0, 0, 0, 1, 0, 0, 0, 1},
               p[] = {fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0};
  put_numbers(at(c, "k"), k, 9);
  put_numbers(at(c, "r"), r, 9);
  put_numbers(at(c, "p"), p, 12);
  return true;
}

// ---- detections

template <class Sighting>
bool write_detection(const Context& c, const void* own) {
  const auto& seen = *static_cast<const Sighting*>(own);
  Value& detections = at(c, "detections");
  if (seen.found == 0) return detections.items.clear(), true;
  const Type& type = *c.ros.type().find("detections")->nested;
  if (detections.items.empty()) {
    detections.items.resize(1);
    Message::make_default(type, detections.items[0]);
    Value& results = *find_value(type, detections.items[0], "results");
    results.items.resize(1);
    Message::make_default(*type.find("results")->nested, results.items[0]);
  }
  Value& one = detections.items[0];
  one.items[0] = at(c, "header");
  const auto field = [&](const char* path) -> Value& { return *find_value(type, one, path); };
  field("results[0].hypothesis.class_id").text = c.options.object;
  field("results[0].hypothesis.score").set(seen.confidence);
  const bool ranged = math::is_finite(seen.range_m);
  put(field("results[0].pose.pose.position"), math::Vec3(seen.direction_optical) * (ranged ? seen.range_m : 1.0));
  put(field("results[0].pose.pose.orientation"), math::Quat());
  put_diagonal(field("results[0].pose.covariance"), {kNoIdea, kNoIdea, kNoIdea, kNoIdea, kNoIdea, kNoIdea});
  field("bbox.center.position.x").set(seen.u_px);
  field("bbox.center.position.y").set(seen.v_px);
  field("bbox.size_x").set(2 * seen.radius_px);
  field("bbox.size_y").set(2 * seen.radius_px);
  return true;
}

template <class Sighting>
const char* read_detection(const Context& c, void* own) {
  auto& seen = *static_cast<Sighting*>(own);
  const Type& type = *c.ros.type().find("detections")->nested;
  Value& detections = at(c, "detections");
  Value* best = nullptr;
  double best_score = -1;
  math::Vec3 position;
  for (Value& one : detections.items)
    for (const Value& result : find_value(type, one, "results")->items) {  // hypothesis {class_id, score}, pose
      const double score = result.items[0].items[1].number();
      if (result.items[0].items[0].text != c.options.object || !(score > best_score)) continue;
      best = &one, best_score = score;
      position = vec_of(result.items[1].items[0].items[0]);
    }
  if (!best) return nullptr;  // found = 0
  const auto number = [&](const char* path) { return find_value(type, *best, path)->number(); };
  seen.u_px = number("bbox.center.position.x");
  seen.v_px = number("bbox.center.position.y");
  seen.radius_px = (number("bbox.size_x") + number("bbox.size_y")) / 4;
  const std::vector<double>& camera = c.options.camera;
  if (math::squared_norm(position) > 0)
    seen.range_m = math::norm(position);
  else
    position = {(seen.u_px - camera[2]) / camera[0], (seen.v_px - camera[3]) / camera[1], 1};
  seen.direction_optical = math::normalized(position).template to<msg::Vec3>();
  if (!math::is_finite(position) || !math::is_finite(seen.u_px + seen.v_px + seen.radius_px + best_score))
    return "a number that is not finite";
  seen.confidence = std::clamp(best_score, 0.0, 1.0);
  seen.found = 1;
  seen.blobs = static_cast<std::uint32_t>(std::min<std::size_t>(detections.items.size(), 1000));
  return nullptr;
}

template <class Sighting>
Pair detection(std::string_view own) {
  return {
      "vision_msgs/msg/Detection2DArray",
      own,
      true,
      true,
      {"frame", "object", "camera"},
      "`frame`: the camera's optical one. Nothing found: no detections. In: the detection of `object` with the highest "
      "score; its "
      "direction from its position, else from `camera`.",
      {time(), frame()},
      write_detection<Sighting>,
      read_detection<Sighting>,
      {{"detections[0].results[0].hypothesis.class_id", "`object`"},
       {"detections[0].results[0].hypothesis.score", "confidence"},
       {"detections[0].results[0].pose.pose.position", "direction_optical * range_m; range 1 m when it is not known"},
       {"detections[0].bbox.center.position", "u_px, v_px"},
       {"detections[0].bbox.size_x, size_y", "2 * radius_px"}}};
}

template <class M>
Pair setpoint_array(std::string_view own, bool in) {
  return {"std_msgs/msg/Float64MultiArray",
          own,
          true,
          in,
          {},
          in ? "As ros2_control's forward command controllers take it. In: `armed` is 1."
             : "What went out to the actuators.",
          {},
          write_array<M>,
          in ? read_array : nullptr,
          {{"data", "value[0..count]"}}};
}

template <class M>
Pair setpoint_names(std::string_view own) {
  return {"sensor_msgs/msg/JointState",
          own,
          true,
          false,
          {"joints"},
          "As simulators take commands; for groups whose setpoints are positions.",
          {time(), frame()},
          write_setpoints<M>,
          nullptr,
          {{"name", "`joints`"}, {"position", "value[0..count]"}}};
}

std::vector<Pair> make_pairs() {
  std::vector<Pair> all;
  all.push_back(
      {"sensor_msgs/msg/Imu",
       "ImuSample",
       true,
       true,
       {"frame"},
       "Specific force: +g upward at rest, as REP-145 has it. No orientation: its covariance begins with -1; the other "
       "covariances are 0, not known.",
       {time(), frame(), constant("orientation.w", 1), constant("orientation_covariance[0]", -1),
        vector("angular_velocity", "gyro_radps"), vector("linear_acceleration", "accel_mps2")}});
  all.push_back({"sensor_msgs/msg/Image",
                 "Image",
                 true,
                 true,
                 {"frame"},
                 "`frame`: the optical one. mono8, rgb8, bgr8, yuv422_yuy2; in also 8UC1 and 8UC3.",
                 {time(), frame(), number("height", "height"), number("width", "width"), number("step", "stride")},
                 write_image,
                 read_image,
                 {{"encoding", "format"}, {"data", "pixels"}}});
  all.push_back({"sensor_msgs/msg/CompressedImage",
                 "Image",
                 true,
                 false,
                 {"frame"},
                 "JPEG.",
                 {time(), frame()},
                 write_picture,
                 nullptr,
                 {{"format", "\"jpeg\""}, {"data", "the file"}}});
  all.push_back({"sensor_msgs/msg/CameraInfo",
                 "Image",
                 true,
                 false,
                 {"frame", "camera"},
                 "One for each image, with the same stamp.",
                 {time(), frame(), number("height", "height"), number("width", "width")},
                 write_camera_info,
                 nullptr,
                 {{"k, p", "`camera`: fx, fy, cx, cy"}, {"d", "`distortion`; plumb_bob"}, {"r", "identity"}}});
  all.push_back(
      {"sensor_msgs/msg/JointState",
       "JointState",
       true,
       true,
       {"joints"},
       "In: joints by their names, in any order; others are ignored. They count as enabled and ready.",
       {time(), frame()},
       write_joints,
       read_joints,
       {{"name", "`joints`"}, {"position", "position_rad"}, {"velocity", "velocity_radps"}, {"effort", "effort_nm"}}});
  all.push_back(setpoint_names<msg::GuardianState>("GuardianState"));
  all.push_back(setpoint_names<msg::ActuatorCommand>("ActuatorCommand"));
  all.push_back(
      {"sensor_msgs/msg/Range",
       "RangeSample",
       true,
       true,
       {"frame", "max_m"},
       "Without an echo +Inf (REP-117). In: what is not within the message's own limits tells nothing.",
       {time(), frame(), constant("radiation_type", 1)},
       write_range,
       read_range,
       {{"range", "range_m"}, {"field_of_view, min_range, max_range", "`field_of_view_rad`, `min_m`, `max_m`"}}});
  all.push_back(
      {"sensor_msgs/msg/NavSatFix",
       "GnssSample",
       true,
       true,
       {"frame", "geoid_m"},
       "ROS counts altitude from the ellipsoid, Sinew from mean sea level: `geoid_m` lies between. Velocity and number "
       "of satellites are not in it; in: 0, with an accuracy of 1e6. In without a fix: nothing.",
       {time(), frame(), number("latitude", "latitude_deg"), number("longitude", "longitude_deg")},
       write_fix,
       read_fix,
       {{"altitude", "altitude_m + `geoid_m`"},
        {"status.status", "fix: -1 none, 0 fix, 2 RTK"},
        {"position_covariance", "diagonal: horizontal_accuracy_m^2 (twice), vertical_accuracy_m^2"}}});
  all.push_back({"sensor_msgs/msg/MagneticField",
                 "MagSample",
                 true,
                 true,
                 {"frame"},
                 "Tesla.",
                 {time(), frame(), vector("magnetic_field", "field_t")}});
  all.push_back(
      {"sensor_msgs/msg/BatteryState",
       "BatterySample",
       true,
       true,
       {},
       "ROS counts a current that leaves the battery as negative. What is not measured is NaN. In: a message without "
       "percentage is refused.",
       {time(), frame(), constant("present", 1)},
       write_battery,
       read_battery,
       {{"voltage", "voltage_v"},
        {"current", "-current_a"},
        {"percentage", "charge"},
        {"power_supply_status", "by the sign of the current"}}});
  all.push_back({"sensor_msgs/msg/FluidPressure",
                 "BaroSample",
                 true,
                 true,
                 {"frame"},
                 "In: the temperature is 15 degC.",
                 {time(), frame(), number("fluid_pressure", "pressure_pa")},
                 nullptr,
                 read_pressure});
  all.push_back({"sensor_msgs/msg/Joy",
                 "RcSample",
                 false,
                 true,
                 {},
                 "Axes, then buttons (-1 and 1), 16 together; ROS: left and forward are positive.",
                 {time()},
                 nullptr,
                 read_joy,
                 {{"axes, buttons", "channel"}}});
  all.push_back({"geometry_msgs/msg/PoseStamped",
                 "NavState",
                 true,
                 false,
                 {"frame"},
                 "Only while the position is valid.",
                 {time(), frame(), vector("pose.position", "p_world_m"), quat("pose.orientation", "q_world_base")},
                 write_nav_pose<msg::NavState>});
  all.push_back({"geometry_msgs/msg/PoseStamped",
                 "TeamPose",
                 true,
                 true,
                 {"frame"},
                 "In: the covariance is 0.",
                 {time(), frame(), vector("pose.position", "p_team_m"), quat("pose.orientation", "q_team_base")},
                 nullptr,
                 read_rotation});
  all.push_back(
      {"geometry_msgs/msg/PoseWithCovarianceStamped",
       "TeamPose",
       true,
       true,
       {"frame"},
       "Rotations about fixed axes.",
       {time(), frame(), vector("pose.pose.position", "p_team_m"), quat("pose.pose.orientation", "q_team_base")},
       write_covariance,
       read_covariance,
       {{"pose.covariance", "covariance"}}});
  all.push_back({"geometry_msgs/msg/TwistStamped",
                 "NavState",
                 true,
                 false,
                 {"frame"},
                 "`frame`: the robot's, base_link. Only while the position is valid.",
                 {time(), frame(), vector("twist.angular", "gyro_radps")},
                 write_twist_stamped,
                 nullptr,
                 {{"twist.linear", "v_world_mps, turned into the robot's axes"}}});
  all.push_back({"geometry_msgs/msg/TwistStamped",
                 "VelocityCommand",
                 true,
                 true,
                 {"frame"},
                 "`frame`: the robot's, base_link.",
                 {time(), frame(), vector("twist.linear", "linear_mps"), vector("twist.angular", "angular_radps")}});
  all.push_back({"geometry_msgs/msg/Twist",
                 "VelocityCommand",
                 true,
                 true,
                 {},
                 "In: the stamp is the arrival.",
                 {vector("linear", "linear_mps"), vector("angular", "angular_radps")}});
  all.push_back({"nav_msgs/msg/Odometry",
                 "NavState",
                 true,
                 true,
                 {"frame", "child_frame"},
                 "Only while the position is valid. Variances that are not estimated are 1e6. In: counts as valid; the "
                 "height is z.",
                 {time(), frame(), child(), vector("pose.pose.position", "p_world_m"),
                  quat("pose.pose.orientation", "q_world_base"), vector("twist.twist.angular", "gyro_radps")},
                 write_odometry,
                 read_odometry,
                 {{"twist.twist.linear", "v_world_mps, turned into the robot's axes"},
                  {"pose.covariance", "diagonal: p_std_m^2 for x and y, tilt_std_rad^2 for roll and pitch"},
                  {"twist.covariance", "diagonal: v_std_mps^2 for x, y, z"}}});
  all.push_back({"tf2_msgs/msg/TFMessage",
                 "NavState",
                 true,
                 false,
                 {"frame", "child_frame"},
                 "One transform. Only while the position is valid.",
                 {},
                 write_tf_nav,
                 nullptr,
                 {{"transforms[0].header.stamp", "stamp"},
                  {"transforms[0].transform.translation", "p_world_m"},
                  {"transforms[0].transform.rotation", "q_world_base"}}});
  all.push_back({"tf2_msgs/msg/TFMessage",
                 "TeamPose",
                 true,
                 true,
                 {"frame", "child_frame"},
                 "In: the transform between these two frames; messages without it tell nothing.",
                 {},
                 write_tf_team,
                 read_tf_team,
                 {{"transforms[0].header.stamp", "stamp"},
                  {"transforms[0].transform.translation", "p_team_m"},
                  {"transforms[0].transform.rotation", "q_team_base"}}});
  all.push_back({"trajectory_msgs/msg/JointTrajectory",
                 "JointTrajectory",
                 false,
                 true,
                 {"joints"},
                 "1 to 16 points with positions; accelerations and efforts are ignored.",
                 {time()},
                 nullptr,
                 read_trajectory,
                 {{"joint_names", "`joints`"},
                  {"points[].positions", "point[].position_rad"},
                  {"points[].velocities", "point[].velocity_radps"},
                  {"points[].time_from_start", "point[].from_start_ns"}}});
  all.push_back(setpoint_array<msg::ActuatorCommand>("ActuatorCommand", true));
  all.push_back(setpoint_array<msg::GuardianState>("GuardianState", false));
  all.push_back(detection<msg::PadSighting>("PadSighting"));
  all.push_back(detection<msg::BallSighting>("BallSighting"));
  return all;
}

}  // namespace

const std::vector<Pair>& pairs() {
  static const std::vector<Pair> all = make_pairs();
  return all;
}

}  // namespace sinew::ros2::detail
