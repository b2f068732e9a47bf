#include "net/bridge/node_side.hpp"

#include <algorithm>

#include "hal/platform.hpp"

namespace sinew::net {
namespace {

using namespace std::chrono_literals;
using ros2::Parameter;
using ros2::ParameterInfo;
using ros2::ParameterService;

constexpr hal::Duration kReportPeriod = 1s;
constexpr hal::Duration kReaderTry = 10ms;
constexpr int kReaderTries = 10;

/// One of the robot's reply to `params`.
std::optional<ParameterInfo> info_of(const Json& json) {
  const auto member = [&](const char* name) -> const Json* {
    const auto at = json.find(name);
    return at == json.end() ? nullptr : &*at;
  };
  const Json *module = member("module"), *param = member("param"), *type = member("type"), *value = member("value");
  if (!module || !module->is_string() || !param || !param->is_string() || !type || !type->is_string() || !value)
    return {};
  ParameterInfo info;
  info.parameter.name = module->get<std::string>() + "." + param->get<std::string>();
  if (value->is_boolean())
    info.parameter.value = value->get<bool>();
  else if (*type == "integer" && value->is_number())
    info.parameter.value = static_cast<std::int64_t>(value->get<double>());
  else if (value->is_number())
    info.parameter.value = value->get<double>();
  else if (value->is_string())
    info.parameter.value = value->get<std::string>();
  if (const Json* doc = member("doc"); doc && doc->is_string()) info.doc = doc->get<std::string>();
  if (const Json* unit = member("unit"); unit && unit->is_string() && !unit->get<std::string>().empty())
    info.doc += (info.doc.empty() ? "[" : " [") + unit->get<std::string>() + "]";
  if (const Json* min = member("min"); min && min->is_number()) info.min = min->get<double>();
  if (const Json* max = member("max"); max && max->is_number()) info.max = max->get<double>();
  return info;
}

}  // namespace

NodeSide::NodeSide(BridgeShared& shared, NodeEndpoints endpoints)
    : shared_(shared), ends_(std::move(endpoints)), robot_(shared.robot) {
  thread_ = std::thread([this] { run(); });
}

NodeSide::~NodeSide() { thread_.join(); }

void NodeSide::run() {
  std::uint64_t seen = 0;
  hal::Time next_report{};
  while (!shared_.stopped()) {
    const bool there = robot_.reach();
    if (there != said_connected_) {
      said_connected_ = there;
      log(there ? ros2::LogLevel::info : ros2::LogLevel::warn, there ? "the robot runs" : "the robot is gone");
      next_report = {};
    }
    if (const hal::Time now = hal::system_os().now(); now >= next_report) {
      next_report = now + kReportPeriod;
      if (ends_.diagnostics || ends_.rosout) report();
      if (ends_.parameter_events && robot_) read_parameters();
    }
    serve();
    shared_.wait(seen, kLongestLook);
  }
}

std::int64_t NodeSide::ros_now_ns() {
  const std::int64_t offset = robot_ ? robot_.clock_offset_ns() : 0;
  return hal::system_os().now().ns + offset + shared_.to_ros_ns(offset).value_or(0);
}

void NodeSide::log(ros2::LogLevel level, const std::string& text) {
  if (!ends_.rosout) return;
  static_cast<void>(ends_.rosout->write(ros2::log_message(ros_now_ns(), level, shared_.spec.node, text)));
}

void NodeSide::report() {
  std::string why;
  const Json reply = robot_ ? robot_.ask("status", Json::object(), why) : Json();
  RobotReport::Said said;
  if (reply.is_object())
    said = reports_.read(shared_.robot, reply.dump());
  else
    said.diagnostics.push_back(
        {ros2::Health::stale, "robot", why.empty() ? "the robot is not there" : why, shared_.robot, {}});
  for (const RobotReport::Line& line : said.lines) log(line.level, line.text);
  if (ends_.diagnostics)
    static_cast<void>(ends_.diagnostics->write(ros2::diagnostics_message(ros_now_ns(), said.diagnostics)));
}

void NodeSide::read_parameters() {
  std::string why;
  const Json reply = robot_.ask("params", Json::object(), why);
  const auto list = reply.find("params");
  if (list == reply.end() || !list->is_array()) return;
  std::vector<ParameterInfo> now;
  std::vector<Parameter> added, changed;
  for (const Json& json : *list) {
    auto info = info_of(json);
    if (!info) continue;
    const auto before = std::find_if(parameters_.begin(), parameters_.end(),
                                     [&](const ParameterInfo& p) { return p.parameter.name == info->parameter.name; });
    if (before == parameters_.end())
      added.push_back(info->parameter);
    else if (before->parameter.value != info->parameter.value)
      changed.push_back(info->parameter);
    now.push_back(std::move(*info));
  }
  parameters_ = std::move(now);
  if (added.empty() && changed.empty()) return;
  static_cast<void>(ends_.parameter_events->write(
      ros2::parameter_event(ros_now_ns(), ros2::node_path(shared_.spec), added, changed)));
}

std::string NodeSide::set(const Parameter& parameter) {
  const auto dot = parameter.name.find('.');
  if (dot == std::string::npos) return parameter.name + ": a name is MODULE.PARAMETER";
  Json arguments{{"module", parameter.name.substr(0, dot)}, {"param", parameter.name.substr(dot + 1)}};
  if (const auto* b = std::get_if<bool>(&parameter.value)) arguments["value"] = *b;
  if (const auto* i = std::get_if<std::int64_t>(&parameter.value)) arguments["value"] = *i;
  if (const auto* d = std::get_if<double>(&parameter.value)) arguments["value"] = *d;
  if (const auto* s = std::get_if<std::string>(&parameter.value)) arguments["value"] = *s;
  if (!arguments.contains("value")) return parameter.name + ": a parameter of a robot cannot be taken away";
  std::string why;
  robot_.ask("param.set", arguments, why);
  return why;
}

void NodeSide::serve() {
  bool any = false;
  while (ends_.parameter_set && ends_.parameter_set->take(sample_)) {
    const auto event = ros2::read_parameter_event(sample_.cdr);
    if (!event) {
      log(ros2::LogLevel::warn, "parameter_set: no message that sets parameters");
      continue;
    }
    if (!event->node.empty() && event->node != ros2::node_path(shared_.spec)) continue;  // somebody else's
    for (const Parameter& parameter : event->set) {
      const std::string why = set(parameter);
      if (!why.empty()) log(ros2::LogLevel::warn, "parameter_set: " + why);
    }
    any = true;
  }
  for (NodeEndpoints::Service& service : ends_.services) serve(service);
  if (any && robot_ && ends_.parameter_events) read_parameters();
}

void NodeSide::serve(NodeEndpoints::Service& service) {
  while (service.requests->take(sample_)) {
    // A client's reader may be found after its writer: its RMW's own servers wait as long (rmw_send_response()).
    for (int i = 0; i < kReaderTries && service.replies->matched() == 0; ++i)
      hal::system_os().sleep_until(hal::system_os().now() + kReaderTry);
    const auto request = ros2::read_request(service.service, sample_.cdr);
    if (!request) continue;  // of another kind of RMW: there is nobody whom an answer would reach
    if (service.service != ParameterService::set) {
      static_cast<void>(service.replies->write(ros2::service_reply(service.service, *request, parameters_)));
      continue;
    }
    std::vector<std::string> refused;
    for (const Parameter& parameter : request->set) refused.push_back(set(parameter));
    static_cast<void>(service.replies->write(ros2::set_reply(*request, refused)));
    if (robot_ && ends_.parameter_events) read_parameters();
  }
}

}  // namespace sinew::net
