#include "apps/sweep_runs/run_result.hpp"

#include <fmt/format.h>

#include <cmath>

#include "apps/command/command.hpp"
#include "hal/linux/process.hpp"
#include "math/hash.hpp"

namespace sinew::app {
namespace {

/// The last line that is not empty.
std::string last_line(const std::string& text) {
  const auto end = text.find_last_not_of(" \n\r\t");
  if (end == std::string::npos) return {};
  const auto begin = text.find_last_of('\n', end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1,
                     end + 1 - (begin == std::string::npos ? 0 : begin + 1));
}

std::string text_at(const Json& all, const char* object, const char* key) {
  const Json::json_pointer at(fmt::format("/{}/{}", object, key));
  return all.contains(at) && all[at].is_string() ? all[at].get<std::string>() : std::string();
}

std::optional<double> limit_at(const Json& measure, const char* key) {
  const auto it = measure.find(key);
  return it != measure.end() && it->is_number() ? std::optional(it->get<double>()) : std::nullopt;
}

std::vector<sweep::MeasuredValue> measures_of(const Json& all) {
  std::vector<sweep::MeasuredValue> measures;
  const Json::json_pointer at("/mission/measures");
  if (!all.contains(at) || !all[at].is_array()) return measures;
  for (const Json& m : all[at])
    if (m.is_object() && m.contains("name") && m["name"].is_string() && m.contains("value") && m["value"].is_number() &&
        std::isfinite(m["value"].get<double>()))
      measures.push_back({m["name"], m["value"], {limit_at(m, "at_most"), limit_at(m, "at_least")}});
  return measures;
}

/// The simulator's report but for its verdict, which is in the result already.
Json report_of(const Json& all) {
  const auto it = all.find("report");
  if (it == all.end() || !it->is_object()) return {};
  Json report = *it;
  report.erase("verdict");
  return report;
}

/// One for all topics.
std::string hash_of(const Json& all) {
  if (!all.contains("hashes")) return {};
  const std::string text = all["hashes"].dump();
  return fmt::format("{:016x}", math::fnv1a64(text));
}

void read_summary(const Json& all, RunEnd& end) {
  sweep::CaseResult& r = end.result;
  r.good = r.code == kDone;
  r.outcome = text_at(all, "mission", "outcome");
  if (!r.good) r.why = text_at(all, "mission", "why");
  const std::string timing = text_at(all, "timing", "worst");
  const Json::json_pointer well("/mission/good");
  if (!r.good && all.contains(well) && all[well] == true && !timing.empty()) {
    r.outcome += r.outcome.empty() ? "not valid as a measurement" : ", but not valid as a measurement";
    if (r.why.empty()) r.why = timing;
  }
  r.measures = measures_of(all);
  r.hash = hash_of(all);
  r.report = report_of(all);
  end.recording = text_at(all, "recording", "path");
  end.interrupted = all.contains("ended_early");
}

}  // namespace

RunEnd end_of_run(const std::string& run, const sweep::JobResult& job, double patience_s) {
  RunEnd end;
  end.result.run = run;
  end.result.code = job.code;
  end.not_begun = job.not_started;
  if (!end.not_begun.empty()) return end;
  if (job.hung) {
    end.result.outcome = fmt::format("hung: no end within {:g} s", patience_s);
    return end;
  }
  const Json all = Json::parse(last_line(job.output), nullptr, false);
  if (all.is_object() && all.contains("exit_code")) {
    read_summary(all, end);
    return end;
  }
  if (job.code == kNotBegun) {
    end.not_begun = job.errors.empty() ? "it could not begin" : job.errors;
    return end;
  }
  end.result.outcome = job.code > 128 ? "crashed: " + hal::describe_exit(job.code)
                                      : fmt::format("ended without a summary: {}", hal::describe_exit(job.code));
  return end;
}

}  // namespace sinew::app
