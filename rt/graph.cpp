#include "rt/graph.hpp"

#include <algorithm>
#include <map>

#include "msg/all.hpp"
#include "msg/safety.hpp"
#include "rt/external_source.hpp"
#include "rt/graph_check.hpp"
#include "rt/guardian.hpp"

namespace sinew::rt {
namespace {

using PortKind = Declaration::PortKind;

template <class Container, class Name>
std::uint32_t find_by_name(const Container& all, std::string_view name, Name&& name_of) {
  for (std::size_t i = 0; i < all.size(); ++i)
    if (name_of(all[i]) == name) return static_cast<std::uint32_t>(i);
  return kNone;
}

}  // namespace

Graph::Graph(GraphSpec spec, const ModuleTypes& types) : spec_(std::move(spec)), known_types_(types.names()) {
  if (!spec_.actuators.empty()) add_guardian();
  for (const ModuleSpec& m : spec_.modules) add_module(m, m.make ? m.make() : types.make(m.type));
  for (const ThreadSpec& t : spec_.threads) threads_.push_back({t, {}, kNone});
  add_external_sources();
  resolve_topics();
  resolve_threads();
  resolve_outputs();
  resolve_inputs();
  resolve_chains();
}

Graph::~Graph() = default;

std::vector<Problem> Graph::check(const CheckOptions& options) const {
  return GraphCheck(*this, known_types_, options).run();
}

std::uint32_t Graph::find_module(std::string_view name) const {
  return find_by_name(
      modules_, name, [](const auto& m) -> auto& { return m.spec.name; });
}
std::uint32_t Graph::find_topic(std::string_view name) const {
  return find_by_name(
      topics_, name, [](const auto& t) -> auto& { return t.name; });
}
std::uint32_t Graph::find_thread(std::string_view name) const {
  return find_by_name(
      threads_, name, [](const auto& t) -> auto& { return t.spec.name; });
}

void Graph::add_guardian() {
  ThreadSpec t;
  t.name = "guardian";
  t.priority = spec_.guardian.priority;
  t.cpus = spec_.guardian.cpus;
  t.stack_kib = 128;  // enough: it compares numbers and hands them to devices
  t.trigger = ThreadSpec::Trigger::topics;
  t.timeout = Guardian::check_interval(spec_.actuators);
  t.order.push_back({"guardian", spec_.guardian.line});
  t.line = spec_.guardian.line;
  ModuleSpec m;
  m.name = "guardian";
  m.type = "rt::Guardian";
  m.exec = spec_.guardian.exec;
  m.line = spec_.guardian.line;
  for (const ActuatorSpec& a : spec_.actuators) {
    t.topics.push_back(a.command);
    m.in.emplace(a.name + "_command", a.command);
  }
  for (const FailsafeSpec& f : spec_.failsafes) m.in.emplace(Failsafe::port_name(f), f.topic);
  threads_.push_back({std::move(t), {}, kNone});
  add_module(std::move(m), std::make_unique<Guardian>(spec_));
}

/// One module for all external topics with the same first part, at the front of their thread.
void Graph::add_external_sources() {
  std::vector<const TopicSpec*> first;  // of each source, in the order of the file
  std::map<std::string_view, std::vector<ExternalSource::Topic>> ports;
  for (const TopicSpec& t : spec_.topics) {
    if (!t.external) continue;
    const auto [source, port] = split_topic(t.name);
    if (!ports.contains(source)) first.push_back(&t);
    const msg::TypeInfo* type = message_type(t.external->type);
    std::vector<ExternalSource::Topic>& of_source = ports[source];
    if (type) of_source.push_back({std::string(port), type, t.image_pixels > 0 ? t.image_pixels : t.image_bytes});
  }
  for (auto t = first.rbegin(); t != first.rend(); ++t) {
    ModuleSpec m;
    m.name = split_topic((*t)->name).first;
    m.type = "rt::ExternalSource";
    m.exec = (*t)->external->exec;
    m.line = (*t)->line;
    for (std::size_t i = spec_.actuators.empty() ? 0 : 1; i < threads_.size(); ++i)  // never the guardian's
      if (ThreadSpec& thread = threads_[i].spec; thread.name == (*t)->external->thread)
        thread.order.insert(thread.order.begin(), {m.name, m.line});
    auto module = std::make_unique<ExternalSource>(ports.at(m.name));
    add_module(std::move(m), std::move(module));
  }
}

const msg::TypeInfo* Graph::message_type(std::string_view name) const {
  if (const msg::TypeInfo* known = msg::find_type(name)) return known;
  for (const GraphModule& m : modules_)
    for (const Declaration::Port& p : m.declaration.ports)
      if (p.type && p.type->name == name) return p.type;
  return nullptr;
}

void Graph::add_module(ModuleSpec spec, std::unique_ptr<Module> module) {
  GraphModule m;
  m.spec = std::move(spec);
  m.module = std::move(module);
  m.driver = dynamic_cast<DriverModule*>(m.module.get());
  m.guardian = dynamic_cast<Guardian*>(m.module.get());
  m.external = dynamic_cast<ExternalSource*>(m.module.get());
  if (m.module) m.module->declare(m.declaration);
  m.topic.assign(m.declaration.ports.size(), kNone);
  m.carried_chains.assign(m.declaration.ports.size(), 0);
  modules_.push_back(std::move(m));
}

void Graph::resolve_topics() {
  for (std::uint32_t i = 0; i < modules_.size(); ++i) {
    GraphModule& m = modules_[i];
    for (std::uint32_t p = 0; p < m.declaration.ports.size(); ++p) {
      const Declaration::Port& port = m.declaration.ports[p];
      if (port.is_input()) continue;
      GraphTopic t;
      t.name = topic_name(m.spec.name, port.name);
      t.type = port.type;
      t.writer = i;
      t.port = p;
      m.topic[p] = static_cast<std::uint32_t>(topics_.size());
      for (const TopicSpec& s : spec_.topics)
        if (s.name == t.name) {
          t.image_bytes = s.image_bytes, t.history = s.history;
          t.image_pixels = s.image_pixels > 0 ? s.image_pixels : s.image_bytes;
          t.wake_outsiders = s.wake_outsiders;
        }
      topics_.push_back(std::move(t));
    }
  }
}

void Graph::resolve_threads() {
  for (std::uint32_t i = 0; i < threads_.size(); ++i) {
    GraphThread& t = threads_[i];
    for (const auto& name : t.spec.order) {
      const std::uint32_t m = find_module(name.value);
      if (m == kNone) continue;
      if (modules_[m].thread == kNone) {
        modules_[m].thread = i;
        modules_[m].position = static_cast<std::uint32_t>(t.modules.size());
      }
      t.modules.push_back(m);
    }
    if (t.spec.trigger == ThreadSpec::Trigger::device) t.device_module = find_module(t.spec.device_module);
    if (t.spec.trigger != ThreadSpec::Trigger::topics) continue;
    for (const auto& name : t.spec.topics) {
      const std::uint32_t topic = find_topic(name.value);
      if (topic == kNone) continue;
      std::vector<std::uint32_t>& triggers = topics_[topic].triggers;
      if (std::find(triggers.begin(), triggers.end(), i) == triggers.end()) triggers.push_back(i);
    }
  }
}

/// An output without a type has that of the first input, in the order of the modules, that reads it and has one.
void Graph::resolve_outputs() {
  for (GraphTopic& topic : topics_) {
    if (topic.type) continue;
    Declaration::Port& output = modules_[topic.writer].declaration.ports[topic.port];
    for (const GraphModule& m : modules_)
      for (const Declaration::Port& p : m.declaration.ports) {
        const auto bound = m.spec.in.find(p.name);
        if (!topic.type && p.is_input() && bound != m.spec.in.end() && bound->second.value == topic.name)
          topic.type = p.type;
      }
    if (topic.type)
      output.type = static_cast<AnyOut*>(output.output)->type_ = topic.type;
    else  // any type, so that every topic has one; check() refuses the graph
      topic.type = &msg::type_info<msg::SafetyState>();
  }
}

void Graph::resolve_inputs() {
  for (GraphModule& m : modules_)
    for (std::uint32_t p = 0; p < m.declaration.ports.size(); ++p) {
      const auto bound = m.spec.in.find(m.declaration.ports[p].name);
      Declaration::Port& port = m.declaration.ports[p];
      if (!port.is_input() || bound == m.spec.in.end()) continue;
      m.topic[p] = find_topic(bound->second.value);
      if (const auto age = m.spec.max_age.find(port.name); age != m.spec.max_age.end()) port.expires = age->second;
      if (port.type || m.topic[p] == kNone) continue;
      port.type = topics_[m.topic[p]].type;
      static_cast<AnyIn*>(port.input)->type_ = port.type;
    }
}

}  // namespace sinew::rt
