#include "apps/view/graph_text.hpp"

#include <fmt/format.h>

#include "rt/safety_text.hpp"

namespace sinew::app {
namespace {

using rt::ThreadSpec;

std::string trigger_text(const ThreadSpec& t) {
  std::string text;
  switch (t.trigger) {
    case ThreadSpec::Trigger::period:
      text = "every " + human(t.period);
      if (t.phase.count() > 0) text += " from " + human(t.phase);
      text +=
          t.overrun == ThreadSpec::Overrun::skip ? ", skips when late" : fmt::format(", catches up {}", t.catch_up_max);
      return text;
    case ThreadSpec::Trigger::topics:
      text = "on";
      for (const auto& topic : t.topics) text += " " + topic.value;
      break;
    case ThreadSpec::Trigger::device:
      text = "when the device of " + t.device_module + " is ready";
      break;
  }
  if (t.timeout.count() > 0) text += ", at the latest after " + human(t.timeout);
  return text;
}

std::string cpus_text(const std::vector<int>& cpus) {
  if (cpus.empty()) return "any CPU";
  return fmt::format("CPU {}", fmt::join(cpus, ","));
}

bool reads(const rt::Declaration::Port& p) { return p.output == nullptr; }

std::string port_line(const rt::Graph& graph, const rt::GraphModule& m, std::size_t port) {
  const auto& p = m.declaration.ports[port];
  const std::uint32_t topic = m.topic[port];
  const std::string name = topic == rt::kNone ? "(unbound)" : graph.topics()[topic].name;
  const auto age = m.spec.max_age.find(p.name);
  switch (p.kind) {
    case rt::Declaration::PortKind::latest:
      if (age != m.spec.max_age.end())
        return fmt::format("<~ {:<10} {} (at most {} old)", p.name, name, human(age->second));
      if (rt::is_remote(name)) return fmt::format("<~ {:<10} {}", p.name, name);
      return fmt::format("<- {:<10} {}", p.name, name);
    case rt::Declaration::PortKind::queue:
      return fmt::format("{} {:<10} {} (queue of {})", rt::is_remote(name) ? "<~" : "<-", p.name, name, p.depth);
    case rt::Declaration::PortKind::output:
      return fmt::format("-> {:<10} {} : {}", p.name, name, p.type->name);
    case rt::Declaration::PortKind::raw:
      return fmt::format("=> {:<10} {} : {}", p.name, name, p.type->name);
  }
  return {};
}

}  // namespace

std::string human(rt::Duration d) {
  const double ns = static_cast<double>(d.count());
  if (d.count() < 0) return "-" + human(-d);
  // Three digits: what would round to 1000 of a unit is 1 of the next.
  if (ns < 999.5) return fmt::format("{:.3g} ns", ns);
  if (ns < 999.5e3) return fmt::format("{:.3g} us", ns * 1e-3);
  if (ns < 999.5e6) return fmt::format("{:.3g} ms", ns * 1e-6);
  return fmt::format("{:.3g} s", ns * 1e-9);
}

std::string graph_tree(const rt::Graph& graph) {
  std::string out = fmt::format("robot {} on board {}\n", graph.spec().robot, graph.spec().board);
  for (const auto& thread : graph.threads()) {
    const ThreadSpec& t = thread.spec;
    out += fmt::format("+- thread {}: priority {}, {}, {}\n", t.name, t.priority, trigger_text(t), cpus_text(t.cpus));
    for (const std::uint32_t index : thread.modules) {
      const auto& m = graph.modules()[index];
      out += fmt::format("|  +- {} ({})\n", m.spec.name, m.spec.type);
      for (std::size_t p = 0; p < m.declaration.ports.size(); ++p)
        out += fmt::format("|  |    {}\n", port_line(graph, m, p));
    }
  }
  for (const auto& chain : graph.chains())
    out += fmt::format("+- chain {}: {} to {}, at most {} old\n", chain.spec.name, chain.spec.from.value,
                       chain.spec.to.value, human(chain.spec.budget));
  for (const auto& a : graph.spec().actuators) {
    std::string limits = fmt::format("[{}, {}]", a.min, a.max);
    if (!a.channel_limits.empty()) limits.clear();
    for (const auto& range : a.channel_limits)
      limits += fmt::format("{}[{}, {}]", limits.empty() ? "" : " ", range.min, range.max);
    out += fmt::format("+- actuator {}: {} channels of {} in {}, lease {}\n", a.name, a.channels, a.command.value,
                       limits, human(a.lease));
  }
  for (const auto& f : graph.spec().failsafes) out += fmt::format("+- failsafe {}: {}\n", f.name, rt::to_string(f));
  return out;
}

std::string slot_table(rt::Graph& graph) {
  if (!graph.make_plan({})) return {};
  std::string out = fmt::format("{:<24} {:>6} = {:>5} + {:>4} + {:>4} + {:>7} {:>12}\n", "slots of topic", "total",
                                "loans", "keep", "pins", "pending", "bytes");
  for (std::uint32_t t = 0; t < graph.topics().size(); ++t) {
    const rt::SlotSum s = graph.slots(t);
    out += fmt::format("{:<24} {:>6} = {:>5} + {:>4} + {:>4} + {:>7} {:>12}\n", graph.topics()[t].name, s.total(),
                       s.burst, s.keep, s.pins, s.pending, s.total() * graph.plan().slot_stride(graph.topic_id(t)));
  }
  return out + fmt::format("segment: {} bytes\n", graph.plan().bytes());
}

std::string graph_dot(const rt::Graph& graph) {
  std::string out =
      fmt::format("digraph \"{}\" {{\n  rankdir=LR;\n  node [shape=box, style=rounded];\n", graph.spec().robot);
  for (std::size_t i = 0; i < graph.threads().size(); ++i) {
    const auto& thread = graph.threads()[i];
    out += fmt::format("  subgraph cluster_{} {{\n    label=\"{}: priority {}, {}\";\n", i, thread.spec.name,
                       thread.spec.priority, trigger_text(thread.spec));
    for (const std::uint32_t m : thread.modules)
      out += fmt::format("    \"{}\" [label=\"{}\\n{}\"];\n", graph.modules()[m].spec.name,
                         graph.modules()[m].spec.name, graph.modules()[m].spec.type);
    out += "  }\n";
  }
  for (const auto& m : graph.modules()) {
    for (std::size_t p = 0; p < m.declaration.ports.size(); ++p) {
      if (!reads(m.declaration.ports[p]) || m.topic[p] == rt::kNone) continue;
      const auto& topic = graph.topics()[m.topic[p]];
      if (topic.writer == rt::kNone) continue;
      out += fmt::format("  \"{}\" -> \"{}\" [label=\"{}\"{}];\n", graph.modules()[topic.writer].spec.name, m.spec.name,
                         topic.name, rt::is_remote(topic.name) ? ", style=dashed" : "");
    }
  }
  return out + "}\n";
}

}  // namespace sinew::app
