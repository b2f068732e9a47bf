#include "math/elementary.hpp"
#include "rt/failsafe.hpp"
#include "rt/graph_check.hpp"
#include "rt/parameters.hpp"

namespace sinew::rt {
namespace {

using namespace std::chrono_literals;
constexpr Duration kShortestTime = 1ms, kLongestTime = 3600s;

std::string number_of_ms(Duration d) { return format_number(static_cast<double>(d.count()) / 1e6); }

}  // namespace

void GraphCheck::failsafes() {
  const auto& all = graph_.spec().failsafes;
  if (all.empty()) return;
  if (graph_.spec().actuators.empty())
    add(all.front().line, "failsafe." + all.front().name, "without an actuator",
        "at least one [actuator.NAME]; without one there is no guardian to act");
  if (all.size() > msg::kMaxFailsafes)
    add(all.back().line, "failsafe", std::to_string(all.size()), "at most " + std::to_string(msg::kMaxFailsafes));
  for (const FailsafeSpec& f : all) failsafe(f);
}

void GraphCheck::failsafe(const FailsafeSpec& f) {
  const std::string key = "failsafe." + f.name;
  const char* unit = ".for_ms";
  if (f.kind == FailsafeSpec::Kind::silent) unit = ".silent_ms";
  if (f.kind == FailsafeSpec::Kind::stuck) unit = ".stuck_ms";
  const Duration least = f.kind == FailsafeSpec::Kind::value ? 0ns : kShortestTime;
  if (f.time < least || f.time > kLongestTime)
    add(f.line, key + unit, number_of_ms(f.time), "a number from " + number_of_ms(least) + " to 3600000");
  if (f.stop_after && (*f.stop_after < 0ns || *f.stop_after > kLongestTime))
    add(f.line, key + ".then_after_ms", number_of_ms(*f.stop_after), "a number from 0 to 3600000");
  const std::uint32_t topic = graph_.find_topic(f.topic.value);
  const int line = f.topic.line ? f.topic.line : f.line;
  if (acts_by_truth(line, key + ".topic", f.topic.value)) return;
  if (topic == kNone) {
    add(line, key + ".topic", quoted(f.topic.value), topic_candidates(nullptr, f.topic.value));
    return;
  }
  const GraphTopic& t = graph_.topics()[topic];
  if (t.writer == 0 && !graph_.spec().actuators.empty())
    add(line, key + ".topic", quoted(f.topic.value), "a topic that the guardian does not write itself");
  if (f.kind == FailsafeSpec::Kind::stuck && t.type->has_bulk())
    add(line, key + ".stuck_ms", quoted(f.topic.value) + " of " + std::string(t.type->name),
        "silent_ms, or a topic that is made from the pixels; pixels are not compared");
  if (f.kind == FailsafeSpec::Kind::value) failsafe_field(f, *t.type);
}

void GraphCheck::failsafe_field(const FailsafeSpec& f, const msg::TypeInfo& type) {
  const std::string key = "failsafe." + f.name;
  if (!find_numbers(type, f.field.value))
    add(f.field.line ? f.field.line : f.line, key + ".field", quoted(f.field.value),
        "a number of " + std::string(type.name) + ": " + listed_for(f.field.value, number_paths(type)));
  if (!f.below && !f.above) add(f.line, key, "no limit", "below, above or both");
  for (const auto& limit : {f.below, f.above})
    if (limit && !math::is_finite(*limit))
      add(f.line, key, format_number(*limit), "finite numbers for below and above");
  if (f.below && f.above && *f.below > *f.above)
    add(f.line, key + ".below", format_number(*f.below), "a number up to `above`, " + format_number(*f.above));
}

}  // namespace sinew::rt
