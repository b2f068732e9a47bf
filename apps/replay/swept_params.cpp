#include "apps/replay/swept_params.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/robot_file/value_list.hpp"
#include "hal/did_you_mean.hpp"
#include "rt/parameters.hpp"

namespace sinew::app {
namespace {

std::string names_of(const rt::GraphModule& module) {
  std::string all;
  for (const auto& p : module.declaration.params) all += (all.empty() ? "" : ", ") + p.name;
  return all.empty() ? "none" : all;
}

std::string near_param(const rt::GraphModule& module, const std::string& asked) {
  std::vector<std::string> names;
  for (const auto& p : module.declaration.params) names.push_back(p.name);
  return hal::did_you_mean(asked, names);
}

}  // namespace

std::optional<SweptParam> parse_sweep(const std::string& text, const rt::Graph& graph, std::string& why) {
  const auto fail = [&](const std::string& words) {
    why = fmt::format("--param {}: {}", text, words);
    return std::nullopt;
  };
  const auto dot = text.find('.'), equals = text.find('=');
  if (dot == std::string::npos || equals == std::string::npos || equals < dot) return fail(kValueListForms);
  SweptParam swept{text.substr(0, dot), text.substr(dot + 1, equals - dot - 1), {}};
  const std::uint32_t index = graph.find_module(swept.module);
  if (index == rt::kNone) {
    std::string all;
    std::vector<std::string> names;
    for (const auto& m : graph.modules()) all += (all.empty() ? "" : ", ") + m.spec.name, names.push_back(m.spec.name);
    return fail(
        fmt::format("no module {}; there are: {}{}", swept.module, all, hal::did_you_mean(swept.module, names)));
  }
  const rt::GraphModule& module = graph.modules()[index];
  const auto* param = rt::find_param(module.declaration, swept.param);
  if (!param)
    return fail(fmt::format("{} has no parameter {}; it has: {}{}", swept.module, swept.param, names_of(module),
                            near_param(module, swept.param)));
  if (!value_list(text.substr(equals + 1), value_kind(*param), swept.values, why)) return fail(std::string(why));
  std::vector<rt::ParamValue> once;
  for (const auto& value : swept.values) {
    if (!rt::accepts(*param, value))
      return fail(fmt::format("{}: {}", rt::to_string(value), rt::allowed_values(*param)));
    if (std::find(once.begin(), once.end(), value) == once.end()) once.push_back(value);
  }
  swept.values = std::move(once);
  return swept;
}

std::vector<SweepPoint> grid(const std::vector<SweptParam>& params) {
  std::vector<SweepPoint> points(1);
  for (const SweptParam& p : params) {
    std::vector<SweepPoint> more;
    for (const SweepPoint& point : points)
      for (const auto& value : p.values) {
        more.push_back(point);
        more.back().push_back(value);
      }
    points = std::move(more);
  }
  return points;
}

void apply(const std::vector<SweptParam>& params, const SweepPoint& point, rt::GraphSpec& spec) {
  for (std::size_t i = 0; i < params.size(); ++i)
    for (auto& m : spec.modules)
      if (m.name == params[i].module) m.params[params[i].param] = {point[i], 0};
}

}  // namespace sinew::app
