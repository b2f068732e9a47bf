#include "net/bridge/ros2_bridge.hpp"

#include <nlohmann/json.hpp>

#include "hal/platform.hpp"
#include "net/bridge/in_side.hpp"
#include "net/bridge/node_side.hpp"
#include "net/bridge/out_side.hpp"

namespace sinew::net {
namespace {

using ros2::dds_topic;
using ros2::dds_type_name;
using ros2::full_name;
using ros2::Qos;

/// Requests of one client are 200 a second at most (docs/robot-socket.md): two for what comes in.
constexpr std::size_t kInSides = 2;

DdsQos dds_qos(const Qos& qos) {
  DdsQos out;
  out.reliable = qos.reliable;
  out.transient_local = qos.transient_local;
  out.depth = qos.depth;
  return out;
}

constexpr Qos profile(std::string_view name) {
  for (const auto& [known, qos] : ros2::kQosProfiles)
    if (known == name) return qos;
  return {};
}

constexpr Qos kLatched{true, true, 1};

}  // namespace

struct Ros2Bridge::Parts {
  Parts(std::string robot, ros2::BridgeSpec spec) : shared(std::move(robot), std::move(spec)) {}

  std::unique_ptr<DdsWriter> writer(const std::string& topic, const std::string& type, const Qos& qos);
  std::unique_ptr<DdsReader> reader(const std::string& topic, const std::string& type, const Qos& qos);
  std::unique_ptr<DdsWriter> ros_writer(std::string_view name, std::string_view type, const Qos& qos) {
    return writer(dds_topic(full_name(shared.spec, name)), dds_type_name(type), qos);
  }
  std::unique_ptr<DdsReader> ros_reader(std::string_view name, std::string_view type, const Qos& qos) {
    return reader(dds_topic(full_name(shared.spec, name)), dds_type_name(type), qos);
  }
  NodeEndpoints make_node();
  void say_who_we_are();

