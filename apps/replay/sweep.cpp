#include "apps/replay/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "apps/robot_file/param_value.hpp"
#include "rt/parameters.hpp"

namespace sinew::app {
namespace {

constexpr const char* kForm = "MODULE.PARAM=FROM:TO:COUNT, the same with :log, or MODULE.PARAM=A,B,C";
constexpr std::int64_t kMostValues = 100'000;

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == at)
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

bool read_number(const std::string& text, double& value) {
  const char* const end = text.data() + text.size();
  const auto r = std::from_chars(text.data(), end, value);
  return r.ec == std::errc() && r.ptr == end && std::isfinite(value);
}

/// FROM:TO:COUNT[:log].
bool range_values(const std::string& text, bool integers, std::vector<rt::ParamValue>& values, std::string& why) {
  const auto parts = split(text, ':');
  double from = 0, to = 0, count = 0;
  const bool log = parts.size() == 4;
  const bool formed = (parts.size() == 3 || (log && parts[3] == "log")) && read_number(parts[0], from) &&
                      read_number(parts[1], to) && read_number(parts[2], count);
  if (!formed) {
    why = kForm;
    return false;
  }
  if (!(count >= 1 && count <= kMostValues) || count != std::floor(count)) {
    why = fmt::format("\"{}\": a count from 1 to {}", parts[2], kMostValues);
    return false;
  }
  if (log && !(from > 0 && to > 0)) {
    why = "with :log both ends are above 0";
    return false;
  }
  const auto n = static_cast<std::int64_t>(count);
  for (std::int64_t i = 0; i < n; ++i) {
    const double share = n == 1 ? 0 : static_cast<double>(i) / static_cast<double>(n - 1);
    double value = log ? from * std::pow(to / from, share) : from + share * (to - from);
    if (i == n - 1 && n > 1) value = to;  // the exact end, without rounding errors
    // Only six digits: a value that is found goes into a robot file.
    if (i > 0 && i < n - 1) value = std::stod(fmt::format("{:.6g}", value));
    values.push_back(integers ? rt::ParamValue(static_cast<std::int64_t>(std::llround(value))) : rt::ParamValue(value));
  }
  return true;
}

std::string names_of(const rt::GraphModule& module) {
  std::string all;
  for (const auto& p : module.declaration.params) all += (all.empty() ? "" : ", ") + p.name;
  return all.empty() ? "none" : all;
}

}  // namespace

std::optional<SweptParam> parse_sweep(const std::string& text, const rt::Graph& graph, std::string& why) {
  const auto fail = [&](const std::string& words) {
    why = fmt::format("--param {}: {}", text, words);
    return std::nullopt;
  };
  const auto dot = text.find('.'), equals = text.find('=');
  if (dot == std::string::npos || equals == std::string::npos || equals < dot) return fail(kForm);
  SweptParam swept{text.substr(0, dot), text.substr(dot + 1, equals - dot - 1), {}};
  const std::uint32_t index = graph.find_module(swept.module);
  if (index == rt::kNone) {
    std::string all;
    for (const auto& m : graph.modules()) all += (all.empty() ? "" : ", ") + m.spec.name;
    return fail(fmt::format("no module {}; there are: {}", swept.module, all));
  }
  const rt::GraphModule& module = graph.modules()[index];
  const auto* param = rt::find_param(module.declaration, swept.param);
  if (!param)
    return fail(fmt::format("{} has no parameter {}; it has: {}", swept.module, swept.param, names_of(module)));
  const std::string values = text.substr(equals + 1);
  if (values.find(':') != std::string::npos && !std::holds_alternative<std::string*>(param->target)) {
    if (!range_values(values, std::holds_alternative<std::int64_t*>(param->target), swept.values, why))
      return fail(std::string(why));
  } else {
    for (const auto& value : split(values, ',')) swept.values.push_back(param_value(value));
  }
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
