#include "rt/graph_check.hpp"

#include <algorithm>

#include "hal/did_you_mean.hpp"
#include "rt/parameters.hpp"

namespace sinew::rt {
namespace {

using namespace std::chrono_literals;
using Trigger = ThreadSpec::Trigger;

constexpr Duration kLongest = kLongestPeriod;
constexpr const char* kNameRule = "a name of a-z, 0-9 and _";

}  // namespace

bool is_name(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

std::string in_us(Duration d) { return format_number(static_cast<double>(d.count()) / 1e3); }

std::string in_ms(Duration d) { return format_number(static_cast<double>(d.count()) / 1e6); }

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& w : words) text += (text.empty() ? "" : " ") + w;
  return text;
}

std::string listed_for(std::string_view asked, const std::vector<std::string>& words) {
  return listed(words) + hal::did_you_mean(asked, words);
}

std::vector<Problem> GraphCheck::run() {
  names();
  threads();
  modules();
  topics();
  actuators();
  chains();
  failsafes();
  std::stable_sort(problems_.begin(), problems_.end(), [](const auto& a, const auto& b) { return a.line < b.line; });
  return std::move(problems_);
}

template <class Container, class NameAndLine>
void GraphCheck::unique(const Container& all, std::string_view kind, NameAndLine&& of) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto [name, line] = of(all[i]);
    const std::string key = std::string(kind) + "." + name;
    if (kind != "topic" && !is_name(name)) add(line, key, quoted(name), kNameRule);
    for (std::size_t j = 0; j < i; ++j)
      if (of(all[j]).first == name) {
        add(line, key, quoted(name), "a name that no other " + std::string(kind) + " has");
        break;
      }
  }
}

void GraphCheck::names() {
  const auto name_and_line = [](const auto& x) { return std::pair<std::string, int>(x.name, x.line); };
  const auto inside = [](const auto& x) { return std::pair<std::string, int>(x.spec.name, x.spec.line); };
  unique(graph_.threads(), "thread", inside);
  unique(graph_.modules(), "module", inside);
  unique(graph_.spec().topics, "topic", name_and_line);
  unique(graph_.spec().actuators, "actuator", name_and_line);
  unique(graph_.spec().chains, "chain", name_and_line);
  unique(graph_.spec().failsafes, "failsafe", name_and_line);
}

void GraphCheck::threads() {
  if (graph_.threads().empty()) add(0, "thread", "missing", "at least one [[thread]]");
  for (const GraphThread& t : graph_.threads()) {
    priority(t.spec);
    trigger(t);
    const bool guardian = !graph_.spec().actuators.empty() && &t == &graph_.threads()[0];
    cpus(guardian ? "guardian.cpus" : "thread." + t.spec.name + ".cpus", t.spec.cpus, t.spec.line);
    if (t.spec.stack_kib < 16 || t.spec.stack_kib > 65536)
      add(t.spec.line, "thread." + t.spec.name + ".stack_kib", std::to_string(t.spec.stack_kib),
          "an integer from 16 to 65536");
    order(t);
  }
  const std::uint32_t cores = graph_.spec().virtual_cores;
  if (cores < 1 || cores > 64) add(0, "robot.virtual_cores", std::to_string(cores), "an integer from 1 to 64");
}

void GraphCheck::priority(const ThreadSpec& t) {
  const bool guarded = !graph_.spec().actuators.empty();
  if (guarded && &t == &graph_.threads()[0].spec) {
    if (t.priority < 1 || t.priority > 99)
      add(t.line, "guardian.priority", std::to_string(t.priority), "an integer from 1 to 99");
    return;
  }
  const int guardian = graph_.spec().guardian.priority;
  const int highest = guarded ? std::clamp(guardian - 1, 0, 98) : 98;
  if (t.priority >= 0 && t.priority <= highest) return;
  add(t.line, "thread." + t.name + ".priority", std::to_string(t.priority),
      "an integer from 0 to " + std::to_string(highest) +
          (guarded ? "; the guardian has " + std::to_string(guardian) : std::string()));
}

