// The table of translations. Units and frames are those of REP-103 and of the .msg files' comments.
// Source:  ROS REP-103 (units, axes), REP-105 (map, odom, base_link), REP-117 (ranges without an echo are +Inf),
//          REP-145 (IMU), comments of common_interfaces.
#include "msg/actuators.hpp"
#include "msg/flight.hpp"
#include "msg/head.hpp"
#include "msg/safety.hpp"
#include "net/ros2/pair_code.hpp"

namespace sinew::ros2::detail {
namespace {

constexpr Row time(std::string_view ros = "header.stamp", std::string_view own = "stamp") {
  return {What::time, ros, own};
}
constexpr Row frame(std::string_view ros = "header.frame_id") { return {What::frame, ros}; }
constexpr Row child(std::string_view ros = "child_frame_id") { return {What::child_frame, ros}; }
constexpr Row number(std::string_view ros, std::string_view own) { return {What::number, ros, own}; }
constexpr Row vector(std::string_view ros, std::string_view own) { return {What::vector, ros, own}; }
constexpr Row quat(std::string_view ros, std::string_view own) { return {What::quaternion, ros, own}; }
constexpr Row constant(std::string_view ros, double value) { return {What::constant, ros, {}, value}; }

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
                 true,
                 {"frame"},
                 "Out: JPEG. In: JPEG and PNG, whatever `format` says; grey to mono8, colour to rgb8.",
                 {time(), frame()},
                 write_picture,
                 read_picture,
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
  all.push_back({"sensor_msgs/msg/CameraInfo",
                 "CameraModel",
                 true,
                 true,
                 {"frame"},
                 "In: plumb_bob, or no distortion; of whole pictures without binning.",
                 {time(), frame(), number("height", "height"), number("width", "width")},
                 write_camera_model,
                 read_camera_info,
                 {{"k, p", "fx_px, fy_px, cx_px, cy_px"}, {"d", "distortion; plumb_bob"}, {"r", "identity"}}});
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
