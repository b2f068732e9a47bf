#include <array>

#include "msg/text.hpp"
#include "rt/exec/timeline.hpp"
#include "rt/schema_hash.hpp"
#include "tap/answers.hpp"

namespace sinew::tap {
namespace {

std::string kind_name(const msg::FieldInfo& f) {
  constexpr std::array<const char*, 10> kNames{"i8", "u8", "i16", "u16", "i32", "u32", "i64", "u64", "f32", "f64"};
  return f.kind == msg::Kind::nested ? std::string(f.nested->name) : kNames[static_cast<std::size_t>(f.kind)];
}

void add_type(const msg::TypeInfo& type, Json& types) {
  const std::string name(type.name);
  if (types.contains(name)) return;
  Json fields = Json::array();
  for (const msg::FieldInfo& f : type.fields) {
    if (f.nested) add_type(*f.nested, types);
    fields.push_back({{"name", f.name},
                      {"type", kind_name(f)},
                      {"count", f.count},
                      {"array", f.is_array},
                      {"offset", f.offset},
                      {"unit", f.unit},
                      {"doc", msg::remark_of(f)}});
    if (f.names.empty()) continue;
    Json names = Json::object();
    for (const msg::ValueName& n : f.names) names[std::string(n.name)] = n.value;
    fields.back()["names"] = std::move(names);
    fields.back()["bits"] = f.bits;
  }
  types[name] = {{"doc", type.doc},
                 {"bytes", type.size},
                 {"bulk", type.has_bulk() ? Json(type.bulk_name) : Json()},
                 {"fields", std::move(fields)}};
}

std::string hex(std::uint64_t value) {
  std::string text(16, '0');
  for (int i = 15; i >= 0; --i, value >>= 4) text[static_cast<std::size_t>(i)] = "0123456789abcdef"[value & 15];
  return text;
}

Json histogram(const rt::Histogram& h) {
  return {{"count", h.count()},
          {"min_ns", h.min().count()},
          {"mean_ns", h.mean_ns()},
          {"p50_ns", h.quantile(0.5).count()},
          {"p99_ns", h.quantile(0.99).count()},
          {"p999_ns", h.quantile(0.999).count()},
          {"max_ns", h.max().count()}};
}

Json gaps(const rt::GapStats& s) {
  return {{"count", s.count.value()}, {"min_ns", s.min_ns.value()}, {"max_ns", s.max_ns.value()}};
}

const char* trigger_name(rt::ThreadSpec::Trigger t) {
  using T = rt::ThreadSpec::Trigger;
  if (t == T::period) return "period";
  return t == T::topics ? "topics" : "device";
}

Json thread_json(const rt::Graph& graph, const rt::GraphThread& t, const rt::ThreadStats& s) {
  Json modules = Json::array();
  for (const std::uint32_t m : t.modules) modules.push_back(graph.modules()[m].spec.name);
  return {{"name", t.spec.name},
          {"priority", t.spec.priority},
          {"trigger", trigger_name(t.spec.trigger)},
          {"period_ns", s.period_ns.value()},
          {"modules", std::move(modules)},
          {"releases", s.releases.value()},
          {"completions", s.completions.value()},
          {"overruns", s.overruns.value()},
          {"skips", s.skips.value()},
          {"coalesced", s.coalesced.value()},
          {"timeouts", s.timeouts.value()},
          {"preemptions", s.preemptions.value()},
          {"throttled", gaps(s.throttled)},
          {"taken", gaps(s.taken)},
          {"lateness", histogram(s.lateness)},
          {"exec", histogram(s.exec)}};
}

Json module_json(const rt::Graph& graph, const rt::GraphModule& m, const rt::ModuleStats& s) {
  return {{"name", m.spec.name},
          {"type", m.spec.type},
          {"thread", graph.threads()[m.thread].spec.name},
          {"running", s.stopped.value() == 0},
          {"steps", s.steps.value()},
          {"ok", s.ok.value()},
          {"stale", s.stale.value()},
          {"fault", s.fault.value()},
          {"stops", s.stops.value()},
          {"best_effort_calls", s.best_effort_calls.value()},
          {"fp_mode_changes", s.fp_mode_changes.value()},
          {"exec", histogram(s.exec)}};
}

}  // namespace

Json directory_json(const rt::Graph& graph) {
  Json topics = Json::array(), types = Json::object();
  for (std::uint32_t t = 0; t < graph.topics().size(); ++t) {
    const rt::GraphTopic& topic = graph.topics()[t];
    const rt::GraphModule& writer = graph.modules()[topic.writer];
    add_type(*topic.type, types);
    topics.push_back({{"name", topic.name},
                      {"type", topic.type->name},
                      {"schema_hash", hex(rt::schema_hash(*topic.type))},
                      {"writer", writer.spec.name},
                      {"thread", graph.threads()[writer.thread].spec.name},
                      {"message_bytes", topic.type->size},
                      {"bulk_bytes", topic.image_bytes},
                      {"keep", graph.slots(t).keep},
                      {"rate_hz", graph.planned_rate_hz(t)},
                      {"external", writer.external != nullptr},
                      {"wakes_outsiders", topic.wake_outsiders}});
  }
  return {{"topics", std::move(topics)}, {"types", std::move(types)}};
}

Json status_json(rt::Graph& graph, rt::Runner& runner) {
  Json threads = Json::array(), modules = Json::array(), topics = Json::array(), chains = Json::array();
  for (std::uint32_t t = 0; t < graph.threads().size(); ++t)
    threads.push_back(thread_json(graph, graph.threads()[t], runner.thread_stats(t)));
  for (std::uint32_t m = 0; m < graph.modules().size(); ++m)
    modules.push_back(module_json(graph, graph.modules()[m], runner.module_stats(m)));
  for (std::uint32_t t = 0; t < graph.topics().size(); ++t) {
    const rt::TopicStats& s = runner.topic_stats(t);
    topics.push_back({{"name", graph.topics()[t].name},
                      {"messages", s.messages.value()},
                      {"drops", runner.topic_drops(t)},
                      {"last_stamp_ns", s.last_stamp_ns.value()},
                      {"last_published_ns", s.last_published_ns.value()},
                      {"age", histogram(s.age)}});
  }
  for (std::uint32_t c = 0; c < graph.chains().size(); ++c) {
    const rt::ChainStats& s = runner.chain_stats(c);
    chains.push_back({{"name", graph.chains()[c].spec.name},
                      {"budget_ns", graph.chains()[c].spec.budget.count()},
                      {"budget_misses", s.budget_misses.value()},
                      {"age", histogram(s.age)}});
  }
  return {{"threads", std::move(threads)},
          {"modules", std::move(modules)},
          {"topics", std::move(topics)},
          {"chains", std::move(chains)}};
}

TimelineText timeline_text(const rt::Graph& graph, const rt::Runner& runner, hal::Duration last) {
  constexpr std::array<const char*, 8> kKinds{"release", "cycle",     "step",          "overrun",
                                              "skip",    "preempted", "off_processor", "zone"};
  constexpr std::size_t kMostEvents = 80'000, kBytesOfEvent = 64;  // about; within a reply's 8 MiB
  const std::vector<rt::TimelineEvent> all = runner.timeline().snapshot(last);
  const std::size_t left_out = all.size() > kMostEvents ? all.size() - kMostEvents : 0;
  std::string events = "\"events\":[";
  events.reserve((all.size() - left_out) * kBytesOfEvent);
  for (const rt::TimelineEvent& e : std::span(all).subspan(left_out)) {
    if (events.back() == ']') events += ',';
    events.append("[\"").append(kKinds[static_cast<std::size_t>(e.kind)]).append("\",");
    events.append(std::to_string(e.thread)).append(1, ',');
    events.append(e.module == rt::kNone ? "null" : std::to_string(e.module)).append(1, ',');
    events.append(std::to_string(e.at.ns)).append(1, ',').append(std::to_string(e.length.count())).append(1, ',');
    events.append(e.zone ? to_text(Json(e.zone)) : "null").append(1, ']');
  }
  events += ']';
  Json threads = Json::array(), modules = Json::array();
  for (const auto& t : graph.threads()) threads.push_back(t.spec.name);
  for (const auto& m : graph.modules()) modules.push_back(m.spec.name);
  return {{{"threads", std::move(threads)},
           {"modules", std::move(modules)},
           {"columns", {"kind", "thread", "module", "at_ns", "length_ns", "zone"}},
           {"left_out", left_out}},
          std::move(events)};
}

}  // namespace sinew::tap
