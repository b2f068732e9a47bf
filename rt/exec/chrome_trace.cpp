#include "rt/exec/chrome_trace.hpp"

namespace sinew::rt {
namespace {

/// Microseconds, with the nanoseconds behind the decimal point.
std::string us(std::int64_t ns) {
  const std::string sign = ns < 0 ? "-" : "";
  const std::uint64_t all = ns < 0 ? 0 - static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  std::string below = std::to_string(all % 1000);
  return sign + std::to_string(all / 1000) + '.' + std::string(3 - below.size(), '0') + below;
}

std::string json_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + '"';
}

class Writer {
 public:
  explicit Writer(const Graph& graph) : graph_(graph) {}

  std::string write(std::span<const TimelineEvent> events) {
    metadata("process_name", 0, "\"name\":" + json_string(graph_.spec().robot));
    for (std::uint32_t t = 0; t < graph_.threads().size(); ++t) {
      metadata("thread_name", t, "\"name\":" + json_string(graph_.threads()[t].spec.name));
      metadata("thread_sort_index", t, "\"sort_index\":" + std::to_string(t));
    }
    for (const TimelineEvent& e : events) event(e);
    return "{\"displayTimeUnit\":\"ns\",\"traceEvents\":[\n" + out_ + "\n]}\n";
  }

 private:
  // Tracks count from 1: viewers take 0 for "unknown".
  void begin(std::string_view phase, std::string_view name, std::uint32_t thread) {
    if (!out_.empty()) out_ += ",\n";
    out_ += "{\"ph\":\"" + std::string(phase) + "\",\"name\":" + json_string(name) +
            ",\"pid\":1,\"tid\":" + std::to_string(thread + 1);
  }
  void metadata(std::string_view what, std::uint32_t thread, const std::string& args) {
    begin("M", what, thread);
    out_ += ",\"args\":{" + args + "}}";
  }
  void slice(const TimelineEvent& e, std::string_view name, std::string_view category) {
    begin("X", name, e.thread);
    out_ +=
        ",\"cat\":\"" + std::string(category) + "\",\"ts\":" + us(e.at.ns) + ",\"dur\":" + us(e.length.count()) + '}';
  }
  void instant(const TimelineEvent& e, std::string_view name, const std::string& args) {
    begin("i", name, e.thread);
    out_ += ",\"cat\":\"schedule\",\"s\":\"t\",\"ts\":" + us(e.at.ns) + ",\"args\":{" + args + "}}";
  }
  std::string_view module_name(std::uint32_t module) const {
    return module < graph_.modules().size() ? std::string_view(graph_.modules()[module].spec.name) : "?";
  }

  void event(const TimelineEvent& e) {
    switch (e.kind) {
      case TimelineEvent::Kind::release:
        return instant(e, "release", "\"late_us\":" + us(e.length.count()));
      case TimelineEvent::Kind::cycle:
        return slice(e, "cycle", "cycle");
      case TimelineEvent::Kind::step:
        return slice(e, module_name(e.module), "step");
      case TimelineEvent::Kind::overrun:
        return instant(e, "overrun", "");
      case TimelineEvent::Kind::skip:
        return instant(e, "skip", "");
      case TimelineEvent::Kind::preempted:
        return slice(e, "preempted", "schedule");
      case TimelineEvent::Kind::off_processor:  // no slice: its bounds are approximate, and slices must nest
        return instant(e, "off_processor", "\"about_us\":" + us(e.length.count()));
      case TimelineEvent::Kind::zone:
        return slice(e, e.zone ? e.zone : "?", "zone");
    }
  }

  const Graph& graph_;
  std::string out_;
};

}  // namespace

std::string chrome_trace(const Graph& graph, std::span<const TimelineEvent> events) {
  return Writer(graph).write(events);
}

}  // namespace sinew::rt