void GraphCheck::trigger(const GraphThread& thread) {
  const ThreadSpec& t = thread.spec;
  const std::string key = "thread." + t.name;
  const bool periodic = t.trigger == Trigger::period;
  if (periodic && (t.period < kShortestPeriod || t.period > kLongest))
    add(t.line, key + ".period_us", in_us(t.period), "a number from 10 to 3600000000");
  if (t.phase < 0ns || t.phase > kLongest)
    add(t.line, key + ".phase_us", in_us(t.phase), "a number from 0 to 3600000000");
  if (t.timeout < 0ns || t.timeout > kLongest)
    add(t.line, key + ".timeout_us", in_us(t.timeout), "a number from 0 to 3600000000");
  else if (periodic && t.timeout > 0ns)
    add(t.line, key + ".timeout_us", in_us(t.timeout), "none; a thread with period_us is released by its period alone");
  if (periodic && t.overrun == ThreadSpec::Overrun::catch_up && (t.catch_up_max < 1 || t.catch_up_max > 1000))
    add(t.line, key + ".catch_up_max", std::to_string(t.catch_up_max), "an integer from 1 to 1000");

  if (t.trigger == Trigger::topics) {
    const bool guardian = &thread == &graph_.threads()[0] && !graph_.spec().actuators.empty();
    if (t.topics.empty()) add(t.line, key + ".trigger", "missing", topic_candidates(nullptr));
    for (const auto& name : t.topics) {
      const std::uint32_t topic = graph_.find_topic(name.value);
      const int line = name.line ? name.line : t.line;
      if (acts_by_truth(line, key + ".trigger", name.value)) continue;
      if (topic == kNone) {
        if (!guardian) add(line, key + ".trigger", quoted(name.value), topic_candidates(nullptr, name.value));
      } else if (graph_.modules()[graph_.topics()[topic].writer].thread != kNone &&
                 &graph_.threads()[graph_.modules()[graph_.topics()[topic].writer].thread] == &thread) {
        add(line, key + ".trigger", quoted(name.value), "a topic that this thread does not write itself");
      }
    }
  }
  if (t.trigger == Trigger::device) {
    std::vector<std::string> drivers;
    for (const std::uint32_t m : thread.modules)
      if (graph_.modules()[m].driver) drivers.push_back(graph_.modules()[m].spec.name);
    if (std::find(drivers.begin(), drivers.end(), t.device_module) == drivers.end())
      add(t.line, key + ".device", quoted(t.device_module),
          "a driver module in `order`" +
              (drivers.empty() ? "; there is none" : ": " + listed_for(t.device_module, drivers)));
  }
}

void GraphCheck::cpus(const std::string& key, const std::vector<int>& cpus, int line) {
  std::uint32_t cores = options_.cpus ? options_.cpus : 1024u;
  if (options_.virtual_time) cores = std::min(graph_.spec().virtual_cores, 64u);
  const int count = static_cast<int>(cores);
  for (const int cpu : cpus)
    if (cpu < 0 || cpu >= count)
      add(line, key, std::to_string(cpu),
          "numbers from 0 to " + std::to_string(count - 1) +
              (options_.virtual_time ? "; robot.virtual_cores is " + std::to_string(count) : std::string()));
}

void GraphCheck::order(const GraphThread& t) {
  const std::string key = "thread." + t.spec.name + ".order";
  if (t.spec.order.empty()) add(t.spec.line, key, "[]", "at least one module");
  std::vector<std::string> all;
  for (const GraphModule& m : graph_.modules()) all.push_back(m.spec.name);
  for (const auto& name : t.spec.order)
    if (graph_.find_module(name.value) == kNone)
      add(name.line ? name.line : t.spec.line, key, quoted(name.value), "a module: " + listed_for(name.value, all));
}

