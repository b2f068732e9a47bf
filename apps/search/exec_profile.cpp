#include "apps/search/exec_profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "apps/robot_file/exec_reader.hpp"

namespace sinew::search {
namespace {

constexpr double kBudgetShare = 0.99;  // what exec_us of a robot file means
constexpr double kShares[] = {0.01, 0.1, 0.5, 0.9, kBudgetShare, 0.999, 0.9999, 1.0};

/// How much slower the robot's board is than the machine of the profile.
double board_factor(const rt::ExecModel& said, const rt::ExecModel& measured) {
  if (said.kind != rt::ExecModel::Kind::constant) return 1.0;
  for (const auto& q : measured.quantiles)
    if (q.share >= kBudgetShare)
      return static_cast<double>(said.constant.count()) / static_cast<double>(q.exec.count());
  return 1.0;
}

}  // namespace

std::vector<std::string> ExecProfile::apply(rt::GraphSpec& graph,
                                            const std::function<double(const std::string&)>& factor_of) const {
  std::vector<std::string> unknown;
  for (const auto& [name, model] : module) {
    rt::ExecModel* exec = name == "guardian" ? &graph.guardian.exec : nullptr;
    for (auto& m : graph.modules)
      if (m.name == name) exec = &m.exec;
    if (!exec) {
      unknown.push_back(name);
      continue;
    }
    const double factor = board_factor(*exec, model) * factor_of(name);
    *exec = model;
    exec->factor = factor;
  }
  return unknown;
}

std::string profile_path(const std::string& robot_path) {
  const auto dot = robot_path.rfind(".toml");
  return robot_path.substr(0, dot) + "_exec.toml";
}

ExecProfile parse_profile(std::string_view text, const std::string& path, std::vector<rt::Problem>& problems) {
  ExecProfile profile;
  const toml::parse_result parsed = toml::parse(text, path);
  if (!parsed) {
    const auto& e = parsed.error();
    problems.push_back({static_cast<int>(e.source().begin.line), "TOML", "syntax", std::string(e.description())});
    return profile;
  }
  app::TomlReader root(parsed.table(), "", problems);
  root.require("measured", profile.measured);
  root.tables_by_name("module", [&](const std::string& name, app::TomlReader& r) {
    rt::ExecModel& exec = profile.module[name];
    app::read_exec(r, exec);
    if (exec.kind != rt::ExecModel::Kind::quantiles) r.missing("exec_quantiles_us", "it is required");
  });
  root.finish();
  return profile;
}

ExecProfile load_profile(const std::string& path, std::vector<rt::Problem>& problems) {
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    problems.push_back({0, "file", path, "a profile of execution times; sinew-fuzz ROBOT --measure writes one"});
    return {};
  }
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  return parse_profile(text, path, problems);
}

rt::ExecModel model_of(std::vector<rt::Duration>& samples) {
  std::sort(samples.begin(), samples.end());
  rt::ExecModel model;
  model.kind = rt::ExecModel::Kind::quantiles;
  for (const double share : kShares) {
    const auto below = static_cast<std::size_t>(share * static_cast<double>(samples.size()));
    const std::size_t rank = std::min(below, samples.size() - 1);
    model.quantiles.push_back({share, std::max(samples[rank], rt::Duration{1})});
  }
  return model;
}

std::string to_text(const ExecProfile& profile) {
  std::string text = fmt::format(
      "# How long the steps take, by quantiles [share, us]: sinew-fuzz draws its jitter from this (docs/search.md).\n"
      "# Written by sinew-fuzz --measure.\n\nmeasured = \"{}\"\n\n[module]\n",
      profile.measured);
  std::size_t width = 0;
  for (const auto& [name, model] : profile.module) width = std::max(width, name.size());
  for (const auto& [name, model] : profile.module) {
    std::string pairs;
    for (const auto& q : model.quantiles)
      pairs += fmt::format("{}[{}, {}]", pairs.empty() ? "" : ", ", q.share, static_cast<double>(q.exec.count()) / 1e3);
    text += fmt::format("{:{}} = {{ exec_quantiles_us = [{}] }}\n", name, width, pairs);
  }
  return text;
}

}  // namespace sinew::search
