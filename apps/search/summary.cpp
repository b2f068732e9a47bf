#include "apps/search/summary.hpp"

#include <fmt/format.h>

#include <algorithm>

#include <nlohmann/json.hpp>

namespace sinew::search {
namespace {

double quantile(const std::vector<double>& sorted, double q) {
  return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(q * static_cast<double>(sorted.size())))];
}

}  // namespace

void Summary::add(const Case& c, const Excuses& excused, const Outcome& o) {
  ++runs_;
  with_faults_ += !c.faults.empty();
  faults_ += c.faults.size();
  overruns_ += o.overruns;
  steps_ += o.steps;
  virtual_s_ += o.ended_s;
  ++endings_[o.violation ? "failed" : to_string(o.ending)];
  if (o.violation) return;
  if (o.ending == Ending::landed_on_pad) {
    figures_["landing error, m"].push_back(o.landing_error_m);
    figures_["touchdown speed, m/s"].push_back(o.touchdown_speed_mps);
  }
  if (o.ending != Ending::fell && o.ending != Ending::crashed) {
    figures_["largest tilt, rad"].push_back(o.worst.tilt_rad);
    figures_["tilt error of the estimate, rad"].push_back(o.worst.tilt_error_rad);
    figures_["height error of the estimate, m"].push_back(o.worst.height_error_m);
  }
  if (excused.elsewhere) return;
  for (const auto& [chain, ms] : o.worst_age_ms) figures_["oldest " + chain + ", ms"].push_back(ms);
}

std::string Summary::text() const {
  std::string text = fmt::format("runs                {} of {:.0f} s together, {} with faults ({} in all)\n", runs_,
                                 virtual_s_, with_faults_, faults_);
  text += fmt::format("steps               {} million, {} periods overrun\n", steps_ / 1000000, overruns_);
  for (const auto& [ending, count] : endings_) text += fmt::format("  {:<34}{:6}\n", ending, count);
  text += fmt::format("  {:<34}{:>8} {:>8} {:>8} {:>8}\n", "largest in each flight", "p50", "p90", "p99", "max");
  for (auto [name, values] : figures_) {
    std::sort(values.begin(), values.end());
    text += fmt::format("  {:<34}{:8.3f} {:8.3f} {:8.3f} {:8.3f}\n", name, quantile(values, 0.5), quantile(values, 0.9),
                        quantile(values, 0.99), values.back());
  }
  return text;
}

std::string Summary::json() const {
  nlohmann::json j{{"runs", runs_},   {"with_faults", with_faults_}, {"faults", faults_},  {"overruns", overruns_},
                   {"steps", steps_}, {"virtual_s", virtual_s_},     {"endings", endings_}};
  for (auto [name, values] : figures_) {
    std::sort(values.begin(), values.end());
    j["figures"][name] = {{"flights", values.size()},
                          {"p50", quantile(values, 0.5)},
                          {"p90", quantile(values, 0.9)},
                          {"p99", quantile(values, 0.99)},
                          {"max", values.back()}};
  }
  return j.dump();
}

}  // namespace sinew::search
