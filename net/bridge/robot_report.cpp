#include "net/bridge/robot_report.hpp"

#include <nlohmann/json.hpp>

#include "msg/safety.hpp"
#include "net/bridge/robot_client.hpp"

namespace sinew::net {
namespace {

using ros2::Diagnosis;
using ros2::Health;

std::int64_t count_of(const Json& json, const char* member) {
  const auto at = json.find(member);
  return at != json.end() && at->is_number() ? static_cast<std::int64_t>(at->get<double>()) : 0;
}
std::string text_of(const Json& json, const char* member) {
  const auto at = json.find(member);
  return at != json.end() && at->is_string() ? at->get<std::string>() : std::string();
}
const Json& part_of(const Json& json, const char* member) {
  static const Json kNone = Json::object();
  const auto at = json.find(member);
  return at != json.end() ? *at : kNone;
}
std::string milliseconds(std::int64_t ns) {
  std::string text = std::to_string(static_cast<double>(ns) * 1e-6);
  return text.substr(0, text.find('.') + 4) + " ms";
}

/// Names of enumerations come as text or as their number.
std::string named(const Json& json, const char* member, std::span<const msg::ValueName> names) {
  const auto at = json.find(member);
  if (at != json.end() && at->is_number_integer())
    return std::string(msg::name_of(names, static_cast<std::uint32_t>(at->get<std::int64_t>())));
  return text_of(json, member);
}

}  // namespace

RobotReport::Said RobotReport::read(std::string_view robot, std::string_view status) {
  Said said;
  const Json json = Json::parse(status, nullptr, false);
  if (!json.is_object() || !json.contains("threads")) {
    said.diagnostics.push_back({Health::error, "robot", "its reply to status is none", std::string(robot), {}});
    return said;
  }
  /// How much a counter rose since the reply before.
  const auto rise = [this](const std::string& name, std::int64_t now) {
    const auto [at, is_new] = counts_.try_emplace(name, now);
    const std::int64_t before = at->second;
    at->second = now;
    return is_new ? 0 : now - before;
  };
  const auto add = [&](Health health, std::string name, std::string message,
                       std::vector<std::pair<std::string, std::string>> values) {
    said.diagnostics.push_back({health, std::move(name), std::move(message), std::string(robot), std::move(values)});
  };
  for (const Json& t : part_of(json, "threads")) {
    const std::string name = text_of(t, "name");
    const std::int64_t late = rise("t." + name, count_of(t, "overruns"));
    add(late > 0 ? Health::warn : Health::ok, "thread " + name,
        late > 0 ? std::to_string(late) + " overruns since the last report" : "",
        {{"completions", std::to_string(count_of(t, "completions"))},
         {"overruns", std::to_string(count_of(t, "overruns"))},
         {"lateness p99", milliseconds(count_of(part_of(t, "lateness"), "p99_ns"))},
         {"execution p99", milliseconds(count_of(part_of(t, "exec"), "p99_ns"))}});
  }
  for (const Json& m : part_of(json, "modules")) {
    const std::string name = text_of(m, "name");
    const std::int64_t faults = rise("f." + name, count_of(m, "fault")),
                       stale = rise("s." + name, count_of(m, "stale"));
    const bool running = part_of(m, "running").is_boolean() && part_of(m, "running").get<bool>();
    Health health = Health::ok;
    std::string message;
    if (!running) {
      health = Health::error, message = "does not run: disabled, or stopped after faults";
    } else if (faults > 0) {
      health = Health::error, message = std::to_string(faults) + " faults since the last report";
    } else if (stale > 0) {
      health = Health::warn, message = "inputs were missing or old in " + std::to_string(stale) + " steps";
    }
    add(health, "module " + name, message,
        {{"steps", std::to_string(count_of(m, "steps"))},
         {"stale", std::to_string(count_of(m, "stale"))},
         {"faults", std::to_string(count_of(m, "fault"))},
         {"execution p99", milliseconds(count_of(part_of(m, "exec"), "p99_ns"))}});
  }
  for (const Json& t : part_of(json, "topics")) {
    const std::string name = text_of(t, "name");
    const std::int64_t drops = rise("d." + name, count_of(t, "drops")),
                       came = rise("m." + name, count_of(t, "messages"));
    add(drops > 0 ? Health::warn : Health::ok, "topic " + name,
        drops > 0 ? std::to_string(drops) + " messages dropped since the last report" : "",
        {{"messages", std::to_string(count_of(t, "messages"))},
         {"since the last report", std::to_string(came)},
         {"drops", std::to_string(count_of(t, "drops"))}});
  }
  if (const Json& guardian = part_of(json, "guardian"); guardian.is_object() && !guardian.empty()) {
    const std::string mode = named(guardian, "mode", msg::kGuardianModeNames),
                      action = named(guardian, "action", msg::kFailsafeActionNames);
    std::string reasons;
    for (const Json& r : part_of(guardian, "reasons"))
      if (r.is_string()) reasons += (reasons.empty() ? "" : "; ") + r.get<std::string>();
    const bool acts = !action.empty() && action != "none";
    add(acts || mode == "safe" ? Health::error
        : reasons.empty()      ? Health::ok
                               : Health::warn,
        "guardian", acts ? "a failsafe acts: " + action : reasons,
        {{"mode", mode}, {"action", action}, {"not armed because", reasons}});
    if (mode != mode_ && !mode_.empty())
      said.lines.push_back({ros2::LogLevel::info, "guardian: " + mode_ + " -> " + mode});
    if (action != action_ && acts) said.lines.push_back({ros2::LogLevel::error, "a failsafe acts: " + action});
    if (reasons != reasons_ && !reasons.empty()) said.lines.push_back({ros2::LogLevel::info, "not armed: " + reasons});
    mode_ = mode, action_ = action, reasons_ = reasons;
  }
  if (const Json& devices = part_of(json, "devices"); devices.is_object() && !devices.empty()) {
    const std::string complaints = text_of(devices, "complaints");
    add(complaints.empty() ? Health::ok : Health::error, "devices", complaints, {});
    if (complaints != complaints_ && !complaints.empty())
      said.lines.push_back({ros2::LogLevel::warn, "devices: " + complaints});
    complaints_ = complaints;
  }
  return said;
}

}  // namespace sinew::net
