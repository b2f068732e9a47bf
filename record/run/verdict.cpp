#include "record/run/verdict.hpp"

#include <algorithm>
#include <cstdio>

#include "rt/parameters.hpp"

namespace sinew::record {

bool due(msg::Time& next, double rate_hz, msg::Time at) {
  if (at < next) return false;
  constexpr double kMost_ns = 1e17;  // three years: a file may say anything
  next = std::max(next + msg::Duration{static_cast<std::int64_t>(std::clamp(1e9 / rate_hz, 1.0, kMost_ns))}, at);
  return true;
}

std::string seconds_text(msg::Time t) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f s", msg::seconds(t));
  return text;
}

std::vector<std::string> reasons(bool source, const Losses& steps, std::span<const TopicKept* const> inputs) {
  std::vector<std::string> why;
  if (source) why.emplace_back("a source: its messages came from outside");
  if (steps.count != 0) why.push_back("gap in its steps at " + seconds_text(steps.first));
  for (const TopicKept* t : inputs) {
    if (!t->wanted)
      why.push_back("input " + t->name + " is not recorded");
    else if (t->rate_hz > 0)
      why.push_back("input " + t->name + " at " + rt::format_number(t->rate_hz) + " Hz");
    if (t->lost.count != 0) why.push_back("gap in " + t->name + " at " + seconds_text(t->lost.first));
    if (t->without_pixels.count != 0)
      why.push_back("pixels of " + t->name + " not kept from " + seconds_text(t->without_pixels.first) + " on");
  }
  return why;
}

std::string not_recorded(std::string_view thread) {
  return "steps of the thread " + std::string(thread) + " are not recorded";
}

void begins_at(ModuleVerdict& verdict, std::optional<msg::Time> state) {
  if (!verdict.reasons.empty()) return;
  verdict.from = state;
  if (!state) verdict.reasons.emplace_back("no saved state of it with all that it latched from then on");
}

std::string to_text(const ModuleVerdict& verdict) {
  if (verdict.reasons.empty())
    return verdict.from ? "replayable from " + seconds_text(*verdict.from) + " on" : "replayable";
  std::string text;
  for (const std::string& reason : verdict.reasons) text += (text.empty() ? "" : "; ") + reason;
  return text;
}

std::string to_text(const Losses& losses, const char* what) {
  return std::to_string(losses.count) + " " + what + " from " + seconds_text(losses.first) + " on";
}

}  // namespace sinew::record
