#include <algorithm>

#include "math/elementary.hpp"
#include "msg/actuators.hpp"
#include "msg/all.hpp"
#include "rt/graph_check.hpp"
#include "rt/parameters.hpp"

namespace sinew::rt {
namespace {

using PortKind = Declaration::PortKind;

bool has_stamp(const msg::TypeInfo& type) {
  return std::any_of(type.fields.begin(), type.fields.end(),
                     [](const msg::FieldInfo& f) { return f.name == "stamp" && f.is_time && !f.is_array; });
}

}  // namespace

std::string GraphCheck::topic_candidates(const msg::TypeInfo* type, std::string_view asked) const {
  std::vector<std::string> names;
  for (const GraphTopic& t : graph_.topics())
    if ((!type || t.type == type) && !is_ground_truth(t.name)) names.push_back(t.name);
  const std::string what = type ? "a topic of " + std::string(type->name) : "a topic";
  return what + (names.empty() ? "; no module writes one" : ": " + listed_for(asked, names));
}

bool is_ground_truth(std::string_view topic) {
  return topic.starts_with(kGroundTruth) && (topic.size() == kGroundTruth.size() || topic[kGroundTruth.size()] == '.');
}

bool GraphCheck::acts_by_truth(int line, const std::string& key, const std::string& topic) {
  if (!is_ground_truth(topic)) return false;
  add(line, key, quoted(topic),
      "another topic: ground_truth is the simulator's truth, for reports only; a robot has none to act by");
  return true;
}

void GraphCheck::bindings(const GraphModule& m) {
  if (m.guardian) return;  // actuators() reports them in the words of the robot file
  std::vector<std::string> inputs, seen;
  for (std::uint32_t p = 0; p < m.declaration.ports.size(); ++p) {
    const Declaration::Port& port = m.declaration.ports[p];
    if (port.is_input()) {
      inputs.push_back(port.name);
      binding(m, p);
    }
    if (std::find(seen.begin(), seen.end(), port.name) != seen.end())
      add(m.spec.line, "module." + m.spec.name, quoted(port.name),
          "port names of " + m.spec.type + " that differ; two writers of one topic are not possible");
    seen.push_back(port.name);
  }
  for (const auto& [name, topic] : m.spec.in)
    if (std::find(inputs.begin(), inputs.end(), name) == inputs.end())
      add(topic.line ? topic.line : m.spec.line, "module." + m.spec.name + ".in." + name, quoted(topic.value),
          inputs.empty() ? m.spec.type + " has no inputs"
                         : "an input of " + m.spec.type + ": " + listed_for(name, inputs));
}

void GraphCheck::binding(const GraphModule& m, std::uint32_t p) {
  const Declaration::Port& port = m.declaration.ports[p];
  const std::string key = "module." + m.spec.name + ".in." + port.name;
  const auto given = m.spec.in.find(port.name);
  if (given == m.spec.in.end()) {
    if (!port.optional) add(m.spec.line, key, "missing", topic_candidates(port.type));
    return;
  }
  const int line = given->second.line ? given->second.line : m.spec.line;
  if (acts_by_truth(line, key, given->second.value)) return;
  if (m.topic[p] == kNone) {
    add(line, key, quoted(given->second.value), topic_candidates(port.type, given->second.value));
    return;
  }
  const GraphTopic& topic = graph_.topics()[m.topic[p]];
  if (topic.type != port.type)
    add(line, key, quoted(topic.name) + " of " + std::string(topic.type->name), topic_candidates(port.type));
  else
    previous(m, p);
  max_age(m, p, line);
}

void GraphCheck::max_age(const GraphModule& m, std::uint32_t p, int line) {
  const Declaration::Port& port = m.declaration.ports[p];
  const std::string key = "module." + m.spec.name + ".in." + port.name + ".max_age_ms";
  const bool given = port.expires != Duration{INT64_MAX};
  if (given && port.kind == PortKind::latest && port.type && !has_stamp(*port.type))
    add(line, key, in_ms(port.expires), "none: " + std::string(port.type->name) + " has no stamp");
  if (given && port.kind != PortKind::latest)
    add(line, key, in_ms(port.expires), "none: " + port.name + " is a queue of what came since the last step");
  if (given && port.kind == PortKind::latest && (port.expires < Duration{1'000'000} || port.expires > kLongestPeriod))
    add(line, key, in_ms(port.expires), "a number from 1 to 3600000");
  if (!given && port.kind == PortKind::latest && is_remote(graph_.topics()[m.topic[p]].name))
    add(line, key, "missing",
        "a number from 1 to 3600000: a mate may fall silent, and an older message is then not there");
}

void GraphCheck::previous(const GraphModule& m, std::uint32_t p) {
  const Declaration::Port& port = m.declaration.ports[p];
  const GraphModule& writer = graph_.modules()[graph_.topics()[m.topic[p]].writer];
  if (writer.thread == kNone || m.thread == kNone) return;  // reported already
  const bool later = writer.thread == m.thread && writer.position >= m.position;
  if (later == port.previous) return;
  const auto& given = m.spec.in.find(port.name)->second;
  const std::string& thread = graph_.threads()[m.thread].spec.name;
  add(given.line ? given.line : m.spec.line, "module." + m.spec.name + ".in." + port.name, quoted(given.value),
      later ? "a topic of another thread or of a module before " + m.spec.name + " in thread " + thread +
                  "; this input is not declared `previous`"
            : "a topic of " + m.spec.name + " or of a module after it in thread " + thread +
                  "; this input is declared `previous`");
}

void GraphCheck::topics() {
  for (std::size_t i = 0; i < graph_.topics().size(); ++i) {
    const GraphTopic& t = graph_.topics()[i];
    const GraphModule& writer = graph_.modules()[t.writer];
    if (!writer.declaration.ports[t.port].type)
      add(writer.spec.line, "topic." + t.name, "no type", "an input that has a type and reads it");
    if (t.type->has_bulk() && t.image_bytes == 0)
      add(writer.spec.line, "topic." + t.name + ".image", "missing",
          "width, height and format: " + t.name + " carries " + std::string(t.type->name));
    for (std::size_t j = 0; j < i; ++j)
      if (graph_.topics()[j].name == t.name) {
        add(writer.spec.line, "topic." + t.name, "two writers", "one writer; give the modules different names");
        break;
      }
  }
  for (const TopicSpec& s : graph_.spec().topics) {
    if (s.external) external(s);
    const std::uint32_t topic = graph_.find_topic(s.name);
    if (topic == kNone) {
      if (!s.external) add(s.line, "topic." + s.name, quoted(s.name), topic_candidates(nullptr, s.name));
    } else if (s.image_bytes > 0 && !graph_.topics()[topic].type->has_bulk()) {
      add(s.line, "topic." + s.name + ".image", std::to_string(s.image_bytes) + " bytes",
          "none: " + s.name + " carries " + std::string(graph_.topics()[topic].type->name));
    }
  }
}

/// What the graph could not resolve, or took over silently: type, thread and name of an external topic.
void GraphCheck::external(const TopicSpec& s) {
  const std::string key = "topic." + s.name;
  const auto parts = split_topic(s.name);
  if (!is_name(parts.first) || !is_name(parts.second))
    add(s.line, key, quoted(s.name), "a name as source.port, each of a-z, 0-9 and _");
  const msg::TypeInfo* type = graph_.message_type(s.external->type);
  if (!type) {
    std::vector<std::string> known;
    for (const msg::TypeInfo* t : msg::all_types()) known.emplace_back(t->name);
    add(s.line, key + ".type", s.external->type.empty() ? "missing" : quoted(s.external->type),
        "a message type: " + listed_for(s.external->type, known));
  }
  std::vector<std::string> threads;
  for (const GraphThread& t : graph_.threads())
    if (graph_.spec().actuators.empty() || &t != &graph_.threads()[0]) threads.push_back(t.spec.name);
  if (std::find(threads.begin(), threads.end(), s.external->thread) == threads.end())
    add(s.line, key + ".thread", s.external->thread.empty() ? "missing" : quoted(s.external->thread),
        "a thread: " + listed_for(s.external->thread, threads));
  for (const TopicSpec& first : graph_.spec().topics) {
    if (!first.external || split_topic(first.name).first != parts.first) continue;
    if (first.external->thread != s.external->thread)
      add(s.line, key + ".thread", quoted(s.external->thread),
          quoted(first.external->thread) + ", as of " + first.name + ": topics of one source come in with one thread");
    break;
  }
}

void GraphCheck::actuators() {
  using namespace std::chrono_literals;
  constexpr std::uint32_t kMost = kMaxOutputs - 1;  // each has an output of the guardian, which has one more
  if (graph_.spec().actuators.size() > kMost)
    add(graph_.spec().actuators.back().line, "actuator", std::to_string(graph_.spec().actuators.size()),
        "at most " + std::to_string(kMost));
  for (const ActuatorSpec& a : graph_.spec().actuators) {
    const std::string key = "actuator." + a.name;
    if (a.name == "state") add(a.line, key, quoted(a.name), "another name; guardian.state is the guardian's own topic");
    actuator_command(a);
    if (a.channels < 1 || a.channels > msg::kMaxChannels)
      add(a.channels_line ? a.channels_line : a.line, key + ".channels", std::to_string(a.channels),
          "an integer from 1 to " + std::to_string(msg::kMaxChannels));
    actuator_limits(a);
    if (!math::is_finite(a.rate_per_s) || a.rate_per_s < 0)
      add(a.line, key + ".rate_per_s", format_number(a.rate_per_s), "a number from 0 up; 0: no limit");
    if (a.lease < 100us || a.lease > 10s)
      add(a.line, key + ".lease_ms", format_number(static_cast<double>(a.lease.count()) / 1e6),
          "a number from 0.1 to 10000");
  }
}

void GraphCheck::actuator_limits(const ActuatorSpec& a) {
  const int line = a.limit_line ? a.limit_line : a.line;
  const std::string key = "actuator." + a.name + ".limit";
  const std::size_t ranges = a.channel_limits.size();
  if (ranges != 0 && ranges != a.channels)
    add(line, key, std::to_string(ranges) + " ranges",
        "[smallest, largest] for all channels, or " + std::to_string(a.channels) + " of them, one for each");
  for (std::uint32_t i = 0; i < std::max<std::size_t>(ranges, 1); ++i) {
    const ActuatorSpec::Range r = a.limit(i);
    if (!math::is_finite(r.min) || !math::is_finite(r.max) || r.min > r.max)
      add(line, key, "[ " + format_number(r.min) + ", " + format_number(r.max) + " ]",
          "[smallest, largest], two numbers in this order");
  }
}

void GraphCheck::actuator_command(const ActuatorSpec& a) {
  const msg::TypeInfo& wanted = msg::type_info<msg::ActuatorCommand>();
  const std::uint32_t topic = graph_.find_topic(a.command.value);
  const int line = a.command.line ? a.command.line : a.line;
  if (topic == kNone)
    add(line, "actuator." + a.name + ".command", quoted(a.command.value), topic_candidates(&wanted, a.command.value));
  else if (graph_.topics()[topic].type != &wanted)
    add(line, "actuator." + a.name + ".command",
        quoted(a.command.value) + " of " + std::string(graph_.topics()[topic].type->name), topic_candidates(&wanted));
  else
    actuator_channels(a, graph_.topics()[topic]);
}

void GraphCheck::actuator_channels(const ActuatorSpec& a, const GraphTopic& command) {
  const GraphModule& writer = graph_.modules()[command.writer];
  const std::uint32_t has = writer.declaration.ports[command.port].channels;
  if (has != 0 && has != a.channels)
    add(a.channels_line ? a.channels_line : a.line, "actuator." + a.name + ".channels", std::to_string(a.channels),
        std::to_string(has) + ", as " + command.name + " of " + writer.spec.type + " has");
}

void GraphCheck::chains() {
  if (graph_.chains().size() > kMaxChains)
    add(graph_.chains()[kMaxChains].spec.line, "chain", std::to_string(graph_.chains().size()),
        "at most " + std::to_string(kMaxChains));
  for (std::uint32_t c = 0; c < graph_.chains().size(); ++c) {
    const GraphChain& chain = graph_.chains()[c];
    const std::string key = "chain." + chain.spec.name;
    const auto endpoint = [&](const char* end, const Located<std::string>& name, std::uint32_t topic) {
      if (topic == kNone)
        add(name.line ? name.line : chain.spec.line, key + "." + end, quoted(name.value),
            topic_candidates(nullptr, name.value));
    };
    endpoint("from", chain.spec.from, chain.from);
    endpoint("to", chain.spec.to, chain.to);
    if (chain.spec.budget < Duration{0})
      add(chain.spec.line, key + ".budget_ms", format_number(static_cast<double>(chain.spec.budget.count()) / 1e6),
          "a number from 0 up; 0: no budget");
    if (!(chain.spec.allowed_misses >= 0 && chain.spec.allowed_misses <= 1))
      add(chain.spec.line, key + ".allowed_misses", format_number(chain.spec.allowed_misses), "a number from 0 to 1");
    if (c >= kMaxChains || chain.from == kNone || chain.to == kNone || chain.from == chain.to) continue;
    const auto& ports = graph_.modules()[graph_.topics()[chain.to].writer].carried_chains;
    if (std::none_of(ports.begin(), ports.end(), [&](std::uint32_t chains) { return chains >> c & 1; }))
      add(chain.spec.to.line ? chain.spec.to.line : chain.spec.line, key + ".to", quoted(chain.spec.to.value),
          "a topic that " + chain.spec.from.value + " leads to");
  }
}

}  // namespace sinew::rt
