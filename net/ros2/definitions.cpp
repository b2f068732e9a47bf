#include "net/ros2/definitions.hpp"

#include <span>
#include <string>

#include "msg/all.hpp"
#include "msg/ros2msg.hpp"

namespace sinew::ros2 {
namespace {

struct Definition {
  std::string_view name, text;
};

// Each type behind those that it names.
constexpr Definition kOfAll[] = {
    {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"},
    {"builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n"},
    {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
    {"std_msgs/Bool", "bool data\n"},
    {"std_msgs/Int32", "int32 data\n"},
    {"std_msgs/Int64", "int64 data\n"},
    {"std_msgs/UInt32", "uint32 data\n"},
    {"std_msgs/UInt64", "uint64 data\n"},
    {"std_msgs/Float32", "float32 data\n"},
    {"std_msgs/Float64", "float64 data\n"},
    {"std_msgs/String", "string data\n"},
    {"std_msgs/MultiArrayDimension", "string label\nuint32 size\nuint32 stride\n"},
    {"std_msgs/MultiArrayLayout", "MultiArrayDimension[] dim\nuint32 data_offset\n"},
    {"std_msgs/Float64MultiArray", "MultiArrayLayout layout\nfloat64[] data\n"},
    {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"},
    {"geometry_msgs/Pose", "Point position\nQuaternion orientation\n"},
    {"geometry_msgs/PoseStamped", "std_msgs/Header header\nPose pose\n"},
    {"geometry_msgs/PoseWithCovariance", "Pose pose\nfloat64[36] covariance\n"},
    {"geometry_msgs/PoseWithCovarianceStamped", "std_msgs/Header header\nPoseWithCovariance pose\n"},
    {"geometry_msgs/Twist", "Vector3 linear\nVector3 angular\n"},
    {"geometry_msgs/TwistStamped", "std_msgs/Header header\nTwist twist\n"},
    {"geometry_msgs/TwistWithCovariance", "Twist twist\nfloat64[36] covariance\n"},
    {"geometry_msgs/Transform", "Vector3 translation\nQuaternion rotation\n"},
    {"geometry_msgs/TransformStamped", "std_msgs/Header header\nstring child_frame_id\nTransform transform\n"},
    {"sensor_msgs/Imu",
     "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
     "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
     "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n"},
    {"sensor_msgs/Image",
     "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] "
     "data\n"},
    {"sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"},
    {"sensor_msgs/RegionOfInterest",
     "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"},
    {"sensor_msgs/CameraInfo",
     "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\n"
     "float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nRegionOfInterest roi\n"},
    {"sensor_msgs/JointState",
     "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"},
    {"sensor_msgs/NavSatStatus", "int8 status\nuint16 service\n"},
    {"sensor_msgs/NavSatFix",
     "std_msgs/Header header\nNavSatStatus status\nfloat64 latitude\nfloat64 longitude\nfloat64 altitude\n"
     "float64[9] position_covariance\nuint8 position_covariance_type\n"},
    {"sensor_msgs/MagneticField",
     "std_msgs/Header header\ngeometry_msgs/Vector3 magnetic_field\nfloat64[9] magnetic_field_covariance\n"},
    {"sensor_msgs/BatteryState",
     "std_msgs/Header header\nfloat32 voltage\nfloat32 temperature\nfloat32 current\nfloat32 charge\nfloat32 capacity\n"
     "float32 design_capacity\nfloat32 percentage\nuint8 power_supply_status\nuint8 power_supply_health\n"
     "uint8 power_supply_technology\nbool present\nfloat32[] cell_voltage\nfloat32[] cell_temperature\nstring "
     "location\n"
     "string serial_number\n"},
    {"sensor_msgs/FluidPressure", "std_msgs/Header header\nfloat64 fluid_pressure\nfloat64 variance\n"},
    {"sensor_msgs/Joy", "std_msgs/Header header\nfloat32[] axes\nint32[] buttons\n"},
    {"nav_msgs/Odometry",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
     "geometry_msgs/TwistWithCovariance twist\n"},
    {"tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"},
    {"trajectory_msgs/JointTrajectoryPoint",
     "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
     "builtin_interfaces/Duration time_from_start\n"},
    {"trajectory_msgs/JointTrajectory",
     "std_msgs/Header header\nstring[] joint_names\nJointTrajectoryPoint[] points\n"},
    {"vision_msgs/Point2D", "float64 x\nfloat64 y\n"},
    {"vision_msgs/Pose2D", "Point2D position\nfloat64 theta\n"},
    {"vision_msgs/BoundingBox2D", "Pose2D center\nfloat64 size_x\nfloat64 size_y\n"},
    {"vision_msgs/ObjectHypothesis", "string class_id\nfloat64 score\n"},
    {"vision_msgs/ObjectHypothesisWithPose", "ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose\n"},
    {"vision_msgs/Detection2D",
     "std_msgs/Header header\nObjectHypothesisWithPose[] results\nBoundingBox2D bbox\nstring id\n"},
    {"vision_msgs/Detection2DArray", "std_msgs/Header header\nDetection2D[] detections\n"},
    {"rosgraph_msgs/Clock", "builtin_interfaces/Time clock\n"},
    {"diagnostic_msgs/KeyValue", "string key\nstring value\n"},
    {"diagnostic_msgs/DiagnosticStatus",
     "byte level\nstring name\nstring message\nstring hardware_id\nKeyValue[] values\n"},
    {"diagnostic_msgs/DiagnosticArray", "std_msgs/Header header\nDiagnosticStatus[] status\n"},
    {"rcl_interfaces/Log",
     "builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\nstring file\nstring function\nuint32 "
     "line\n"},
    {"rcl_interfaces/ParameterValue",
     "uint8 type\nbool bool_value\nint64 integer_value\nfloat64 double_value\nstring string_value\n"
     "byte[] byte_array_value\nbool[] bool_array_value\nint64[] integer_array_value\nfloat64[] double_array_value\n"
     "string[] string_array_value\n"},
    {"rcl_interfaces/Parameter", "string name\nParameterValue value\n"},
    {"rcl_interfaces/ParameterEvent",
     "builtin_interfaces/Time stamp\nstring node\nParameter[] new_parameters\nParameter[] changed_parameters\n"
     "Parameter[] deleted_parameters\n"},
    {"rcl_interfaces/SetParametersResult", "bool successful\nstring reason\n"},
    {"rcl_interfaces/ListParametersResult", "string[] names\nstring[] prefixes\n"},
    {"rcl_interfaces/FloatingPointRange", "float64 from_value\nfloat64 to_value\nfloat64 step\n"},
    {"rcl_interfaces/IntegerRange", "int64 from_value\nint64 to_value\nuint64 step\n"},
    {"rcl_interfaces/ParameterDescriptor",
     "string name\nuint8 type\nstring description\nstring additional_constraints\nbool read_only false\n"
     "bool dynamic_typing false\nFloatingPointRange[<=1] floating_point_range\nIntegerRange[<=1] integer_range\n"},
    // Halves of services; on the wire their request's head of Cyclone's RMW stands before them.
    {"rcl_interfaces/srv/GetParameters_Request", "string[] names\n"},
    {"rcl_interfaces/srv/GetParameters_Response", "rcl_interfaces/ParameterValue[] values\n"},
    {"rcl_interfaces/srv/GetParameterTypes_Request", "string[] names\n"},
    {"rcl_interfaces/srv/GetParameterTypes_Response", "uint8[] types\n"},
    {"rcl_interfaces/srv/SetParameters_Request", "rcl_interfaces/Parameter[] parameters\n"},
    {"rcl_interfaces/srv/SetParameters_Response", "rcl_interfaces/SetParametersResult[] results\n"},
    {"rcl_interfaces/srv/ListParameters_Request", "string[] prefixes\nuint64 depth\n"},
    {"rcl_interfaces/srv/ListParameters_Response", "rcl_interfaces/ListParametersResult result\n"},
    {"rcl_interfaces/srv/DescribeParameters_Request", "string[] names\n"},
    {"rcl_interfaces/srv/DescribeParameters_Response", "rcl_interfaces/ParameterDescriptor[] descriptors\n"},
};

constexpr Definition kOfHumble[] = {
    {"sensor_msgs/Range",
     "std_msgs/Header header\nuint8 radiation_type\nfloat32 field_of_view\nfloat32 min_range\nfloat32 max_range\n"
     "float32 range\n"},
    {"rmw_dds_common/Gid", "char[24] data\n"},
};
constexpr Definition kOfJazzy[] = {
    {"sensor_msgs/Range",
     "std_msgs/Header header\nuint8 radiation_type\nfloat32 field_of_view\nfloat32 min_range\nfloat32 max_range\n"
     "float32 range\nfloat32 variance\n"},
    {"rmw_dds_common/Gid", "char[16] data\n"},
};
constexpr Definition kBehind[] = {
    {"rmw_dds_common/NodeEntitiesInfo",
     "string<=256 node_namespace\nstring<=256 node_name\nGid[] reader_gid_seq\nGid[] writer_gid_seq\n"},
    {"rmw_dds_common/ParticipantEntitiesInfo", "Gid gid\nNodeEntitiesInfo[] node_entities_info_seq\n"},
};

std::unique_ptr<const Types> make(Distro distro) {
  auto types = std::make_unique<Types>();
  std::string why;
  const auto add = [&](std::span<const Definition> definitions) {
    for (const Definition& d : definitions) types->add(d.name, d.text, why);
  };
  add(kOfAll);
  add(distro == Distro::humble ? std::span<const Definition>(kOfHumble) : std::span<const Definition>(kOfJazzy));
  add(kBehind);
  for (const msg::TypeInfo* t : msg::all_types()) {
    types->add_with_nested(msg::ros2_name(*t), msg::ros2msg_schema(*t), why);
    if (const msg::TypeInfo* of_mate = msg::find_type(std::string(t->name) + "FromMate"))
      types->add_with_nested(msg::ros2_name(*of_mate), msg::ros2msg_schema(*of_mate), why);
  }
  return types;
}

}  // namespace

const Types& known_types(Distro distro) {
  static const std::unique_ptr<const Types> humble = make(Distro::humble), jazzy = make(Distro::jazzy);
  return distro == Distro::humble ? *humble : *jazzy;
}

}  // namespace sinew::ros2
