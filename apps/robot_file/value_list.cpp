#include "apps/robot_file/value_list.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "apps/robot_file/param_value.hpp"

namespace sinew::app {
namespace {

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
    why = kValueListForms;
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

}  // namespace

ValueKind value_kind(const rt::Declaration::Param& param) {
  if (std::holds_alternative<std::string*>(param.target)) return ValueKind::text;
  return std::holds_alternative<std::int64_t*>(param.target) ? ValueKind::integer : ValueKind::number;
}

bool value_list(const std::string& text, ValueKind kind, std::vector<rt::ParamValue>& values, std::string& why) {
  if (kind != ValueKind::text && text.find(':') != std::string::npos)
    return range_values(text, kind == ValueKind::integer, values, why);
  for (const std::string& value : split(text, ',')) values.push_back(param_value(value));
  return true;
}

}  // namespace sinew::app
