#include "apps/sweep/case_result.hpp"

#include <fmt/format.h>

#include <cmath>

namespace sinew::sweep {
namespace {

using app::Json;

const Json* part(const Json& object, const char* key) {
  const auto it = object.find(key);
  return it == object.end() ? nullptr : &*it;
}

std::string text_of(const Json& object, const char* key) {
  const Json* const value = part(object, key);
  return value && value->is_string() ? value->get<std::string>() : std::string();
}

std::optional<double> number_of_key(const Json& object, const char* key) {
  const Json* const value = object.is_object() ? part(object, key) : nullptr;
  if (!value || !value->is_number()) return std::nullopt;
  const double number = value->get<double>();
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

}  // namespace

std::string to_string(const Limits& limits) {
  std::string text;
  if (limits.at_least) text = fmt::format("at least {:g}", *limits.at_least);
  if (limits.at_most) text += fmt::format("{}at most {:g}", text.empty() ? "" : ", ", *limits.at_most);
  return text;
}

CaseResult case_result(std::uint64_t number, const Json& line) {
  CaseResult result;
  result.number = number;
  result.run = text_of(line, "run");
  result.outcome = text_of(line, "outcome");
  result.why = text_of(line, "why");
  result.hash = text_of(line, "hash");
  if (const Json* const code = part(line, "code"); code && code->is_number_integer()) result.code = code->get<int>();
  if (const Json* const good = part(line, "good"); good && good->is_boolean()) result.good = good->get<bool>();
  if (const Json* const report = part(line, "report"); report && report->is_object()) result.report = *report;
  const Json* const measures = part(line, "measures");
  const Json* const limits = part(line, "limits");
  if (!measures || !measures->is_object()) return result;
  for (const auto& [name, ignored] : measures->items()) {
    const auto value = number_of_key(*measures, name.c_str());
    if (!value) continue;
    MeasuredValue measured{name, *value};
    if (const Json* const of = limits && limits->is_object() ? part(*limits, name.c_str()) : nullptr)
      measured.limits = {number_of_key(*of, "at_most"), number_of_key(*of, "at_least")};
    result.measures.push_back(std::move(measured));
  }
  return result;
}

Json to_json(const CaseResult& result) {
  Json line{{"run", result.run}, {"code", result.code}, {"outcome", result.outcome}, {"good", result.good}};
  if (!result.why.empty()) line["why"] = result.why;
  for (const MeasuredValue& m : result.measures) line["measures"][m.name] = m.value;
  for (const MeasuredValue& m : result.measures) {
    if (m.limits.at_most) line["limits"][m.name]["at_most"] = *m.limits.at_most;
    if (m.limits.at_least) line["limits"][m.name]["at_least"] = *m.limits.at_least;
  }
  if (!result.hash.empty()) line["hash"] = result.hash;
  if (!result.report.is_null()) line["report"] = result.report;
  return line;
}

std::string repeat_command(const std::string& run) {
  return run.starts_with("match ") ? "sinew " + run : "sinew run " + run + " --virtual";
}

}  // namespace sinew::sweep