  BridgeShared shared;
  Participant* participant = nullptr;
  std::vector<OwnEndpoint> endpoints;
  std::vector<Guid> writer_guids, reader_guids;
  std::string why;  // of the first endpoint that could not be made
  std::unique_ptr<DdsWriter> discovery, static_frames;
  std::unique_ptr<DdsReader> clock;
  DdsSample sample;
  std::unique_ptr<OutSide> out;
  std::vector<std::unique_ptr<InSide>> in;
  std::unique_ptr<NodeSide> node;
};

std::unique_ptr<DdsWriter> Ros2Bridge::Parts::writer(const std::string& topic, const std::string& type,
                                                     const Qos& qos) {
  EndpointSpec spec;
  spec.topic = topic, spec.type = type, spec.qos = dds_qos(qos);
  std::string wrong;
  auto made = participant->write(spec, wrong);
  if (!made) {
    if (why.empty()) why = topic + ": " + wrong;
    return nullptr;
  }
  writer_guids.push_back((*made)->guid());
  endpoints.push_back({std::move(spec), true});
  return std::move(*made);
}

std::unique_ptr<DdsReader> Ros2Bridge::Parts::reader(const std::string& topic, const std::string& type,
                                                     const Qos& qos) {
  EndpointSpec spec;
  spec.topic = topic, spec.type = type, spec.qos = dds_qos(qos);
  std::string wrong;
  auto made = participant->read(spec, wrong);
  if (!made) {
    if (why.empty()) why = topic + ": " + wrong;
    return nullptr;
  }
  reader_guids.push_back((*made)->guid());
  endpoints.push_back({std::move(spec), false});
  return std::move(*made);
}

NodeEndpoints Ros2Bridge::Parts::make_node() {
  NodeEndpoints ends;
  const ros2::BridgeSpec& spec = shared.spec;
  if (spec.rosout) ends.rosout = ros_writer("/rosout", "rcl_interfaces/msg/Log", profile("rosout"));
  if (spec.diagnostics)
    ends.diagnostics = ros_writer("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", profile("default"));
  if (!spec.parameters) return ends;
  ends.parameter_events =
      ros_writer("/parameter_events", "rcl_interfaces/msg/ParameterEvent", profile("parameter_events"));
  ends.parameter_set = ros_reader("~/parameter_set", "rcl_interfaces/msg/ParameterEvent", profile("parameters"));
  for (const auto& [name, service] : ros2::kParameterServices) {
    const std::string path = ros2::node_path(spec) + "/" + std::string(name);
    auto requests = reader("rq" + path + "Request", service_type(service, true), profile("services_default"));
    auto replies = writer("rr" + path + "Reply", service_type(service, false), profile("services_default"));
    ends.services.push_back({service, std::move(requests), std::move(replies)});
  }
  return ends;
}

void Ros2Bridge::Parts::say_who_we_are() {
  const ros2::BridgeSpec& spec = shared.spec;
  ros2::NodeInfo info;
  info.name = spec.node, info.name_space = spec.name_space;
  info.readers = reader_guids, info.writers = writer_guids;
  const auto cdr = ros2::discovery_info(spec.distro, participant->guid(), {&info, 1});
  static_cast<void>(discovery->write(cdr));  // reliable, with a depth of 1: there is always room
}

Ros2Bridge::Ros2Bridge(std::string robot, ros2::BridgeSpec spec)
    : parts_(std::make_unique<Parts>(std::move(robot), std::move(spec))) {}

Ros2Bridge::~Ros2Bridge() {
  parts_->shared.stop();
  if (parts_->out) parts_->out->wake();
}

bool Ros2Bridge::start(Participant& participant, std::string& why) {
  Parts& p = *parts_;
  const ros2::BridgeSpec& spec = p.shared.spec;
  p.participant = &participant;
  std::vector<std::unique_ptr<DdsWriter>> writers;
  for (const ros2::BridgedTopic& topic : spec.out) writers.push_back(p.ros_writer(topic.ros, topic.type, topic.qos));
  std::vector<std::vector<InLine>> lines(kInSides);
  for (std::size_t i = 0; i < spec.in.size(); ++i)
    lines[i % kInSides].push_back({&spec.in[i], p.ros_reader(spec.in[i].ros, spec.in[i].type, spec.in[i].qos)});
  std::unique_ptr<DdsWriter> clock;
  if (spec.clock == ros2::ClockUse::publish)
    clock = p.ros_writer("/clock", "rosgraph_msgs/msg/Clock", profile("clock"));
  if (spec.clock == ros2::ClockUse::follow)
    p.clock = p.ros_reader("/clock", "rosgraph_msgs/msg/Clock", profile("clock"));
  if (!spec.frames.empty()) p.static_frames = p.ros_writer("/tf_static", "tf2_msgs/msg/TFMessage", kLatched);
  NodeEndpoints node = p.make_node();
  // Not a topic of the graph: without the prefix, and not among the node's endpoints.
  const auto named_writers = p.writer_guids.size();
  p.discovery = p.writer("ros_discovery_info", dds_type_name("rmw_dds_common/msg/ParticipantEntitiesInfo"), kLatched);
  p.writer_guids.resize(std::min(named_writers, p.writer_guids.size()));
  if (!p.why.empty()) return why = p.why, false;

  p.say_who_we_are();
  if (p.static_frames)
    static_cast<void>(p.static_frames->write(
        ros2::static_frames_message(hal::system_os().now().ns + p.shared.to_ros_ns(0).value_or(0), spec.frames)));
  p.out = std::make_unique<OutSide>(p.shared, std::move(writers), std::move(clock));
  for (std::vector<InLine>& some : lines)
    if (!some.empty()) p.in.push_back(std::make_unique<InSide>(p.shared, std::move(some)));
  p.node = std::make_unique<NodeSide>(p.shared, std::move(node));
  return true;
}

void Ros2Bridge::look() {
  Parts& p = *parts_;
  while (p.clock && p.clock->take(p.sample)) {
    const hal::Time now = hal::system_os().now();
    if (const auto clock = ros2::read_clock(p.sample.cdr)) p.shared.heard_clock(*clock, now);
  }
  p.shared.notify();
}

const std::vector<OwnEndpoint>& Ros2Bridge::endpoints() const { return parts_->endpoints; }

void Ros2Bridge::add_status(nlohmann::json& status) const {
  const BridgeShared& shared = parts_->shared;
  Json topics = Json::array();
  const auto counts = shared.counts();
  const auto add = [&](const ros2::BridgedTopic& topic, bool out) {
    Json line{{"topic", topic.topic}, {"ros", full_name(shared.spec, topic.ros)}, {"type", topic.type}, {"out", out}};
    const auto at = counts.find(topic.key);
    const BridgedCounts c = at == counts.end() ? BridgedCounts{} : at->second;
    line["messages"] = c.messages, line["skipped"] = c.skipped, line["refused"] = c.refused, line["lost"] = c.lost;
    line["why"] = c.why;
    topics.push_back(std::move(line));
  };
  for (const ros2::BridgedTopic& topic : shared.spec.out) add(topic, true);
  for (const ros2::BridgedTopic& topic : shared.spec.in) add(topic, false);
  status["ros2"] =
      Json{{"node", ros2::node_path(shared.spec)}, {"robot", shared.connected()}, {"topics", std::move(topics)}};
}

}  // namespace sinew::net
