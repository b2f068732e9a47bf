#include "tap/status_json.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "msg/json.hpp"
#include "msg/text.hpp"
#include "rt/parameters.hpp"
#include "rt/schema_hash.hpp"

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

Json limit(double value) {
  constexpr double kUnbounded = std::numeric_limits<double>::max();
  return value >= kUnbounded || value <= -kUnbounded ? Json() : Json(value);
}

const char* type_name(const rt::Declaration::Param& p) {
  constexpr std::array<const char*, 4> kNames{"bool", "integer", "number", "text"};
  return kNames[p.target.index()];
}

const char* trigger_name(rt::ThreadSpec::Trigger t) {
  using T = rt::ThreadSpec::Trigger;
  if (t == T::period) return "period";
  return t == T::topics ? "topics" : "device";
}

}  // namespace

Json thread_json(const rt::ThreadSpec& thread, const std::vector<std::string>& modules, const rt::ThreadStats& s) {
  return {{"name", thread.name},
          {"priority", thread.priority},
          {"trigger", trigger_name(thread.trigger)},
          {"period_ns", s.period_ns.value()},
          {"modules", modules},
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

Json module_json(const rt::ModuleSpec& module, const std::string& thread, const rt::ModuleStats& s) {
  return {{"name", module.name},
          {"type", module.type},
          {"thread", thread},
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

Json topic_json(const std::string& name, const rt::TopicStats& s, std::uint64_t drops) {
  return {{"name", name},
          {"messages", s.messages.value()},
          {"drops", drops},
          {"last_stamp_ns", s.last_stamp_ns.value()},
          {"last_published_ns", s.last_published_ns.value()},
          {"age", histogram(s.age)}};
}

Json chain_json(const rt::ChainSpec& chain, const rt::ChainStats& s) {
  return {{"name", chain.name},
          {"budget_ns", chain.budget.count()},
          {"budget_misses", s.budget_misses.value()},
          {"age", histogram(s.age)}};
}

Json param_json(const std::string& module, const rt::Declaration::Param& p,
                const std::optional<rt::ParamRange>& narrowed, const rt::ParamValue& value,
                const rt::ParamValue& start) {
  return {{"module", module},
          {"param", p.name},
          {"type", type_name(p)},
          {"value", to_json(value)},
          {"default", to_json(p.default_value)},
          {"start", to_json(start)},
          {"unit", p.unit},
          {"min", limit(narrowed ? narrowed->min : p.min)},
          {"max", limit(narrowed ? narrowed->max : p.max)},
          {"doc", p.doc},
          {"allowed", rt::allowed_values(p, narrowed)}};
}

Json to_json(const rt::ParamValue& value) {
  return std::visit([](const auto& v) { return Json(v); }, value);
}

std::vector<std::string> readers_of(const rt::Graph& graph, std::uint32_t topic) {
  std::vector<std::string> readers;
  for (std::uint32_t m = 0; m < graph.modules().size(); ++m) {
    const rt::GraphModule& module = graph.modules()[m];
    if (m != graph.topics()[topic].writer && std::count(module.topic.begin(), module.topic.end(), topic) > 0)
      readers.push_back(module.spec.name);
  }
  return readers;
}

Json directory_json(const std::vector<TopicAbout>& all) {
  Json topics = Json::array(), types = Json::object();
  for (const TopicAbout& topic : all) {
    add_type(*topic.type, types);
    topics.push_back({{"name", topic.name},
                      {"type", topic.type->name},
                      {"schema_hash", hex(rt::schema_hash(*topic.type))},
                      {"writer", topic.writer},
                      {"thread", topic.thread},
                      {"readers", topic.readers},
                      {"message_bytes", topic.type->size},
                      {"bulk_bytes", topic.bulk_bytes},
                      {"keep", topic.keep},
                      {"rate_hz", topic.rate_hz},
                      {"external", topic.external},
                      {"wakes_outsiders", topic.wakes_outsiders}});
  }
  return {{"topics", std::move(topics)}, {"types", std::move(types)}};
}

TimelineText timeline_text(const std::vector<std::string>& threads, const std::vector<std::string>& modules,
                           const std::vector<rt::TimelineEvent>& all) {
  constexpr std::array<const char*, 8> kKinds{"release", "cycle",     "step",          "overrun",
                                              "skip",    "preempted", "off_processor", "zone"};
  constexpr std::size_t kMostEvents = 80'000, kBytesOfEvent = 64;  // about; within a reply's 8 MiB
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
  return {{{"threads", threads},
           {"modules", modules},
           {"columns", {"kind", "thread", "module", "at_ns", "length_ns", "zone"}},
           {"left_out", left_out}},
          std::move(events)};
}

Json team_json(const msg::TeamState& team) {
  std::string text;
  msg::to_json(msg::type_info<msg::TeamState>(), &team, text);
  Json json = Json::parse(text, nullptr, false);
  Json& mates = json["mate"];
  mates.erase(mates.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(team.mates, mates.size())),
              mates.end());
  return json;
}

}  // namespace sinew::tap
