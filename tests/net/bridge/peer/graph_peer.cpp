// graph_peer DOMAIN NODE: a small node of a ROS 2 graph on Fast DDS beside the robot NODE ("/quad/quad_ros2"). Prints
// what it heard, one object of JSON a line as {"topic": ..., "count": ..., field: value ...}, when a line comes on
// stdin. "set NAME VALUE" sets a parameter; "drive X" says a velocity until the next such line.
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>

#include <typesPubSubTypes.h>
#include "peer.hpp"

namespace {

std::mutex mutex;  // of what was heard
struct Heard {
  int count = 0;
  std::string last;
};
std::map<std::string, Heard> heard;

template <class T>
class Listener final : public peer::dds::DataReaderListener {
 public:
  using Say = std::function<std::string(const T&)>;
  Listener(std::string topic, Say say) : topic_(std::move(topic)), say_(std::move(say)) {}
  void on_data_available(peer::dds::DataReader* reader) override {
    T sample;
    peer::dds::SampleInfo info;
    while (reader->take_next_sample(&sample, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      std::string text = say_(sample);
      const std::lock_guard<std::mutex> lock(mutex);
      Heard& h = heard[topic_];
      if (!text.empty() || h.count == 0) h.last = text;
      ++h.count;
    }
  }

 private:
  std::string topic_;
  Say say_;
};

template <class T>
std::string number(const char* name, T value) {
  std::ostringstream out;
  out.precision(17);
  out << ", \"" << name << "\": " << +value;
  return out.str();
}
std::string text(const char* name, const std::string& value) {
  std::string safe;
  for (const char c : value) safe += c == '"' || c == '\\' || c < ' ' ? '.' : c;
  return std::string(", \"") + name + "\": \"" + safe + "\"";
}
template <class Header>
std::string head(const Header& h) {
  return number("sec", h.stamp().sec()) + number("nanosec", h.stamp().nanosec()) + text("frame", h.frame_id());
}
std::string gid_text(const std::string& what, std::size_t size) { return number(what.c_str(), size); }

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const std::string node_name = argv[2], space = node_name.substr(0, node_name.rfind('/'));
  peer::Node node(static_cast<std::uint32_t>(std::atoi(argv[1])));
  const peer::Qos reliable{true, false, 10}, fast{false, false, 5}, latched{true, true, 1}, log{true, true, 1000};
  const auto listen = [&](auto tag, auto pubsub, const std::string& topic, const peer::Qos& qos, auto say) {
    using T = typename decltype(tag)::type;
    using PubSub = typename decltype(pubsub)::type;
    node.reader<PubSub>(topic, qos, new Listener<T>(topic, say));
  };
#define LISTEN(type, topic, qos, say) \
  listen(std::common_type<type>(), std::common_type<type##PubSubType>(), topic, qos, [](const type& m) { return say; })
  LISTEN(sensor_msgs::msg::Imu, "rt" + space + "/imu/data_raw", fast,
         head(m.header()) + number("z", m.linear_acceleration().z()) + number("c0", m.orientation_covariance()[0]));
  LISTEN(nav_msgs::msg::Odometry, "rt" + space + "/odom", reliable,
         head(m.header()) + text("child", m.child_frame_id()) + number("z", m.pose().pose().position().z()) +
             number("w", m.pose().pose().orientation().w()) + number("variance", m.pose().covariance()[0]));
  LISTEN(tf2_msgs::msg::TFMessage, "rt/tf", reliable,
         head(m.transforms()[0].header()) + text("child", m.transforms()[0].child_frame_id()));
  LISTEN(sensor_msgs::msg::Range, "rt" + space + "/range", fast,
         number("range", m.range()) + number("max", m.max_range()));
  LISTEN(sensor_msgs::msg::FluidPressure, "rt" + space + "/pressure", fast, number("pascal", m.fluid_pressure()));
  LISTEN(sensor_msgs::msg::BatteryState, "rt" + space + "/battery", reliable,
         number("voltage", m.voltage()) + number("current", m.current()) + number("percentage", m.percentage()));
  LISTEN(sensor_msgs::msg::Image, "rt" + space + "/camera/image_raw", fast,
         number("width", m.width()) + number("height", m.height()) + number("step", m.step()) +
             text("encoding", m.encoding()) + number("bytes", m.data().size()));
  LISTEN(sensor_msgs::msg::CompressedImage, "rt" + space + "/camera/image_raw/compressed", fast,
         text("format", m.format()) + number("bytes", m.data().size()) + number("first", int(m.data()[0])));
  LISTEN(vision_msgs::msg::Detection2DArray, "rt" + space + "/pad", reliable,
         m.detections().empty() ? std::string()
                                : text("object", m.detections()[0].results()[0].hypothesis().class_id()) +
                                      number("u", m.detections()[0].bbox().center().position().x()));
  LISTEN(sinew_msgs::msg::MissionState, "rt" + space + "/mission", reliable, number("phase", m.phase()));
  LISTEN(rosgraph_msgs::msg::Clock, "rt/clock", fast,
         number("sec", m.clock().sec()) + number("nanosec", m.clock().nanosec()));
  LISTEN(diagnostic_msgs::msg::DiagnosticArray, "rt/diagnostics", reliable,
         number("statuses", m.status().size()) + text("first", m.status()[0].name()) +
             text("hardware", m.status()[0].hardware_id()));
  LISTEN(rcl_interfaces::msg::Log, "rt/rosout", log,
         number("level", m.level()) + text("name", m.name()) + text("msg", m.msg()));
  LISTEN(rcl_interfaces::msg::ParameterEvent, "rt/parameter_events", (peer::Qos{true, false, 1000}),
         text("node", m.node()) + number("new", m.new_parameters().size()) +
             number("changed", m.changed_parameters().size()) +
             (m.changed_parameters().empty() ? std::string()
                                             : text("name", m.changed_parameters()[0].name()) +
                                                   number("value", m.changed_parameters()[0].value().double_value())));
  LISTEN(rmw_dds_common::msg::ParticipantEntitiesInfo, "ros_discovery_info", latched,
         text("node", m.node_entities_info_seq()[0].node_name().to_string()) +
             text("space", m.node_entities_info_seq()[0].node_namespace().to_string()) +
             number("readers", m.node_entities_info_seq()[0].reader_gid_seq().size()) +
             number("writers", m.node_entities_info_seq()[0].writer_gid_seq().size()) +
             gid_text("gid", m.gid().data().size()));

  auto* const drive = node.writer<geometry_msgs::msg::TwistPubSubType>("rt" + space + "/cmd_vel", reliable);
  auto* const set =
      node.writer<rcl_interfaces::msg::ParameterEventPubSubType>("rt" + node_name + "/parameter_set", reliable);
  std::atomic<double> speed{0};
  std::atomic<bool> driving{false};
  std::thread([&] {
    for (;; std::this_thread::sleep_for(std::chrono::milliseconds(50))) {
      if (!driving) continue;
      geometry_msgs::msg::Twist twist;
      twist.linear().x(speed);
      twist.angular().z(-0.5 * speed);
      drive->write(&twist);
    }
  }).detach();

  std::printf("{\"ready\": true}\n");
  std::fflush(stdout);
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string what, name;
    double value = 0;
    words >> what;
    if (what == "drive" && words >> value) {
      speed = value, driving = true;
    } else if (what == "set" && words >> name >> value) {
      rcl_interfaces::msg::Parameter parameter;
      parameter.name(name);
      parameter.value().type(3);
      parameter.value().double_value(value);
      rcl_interfaces::msg::ParameterEvent event;
      event.node(node_name);
      event.changed_parameters().push_back(parameter);
      set->write(&event);
    } else if (what == "static") {  // who comes late gets it all the same
      LISTEN(tf2_msgs::msg::TFMessage, "rt/tf_static", latched,
             text("child", m.transforms()[0].child_frame_id()) +
                 number("y", m.transforms()[0].transform().rotation().y()));
    } else {
      const std::lock_guard<std::mutex> lock(mutex);
      for (const auto& h : heard)
        std::printf("{\"topic\": \"%s\", \"count\": %d%s}\n", h.first.c_str(), h.second.count, h.second.last.c_str());
      std::printf("{}\n");
      std::fflush(stdout);
    }
  }
  std::_Exit(0);
}