void GraphCheck::modules() {
  for (const GraphModule& m : graph_.modules()) {
    placement(m);
    if (options_.virtual_time) execution_time(m);
    if (m.module) {
      params(m);
      bindings(m);
    } else {
      add(m.spec.line, "module." + m.spec.name + ".type", quoted(m.spec.type),
          "a known module type: " + listed_for(m.spec.type, known_types_));
    }
  }
}

void GraphCheck::placement(const GraphModule& m) {
  if (m.external && m.thread == kNone) return;  // external() says so
  std::vector<std::string> places;
  for (const GraphThread& t : graph_.threads())
    for (const auto& name : t.spec.order)
      if (name.value == m.spec.name) places.push_back(t.spec.name);
  const std::string key = "module." + m.spec.name;
  if (places.empty()) add(m.spec.line, key, "in no thread", "named in the order of one thread");
  if (places.size() > 1)
    add(m.spec.line, key, "in threads " + listed(places), "named once, in the order of one thread");
  if (!m.declaration.is_best_effort || m.thread == kNone) return;
  const ThreadSpec& t = graph_.threads()[m.thread].spec;
  if (t.priority > 0)
    add(m.spec.line, key, "best effort, in thread " + t.name + " of priority " + std::to_string(t.priority),
        "a thread of priority 0: " + m.spec.type + " calls libraries that allocate or block");
}

void GraphCheck::execution_time(const GraphModule& m) {
  using Kind = ExecModel::Kind;
  const ExecModel& e = m.spec.exec;
  const std::string key = m.spec.type == "rt::Guardian" ? "guardian" : "module." + m.spec.name;
  const auto too_short = [](Duration d) { return d < 1ns || d > kLongest; };
  if (e.kind == Kind::none)
    add(m.spec.line, key + ".exec_us", "missing",
        "exec_us, exec_trace_us, exec_quantiles_us or exec_measured_factor; virtual time needs one");
  if (e.kind == Kind::constant && too_short(e.constant))
    add(m.spec.line, key + ".exec_us", in_us(e.constant), "a number from 0.001 to 3600000000");
  if (e.kind == Kind::trace && (e.trace.empty() || std::any_of(e.trace.begin(), e.trace.end(), too_short)))
    add(m.spec.line, key + ".exec_trace_us", e.trace.empty() ? "[]" : "a number out of range",
        "an array of numbers from 0.001 to 3600000000");
  const auto& q = e.quantiles;
  bool rising = !q.empty() && q.front().share >= 0 && q.back().share == 1;
  for (std::size_t i = 0; rising && i < q.size(); ++i)
    rising = !too_short(q[i].exec) && (i == 0 || (q[i].share > q[i - 1].share && q[i].exec >= q[i - 1].exec));
  if (e.kind == Kind::quantiles && !rising)
    add(m.spec.line, key + ".exec_quantiles_us", q.empty() ? "[]" : "not a distribution",
        "pairs [share, us], both rising, shares from 0 to 1, the last one 1");
  if (e.kind == Kind::measured && !(e.factor >= 0.01 && e.factor <= 1000))
    add(m.spec.line, key + ".exec_measured_factor", format_number(e.factor), "a number from 0.01 to 1000");
}

void GraphCheck::params(const GraphModule& m) {
  for (const auto& [name, value] : m.spec.params) {
    const std::string key = "module." + m.spec.name + ".params." + name;
    const int line = value.line ? value.line : m.spec.line;
    const Declaration::Param* p = find_param(m.declaration, name);
    if (!p) {
      std::vector<std::string> known;
      for (const auto& d : m.declaration.params) known.push_back(d.name);
      add(line, key, to_string(value.value),
          known.empty() ? m.spec.type + " has no parameters"
                        : "a parameter of " + m.spec.type + ": " + listed_for(name, known));
    } else if (!accepts(*p, value.value)) {
      add(line, key, to_string(value.value), allowed_values(*p));
    }
  }
}

}  // namespace sinew::rt
