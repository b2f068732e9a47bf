#include "apps/robot_file/world_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace sinew::app {
namespace {

using nlohmann::json;

// A foreign simulator's report may hold anything: a value that is missing, or of another type, keeps its default.
template <class T>
void read(const json& object, const char* key, T& value) {
  const auto it = object.find(key);
  if (it == object.end()) return;
  if constexpr (std::is_same_v<T, std::string>) {
    if (it->is_string()) value = it->template get<std::string>();
  } else if constexpr (std::is_same_v<T, bool>) {
    if (it->is_boolean()) value = it->template get<bool>();
  } else if constexpr (std::is_same_v<T, std::uint64_t>) {
    if (it->is_number_unsigned()) value = it->template get<std::uint64_t>();
  } else {
    if (it->is_number()) value = it->template get<double>();
  }
}

template <class Each>
void for_each_object(const json& object, const char* key, const Each& each) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_array()) return;
  for (const json& one : *it)
    if (one.is_object()) each(one);
}

std::vector<WorldReport::Measure> read_measures(const json& said, const char* key) {
  std::vector<WorldReport::Measure> all;
  for_each_object(said, key, [&](const json& m) {
    WorldReport::Measure measure;
    read(m, "key", measure.key);
    read(m, "label", measure.label);
    read(m, "unit", measure.unit);
    read(m, "value", measure.value);
    if (m.contains("at_most")) read(m, "at_most", measure.at_most.emplace());
    if (m.contains("at_least")) read(m, "at_least", measure.at_least.emplace());
    if (!measure.key.empty()) all.push_back(std::move(measure));
  });
  return all;
}

WorldReport::Verdict read_verdict(const json& said) {
  WorldReport::Verdict verdict;
  read(said, "outcome", verdict.outcome);
  read(said, "good", verdict.good);
  read(said, "begun", verdict.begun);
  verdict.measures = read_measures(said, "measures");
  verdict.conditions = read_measures(said, "conditions");
  return verdict;
}

}  // namespace

std::optional<WorldReport> parse_report(const std::string& text) {
  const json said = json::parse(text, nullptr, false);
  if (!said.is_object()) return std::nullopt;
  WorldReport report;
  for (const auto& [key, value] : said.items()) {
    if (value.is_number()) report.numbers[key] = value.get<double>();
    if (value.is_boolean()) report.numbers[key] = value.get<bool>() ? 1 : 0;
  }
  read(said, "valid", report.valid);
  read(said, "reason", report.reason);
  read(said, "still", report.still);
  read(said, "frames", report.frames);
  read(said, "render_late", report.render_late);
  report.imu_gap_max_s = report.number("imu_gap_max_ns") * 1e-9;
  if (const auto it = said.find("verdict"); it != said.end() && it->is_object()) report.verdict = read_verdict(*it);
  for_each_object(said, "faults", [&](const json& f) {
    WorldReport::Fault fault;
    read(f, "fault", fault.text);
    read(f, "device", fault.device);
    read(f, "affected", fault.affected);
    for (const char* key : {"from_s", "first_s"})
      if (f.contains(key)) read(f, key, fault.first_s.emplace());
    report.faults.push_back(std::move(fault));
  });
  return report;
}

bool WorldReport::is_faulty(const std::string& device) const {
  return std::ranges::any_of(faults, [&](const Fault& f) { return f.device == device || f.device == "link"; });
}

double WorldReport::number(std::string_view key) const {
  const auto it = numbers.find(key);
  return it == numbers.end() ? 0 : it->second;
}

std::string in_words(const WorldReport::Measure& m) {
  const bool large = m.value >= 1000 || m.value <= -1000;  // not 1.23e+03
  const std::string value = large ? fmt::format("{:.0f}", m.value) : fmt::format("{:.3g}", m.value);
  std::string text = fmt::format("{} {}{}{}", m.label, value, m.unit.empty() ? "" : " ", m.unit);
  if (m.at_most) text += fmt::format(" (at most {:g})", *m.at_most);
  if (m.at_least) text += fmt::format(" (at least {:g})", *m.at_least);
  return text;
}

double over_limit(const WorldReport::Measure& m) {
  constexpr double kLeast = 1e-9;  // in place of a limit or a value of 0
  if (m.at_most) return m.value / std::max(*m.at_most, kLeast);
  if (m.at_least) return *m.at_least / std::max(m.value, kLeast);
  return 0;
}

std::string to_string(const WorldReport::Measure& m) {
  const std::string unit = m.unit.empty() ? "" : " " + m.unit;
  std::string text = fmt::format("{:.3f}{}", m.value, unit);
  if (m.at_most) text += fmt::format("   (limit {:g}{})", *m.at_most, unit);
  if (m.at_least) text += fmt::format("   (at least {:g})", *m.at_least);
  return text;
}

}  // namespace sinew::app
