#include "record/run/ros2_convert.hpp"

#include <array>
#include <cstdlib>
#include <limits>

#include "math/elementary.hpp"
#include "msg/cdr.hpp"
#include "msg/flight.hpp"
#include "msg/ros2msg.hpp"
#include "msg/sensors.hpp"
#include "record/run/cdr_stream.hpp"
#include "record/run/run_messages.hpp"

namespace sinew::record {
namespace {

constexpr std::string_view kBase = "base_link", kWorld = "odom";
constexpr float kUnknown = math::kNanF;

// Source: common_interfaces of ROS 2, fields only.
#define SINEW_LINE "================================================================================\n"
#define SINEW_HEADER                                                                             \
  SINEW_LINE "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" SINEW_LINE \
             "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
#define SINEW_VECTOR SINEW_LINE "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
#define SINEW_QUATERNION SINEW_LINE "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"

constexpr RecordSchema kImu{"sensor_msgs/msg/Imu",
                            "std_msgs/Header header\n"
                            "geometry_msgs/Quaternion orientation\n"
                            "float64[9] orientation_covariance\n"
                            "geometry_msgs/Vector3 angular_velocity\n"
                            "float64[9] angular_velocity_covariance\n"
                            "geometry_msgs/Vector3 linear_acceleration\n"
                            "float64[9] linear_acceleration_covariance\n" SINEW_HEADER SINEW_QUATERNION SINEW_VECTOR};
constexpr RecordSchema kRange{"sensor_msgs/msg/Range",
                              "std_msgs/Header header\n"
                              "uint8 ULTRASOUND=0\n"
                              "uint8 INFRARED=1\n"
                              "uint8 radiation_type\n"
                              "float32 field_of_view\n"
                              "float32 min_range\n"
                              "float32 max_range\n"
                              "float32 range\n"
                              "float32 variance\n" SINEW_HEADER};
constexpr RecordSchema kPressure{"sensor_msgs/msg/FluidPressure",
                                 "std_msgs/Header header\n"
                                 "float64 fluid_pressure\n"
                                 "float64 variance\n" SINEW_HEADER};
constexpr RecordSchema kBattery{"sensor_msgs/msg/BatteryState",
                                "std_msgs/Header header\n"
                                "float32 voltage\n"
                                "float32 temperature\n"
                                "float32 current\n"
                                "float32 charge\n"
                                "float32 capacity\n"
                                "float32 design_capacity\n"
                                "float32 percentage\n"
                                "uint8 power_supply_status\n"
                                "uint8 power_supply_health\n"
                                "uint8 power_supply_technology\n"
                                "bool present\n"
                                "float32[] cell_voltage\n"
                                "float32[] cell_temperature\n"
                                "string location\n"
                                "string serial_number\n" SINEW_HEADER};
constexpr RecordSchema kOdometry{
    "nav_msgs/msg/Odometry",
    "std_msgs/Header header\n"
    "string child_frame_id\n"
    "geometry_msgs/PoseWithCovariance pose\n"
    "geometry_msgs/TwistWithCovariance twist\n" SINEW_LINE
    "MSG: geometry_msgs/PoseWithCovariance\n"
    "geometry_msgs/Pose pose\nfloat64[36] covariance\n" SINEW_LINE
    "MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n" SINEW_LINE
    "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n" SINEW_LINE
    "MSG: geometry_msgs/TwistWithCovariance\n"
    "geometry_msgs/Twist twist\nfloat64[36] covariance\n" SINEW_LINE
    "MSG: geometry_msgs/Twist\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n" SINEW_HEADER
        SINEW_QUATERNION SINEW_VECTOR};

#undef SINEW_LINE
#undef SINEW_HEADER
#undef SINEW_VECTOR
#undef SINEW_QUATERNION

// Machines make different NaNs; the file is the same from all.
void put(CdrWriter& to, const msg::Vec3& v) {
  for (const double x : {v.x, v.y, v.z}) to.number(math::canonical(x));
}
void put(CdrWriter& to, const msg::Quat& q) {
  for (const double x : {q.x, q.y, q.z, q.w}) to.number(math::canonical(x));
}
void put(CdrWriter& to, float value) { to.number(std::bit_cast<std::uint32_t>(math::canonical(value))); }
template <std::size_t N>
void put(CdrWriter& to, const std::array<double, N>& values) {
  for (const double x : values) to.number(math::canonical(x));
}

/// A vector of the world in base coordinates.
msg::Vec3 in_base(const msg::Quat& q, const msg::Vec3& v) {
  const double x = -q.x, y = -q.y, z = -q.z;
  const msg::Vec3 t{2 * (y * v.z - z * v.y), 2 * (z * v.x - x * v.z), 2 * (x * v.y - y * v.x)};
  return {v.x + q.w * t.x + y * t.z - z * t.y, v.y + q.w * t.y + z * t.x - x * t.z,
          v.z + q.w * t.z + x * t.y - y * t.x};
}

class ToRos2 final : public Conversion {
 public:
  explicit ToRos2(std::int64_t unix_ns) : unix_ns_(unix_ns) {
    add<msg::ImuSample>(kImu);
    add<msg::RangeSample>(kRange);
    add<msg::BaroSample>(kPressure);
    add<msg::BatterySample>(kBattery);
    add<msg::NavState>(kOdometry);
  }

