#include "apps/view/graph_json.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace sinew::app {
namespace {

using Json = nlohmann::ordered_json;
using rt::ThreadSpec;

const char* to_string(ThreadSpec::Trigger trigger) {
  switch (trigger) {
    case ThreadSpec::Trigger::period:
      return "period";
    case ThreadSpec::Trigger::topics:
      return "topics";
    case ThreadSpec::Trigger::device:
      return "device";
  }
  return "?";
}

const char* to_string(rt::Declaration::PortKind kind) {
  switch (kind) {
    case rt::Declaration::PortKind::latest:
      return "latest";
    case rt::Declaration::PortKind::queue:
      return "queue";
    case rt::Declaration::PortKind::output:
      return "output";
    case rt::Declaration::PortKind::raw:
      return "raw";
  }
  return "?";
}

Json name_of_topic(const rt::Graph& graph, std::uint32_t topic) {
  return topic == rt::kNone ? Json() : Json(graph.topics()[topic].name);
}

Json thread_json(const rt::Graph& graph, const rt::GraphThread& thread) {
  const ThreadSpec& t = thread.spec;
  Json j{{"name", t.name}, {"priority", t.priority}, {"trigger", to_string(t.trigger)}};
  if (t.trigger == ThreadSpec::Trigger::period) {
    j["period_us"] = static_cast<double>(t.period.count()) * 1e-3;
    j["phase_us"] = static_cast<double>(t.phase.count()) * 1e-3;
  }
  if (t.trigger == ThreadSpec::Trigger::topics)
    for (const auto& topic : t.topics) j["topics"].push_back(topic.value);
  if (t.trigger == ThreadSpec::Trigger::device) j["device"] = t.device_module;
  j["timeout_us"] = static_cast<double>(t.timeout.count()) * 1e-3;
  j["cpus"] = t.cpus;
  j["modules"] = Json::array();
  for (const std::uint32_t m : thread.modules) j["modules"].push_back(graph.modules()[m].spec.name);
  return j;
}

Json value_json(const rt::ParamValue& value) {
  return std::visit([](const auto& v) { return Json(v); }, value);
}

Json param_json(const rt::GraphModule& m, const rt::Declaration::Param& p) {
  const auto set = m.spec.params.find(p.name);
  Json j{{"name", p.name}, {"unit", p.unit}, {"default", value_json(p.default_value)}};
  j["value"] = set == m.spec.params.end() ? j["default"] : value_json(set->second.value);
  if (p.min > -std::numeric_limits<double>::max()) j["min"] = p.min;
  if (p.max < std::numeric_limits<double>::max()) j["max"] = p.max;
  j["doc"] = p.doc;
  return j;
}

Json module_json(const rt::Graph& graph, const rt::GraphModule& m) {
  Json j{{"name", m.spec.name}, {"type", m.spec.type}, {"thread", graph.threads()[m.thread].spec.name}};
  j["enabled"] = m.spec.enabled;
  j["ports"] = Json::array();
  for (std::size_t p = 0; p < m.declaration.ports.size(); ++p) {
    const auto& port = m.declaration.ports[p];
    j["ports"].push_back({{"name", port.name},
                          {"kind", to_string(port.kind)},
                          {"message", std::string(port.type->name)},
                          {"topic", name_of_topic(graph, m.topic[p])}});
  }
  j["params"] = Json::array();
  for (const auto& p : m.declaration.params) j["params"].push_back(param_json(m, p));
  return j;
}

Json topic_json(const rt::Graph& graph, std::uint32_t topic) {
  const auto& t = graph.topics()[topic];
  Json j{{"name", t.name}, {"message", std::string(t.type->name)}, {"writer", Json()}, {"readers", Json::array()}};
  if (t.writer != rt::kNone) j["writer"] = graph.modules()[t.writer].spec.name;
  for (const auto& m : graph.modules())
    for (std::size_t p = 0; p < m.topic.size(); ++p)
      if (m.topic[p] == topic && m.declaration.ports[p].output == nullptr) j["readers"].push_back(m.spec.name);
  return j;
}

}  // namespace

std::string graph_json(const rt::Graph& graph) {
  Json j{{"robot", graph.spec().robot}, {"board", graph.spec().board}};
  for (const char* key : {"threads", "modules", "topics", "chains", "actuators"}) j[key] = Json::array();
  for (const auto& thread : graph.threads()) j["threads"].push_back(thread_json(graph, thread));
  for (const auto& m : graph.modules()) j["modules"].push_back(module_json(graph, m));
  for (std::uint32_t t = 0; t < graph.topics().size(); ++t) j["topics"].push_back(topic_json(graph, t));
  for (const auto& c : graph.chains())
    j["chains"].push_back({{"name", c.spec.name},
                           {"from", c.spec.from.value},
                           {"to", c.spec.to.value},
                           {"budget_ns", c.spec.budget.count()}});
  for (const auto& a : graph.spec().actuators) {
    Json limits = Json::array();  // of each channel
    for (std::uint32_t i = 0; i < a.channels; ++i) limits.push_back({a.limit(i).min, a.limit(i).max});
    j["actuators"].push_back({{"name", a.name},
                              {"command", a.command.value},
                              {"channels", a.channels},
                              {"limit", std::move(limits)},
                              {"lease_ns", a.lease.count()}});
  }
  return j.dump();
}

std::string check_json(const std::string& path, rt::Graph* graph, const std::vector<PlacedProblem>& problems) {
  Json j{{"file", path}, {"ok", problems.empty()}, {"problems", Json::array()}};
  for (const auto& [file, p] : problems) {
    Json one{{"line", std::max(p.line, 0)}, {"key", p.key}, {"value", p.value}, {"allowed", p.allowed}};
    if (file != path) one["file"] = file;
    j["problems"].push_back(std::move(one));
  }
  if (!graph || !graph->make_plan({})) return j.dump();
  j["robot"] = graph->spec().robot;
  j["threads"] = graph->threads().size();
  j["modules"] = graph->modules().size();
  j["chains"] = graph->chains().size();
  j["topics"] = Json::array();
  for (std::uint32_t t = 0; t < graph->topics().size(); ++t) {
    const rt::SlotSum s = graph->slots(t);
    j["topics"].push_back({{"name", graph->topics()[t].name},
                           {"slots", s.total()},
                           {"loans", s.burst},
                           {"keep", s.keep},
                           {"pins", s.pins},
                           {"pending", s.pending},
                           {"bytes", s.total() * graph->plan().slot_stride(graph->topic_id(t))}});
  }
  j["segment_bytes"] = graph->plan().bytes();
  return j.dump();
}

}  // namespace sinew::app
