#include "apps/sweep_runs/sweep_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <set>

#include "apps/sweep/case_text.hpp"
#include "apps/sweep/comparison.hpp"
#include "apps/sweep/summary.hpp"
#include "apps/sweep_runs/sweep_plot.hpp"
#include "hal/did_you_mean.hpp"

namespace sinew::app {
namespace {

constexpr std::size_t kMostSettings = 100;  // columns of --csv

/// The settings of a run, by their key.
std::map<std::string, std::string> settings_of(const std::string& run) {
  std::map<std::string, std::string> settings;
  const auto words = sweep::split_words(run).value_or(std::vector<std::string>{});
  for (std::size_t i = 0; i + 1 < words.size(); ++i)
    if (const auto equals = words[i + 1].find('='); words[i] == "--set" && equals != std::string::npos)
      settings[words[i + 1].substr(0, equals)] = words[i + 1].substr(equals + 1);
  return settings;
}

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// Reads every result of a file.
bool each_result(const std::string& path, const std::function<bool(const sweep::CaseResult&)>& each, std::string& why) {
  sweep::Identity ignored;
  sweep::Shard shard;
  return sweep::read_results(
      path, ignored, shard,
      [&](const sweep::ResultLine& line) { return each(sweep::case_result(line.number, line.result)); }, why);
}

bool write_csv(const std::string& results, const std::string& path, const std::vector<std::string>& measures,
               const std::set<std::string>& settings, std::string& why) {
  std::ofstream out(path, std::ios::binary);
  out << "case,run,seed,good,code,outcome,why";
  for (const auto& name : settings) out << "," << csv_cell(name);
  for (const auto& name : measures) out << "," << csv_cell(name);
  out << "\n";
  const auto row = [&](const sweep::CaseResult& r) {
    out << fmt::format("{},{},{},{},{},{},{}", r.number, csv_cell(r.run), sweep::seed_of(r.run).value_or(""),
                       r.good ? 1 : 0, r.code, csv_cell(r.outcome), csv_cell(r.why));
    const auto of = settings_of(r.run);
    for (const auto& name : settings) out << "," << (of.contains(name) ? csv_cell(of.at(name)) : "");
    for (const auto& name : measures) {
      const auto m =
          std::find_if(r.measures.begin(), r.measures.end(), [&](const auto& one) { return one.name == name; });
      out << ",";
      if (m != r.measures.end()) out << fmt::format("{}", m->value);
    }
    out << "\n";
    return static_cast<bool>(out);
  };
  if (!each_result(results, row, why)) return false;
  out.close();
  if (!out) why = fmt::format("--csv {}: {}", path, std::strerror(errno));
  return static_cast<bool>(out);
}

bool write_plot(const std::string& results, const ReportOptions& options, const std::vector<std::string>& measures,
                std::string& why) {
  const auto colon = options.plot.find(':');
  const std::string name = options.plot.substr(0, colon);
  if (std::find(measures.begin(), measures.end(), name) == measures.end()) {
    why = fmt::format("--plot {}: no measure {}; there are: {}{}", options.plot, name,
                      measures.empty() ? "none" : fmt::format("{}", fmt::join(measures, ", ")),
                      hal::did_you_mean(name, measures));
    return false;
  }
  SweepPlot plot(name, colon == std::string::npos ? "" : options.plot.substr(colon + 1));
  for (bool again = true; again;) {
    if (!each_result(
            results, [&](const auto& r) { return plot.add(r, why); }, why) ||
        !why.empty())
      break;
    again = plot.needs_another_look();
  }
  if (why.empty()) why = plot.write(options.plot_file);
  if (!why.empty()) why = fmt::format("--plot {}: {}", options.plot, why);
  return why.empty();
}

}  // namespace

std::uint64_t cases_of(const sweep::Identity& identity, const sweep::Shard& shard) {
  return identity.cases / shard.count + (shard.index < identity.cases % shard.count ? 1 : 0);
}

bool report_results(const std::string& path, const ReportOptions& options, const std::string& remark,
                    Reported& reported, std::string& why) {
  std::unique_ptr<sweep::Comparison> comparison;
  if (!options.against.empty() && !(comparison = sweep::Comparison::open(options.against, why))) {
    why = "--against " + why;
    return false;
  }
  sweep::Summary summary;
  std::set<std::string> settings;
  const auto see = [&](const sweep::ResultLine& line) {
    const sweep::CaseResult result = sweep::case_result(line.number, line.result);
    summary.add(result);
    if (!options.csv.empty() && settings.size() < kMostSettings)
      for (const auto& [key, ignored] : settings_of(result.run)) settings.insert(key);
    return !comparison || comparison->add(result, why);
  };
  why.clear();
  if (!sweep::read_results(path, reported.identity, reported.shard, see, why) || !why.empty()) return false;
  reported.runs = summary.runs();
  reported.good = summary.good();
  const std::uint64_t cases = cases_of(reported.identity, reported.shard);
  if (options.json) {
    Json all = summary.json(cases);
    all["results"] = path;
    all["sweep"] = reported.identity.what;
    if (comparison) all["against"] = comparison->json();
    reported.text = to_line(all);
  } else {
    reported.text = summary.text(cases);
    if (comparison) reported.text += "\n" + comparison->text();
    reported.text += fmt::format("\nresults  {}{}\n", path, remark);
  }
  if (!options.csv.empty() && !write_csv(path, options.csv, summary.measures(), settings, why)) return false;
  if (!options.plot.empty() && !write_plot(path, options, summary.measures(), why)) return false;
  if (!options.json && !options.plot.empty()) reported.text += fmt::format("plot     {}\n", options.plot_file);
  return true;
}

}  // namespace sinew::app