  std::optional<Schema> schema(const Channel& channel, const Schema& schema) override {
    const auto found = by_name_.find(schema.name);
    if (found == by_name_.end() || channel.message_encoding != "cdr" || found->second.text != schema.data)
      return std::nullopt;
    const RecordSchema& to = *found->second.to;
    return Schema{0, std::string(to.name), "ros2msg", std::string(to.text)};
  }

  std::span<const std::byte> convert(const Message& message, const Schema& schema) override {
    return by_name_.at(schema.name).convert(*this, message) ? out_.bytes() : std::span<const std::byte>();
  }

 private:
  struct Known {
    const RecordSchema* to;
    std::string text;
    bool (*convert)(ToRos2&, const Message&);
  };

  template <class T>
  void add(const RecordSchema& to) {
    const msg::TypeInfo& type = msg::type_info<T>();
    by_name_[msg::ros2_name(type)] = {&to, msg::ros2msg_schema(type), [](ToRos2& self, const Message& m) {
                                        T from;
                                        const std::span bytes(reinterpret_cast<const std::uint8_t*>(m.data.data()),
                                                              m.data.size());
                                        if (!msg::cdr_decode(msg::type_info<T>(), bytes, &from)) return false;
                                        self.write(from, m.channel->topic);
                                        return true;
                                      }};
  }

  CdrWriter begin(msg::Time stamp, std::string_view frame) {
    CdrWriter to(out_);
    put_header(to, stamp.ns + unix_ns_, frame);
    return to;
  }

  void write(const msg::ImuSample& m, const std::string&) {
    CdrWriter to = begin(m.stamp, kBase);
    put(to, msg::Quat{});
    put(to, std::array<double, 9>{-1});  // no orientation
    put(to, m.gyro_radps);
    put(to, std::array<double, 9>{});
    put(to, m.accel_mps2);
    put(to, std::array<double, 9>{});
  }
  void write(const msg::RangeSample& m, const std::string& topic) {
    constexpr std::uint8_t kInfrared = 1;
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    CdrWriter to = begin(m.stamp, topic);
    to.number(kInfrared);
    put(to, 0.0F);
    put(to, 0.0F);
    put(to, kInfinity);                                                           // the reach is not in the message
    put(to, m.range_m == m.range_m ? static_cast<float>(m.range_m) : kInfinity);  // REP-117: nothing in range
    put(to, 0.0F);
  }
  void write(const msg::BaroSample& m, const std::string&) {
    CdrWriter to = begin(m.stamp, kBase);
    to.number(m.pressure_pa);
    to.number(0.0);
  }
  void write(const msg::BatterySample& m, const std::string&) {
    CdrWriter to = begin(m.stamp, kBase);
    put(to, static_cast<float>(m.voltage_v));
    put(to, kUnknown);                              // temperature
    put(to, static_cast<float>(-m.current_a));      // negative when it is drawn
    for (int i = 0; i < 3; ++i) put(to, kUnknown);  // charge, capacity, design capacity
    put(to, static_cast<float>(m.charge));
    for (int i = 0; i < 3; ++i) to.number(std::uint8_t{0});  // status, health, technology: unknown
    to.boolean(true);
    to.length(0), to.length(0);
    to.text(""), to.text("");
  }
  void write(const msg::NavState& m, const std::string&) {
    const double p = m.p_std_m * m.p_std_m, tilt = m.tilt_std_rad * m.tilt_std_rad, v = m.v_std_mps * m.v_std_mps;
    std::array<double, 36> pose{}, twist{};  // unknown values are zero
    pose[0] = pose[7] = p, pose[21] = pose[28] = tilt;
    twist[0] = twist[7] = v;
    CdrWriter to = begin(m.stamp, kWorld);
    to.text(kBase);
    put(to, m.p_world_m);
    put(to, m.q_world_base);
    put(to, pose);
    put(to, in_base(m.q_world_base, m.v_world_mps));
    put(to, m.gyro_radps);
    put(to, twist);
  }

  const std::int64_t unix_ns_;
  std::map<std::string, Known> by_name_;
  Buffer out_;
};

}  // namespace

std::int64_t unix_ns_of(Reader& reader) {
  const Texts run = read_metadata(reader, "sinew.run");
  const auto ns = run.find("unix_ns");
  return ns == run.end() ? 0 : std::strtoll(ns->second.c_str(), nullptr, 10);
}

std::unique_ptr<Conversion> to_ros2(std::int64_t unix_ns) { return std::make_unique<ToRos2>(unix_ns); }

}  // namespace sinew::record
