#include "rt/parameters.hpp"

#include <algorithm>
#include <charconv>

namespace sinew::rt {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::max();

/// "a number from 0 to 2 rad"
std::string range_words(const Declaration::Param& p, double min, double max) {
  const bool low = min > -kUnbounded, high = max < kUnbounded;
  std::string words = std::holds_alternative<std::int64_t*>(p.target) ? "an integer" : "a number";
  if (low) words += " from " + format_number(min);
  if (high) words += (low ? " to " : " up to ") + format_number(max);
  if (low && !high) words += " up";
  if (!p.unit.empty() && p.unit != "1") words += (low || high ? " " : " in ") + p.unit;
  return words;
}

bool in_range(const Declaration::Param& p, double value, const std::optional<ParamRange>& narrowed) {
  if (!(value >= p.min && value <= p.max)) return false;  // NaN, too
  return !narrowed || value == narrowed->besides || (value >= narrowed->min && value <= narrowed->max);
}

}  // namespace

std::string format_number(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

std::string to_string(const ParamValue& value) {
  if (const bool* b = std::get_if<bool>(&value)) return *b ? "true" : "false";
  if (const auto* i = std::get_if<std::int64_t>(&value)) return std::to_string(*i);
  if (const auto* d = std::get_if<double>(&value)) return format_number(*d);
  return '"' + std::get<std::string>(value) + '"';
}

ParamRange within(const Declaration::Param& p, ParamRange range) {
  range.min = std::max(range.min, p.min), range.max = std::min(range.max, p.max);
  if (range.min > range.max && range.besides) range.min = range.max = *range.besides;
  if (range.besides && *range.besides >= range.min && *range.besides <= range.max) range.besides.reset();
  return range;
}

std::string allowed_values(const Declaration::Param& p, const std::optional<ParamRange>& narrowed) {
  if (std::holds_alternative<bool*>(p.target)) return "true or false";
  if (std::holds_alternative<std::string*>(p.target)) return "a string";
  if (!narrowed) return range_words(p, p.min, p.max);
  std::string words = narrowed->min > narrowed->max ? "nothing" : range_words(p, narrowed->min, narrowed->max);
  if (narrowed->min == narrowed->max) words = "only " + format_number(narrowed->min);
  if (narrowed->besides) words += ", or " + format_number(*narrowed->besides);
  return words + ": " + narrowed->because;
}

bool accepts(const Declaration::Param& p, const ParamValue& value, const std::optional<ParamRange>& narrowed) {
  if (std::holds_alternative<bool*>(p.target)) return std::holds_alternative<bool>(value);
  if (std::holds_alternative<std::string*>(p.target)) return std::holds_alternative<std::string>(value);
  const auto* integer = std::get_if<std::int64_t>(&value);
  if (integer) return in_range(p, static_cast<double>(*integer), narrowed);
  const auto* number = std::get_if<double>(&value);
  return number && std::holds_alternative<double*>(p.target) && in_range(p, *number, narrowed);
}

void assign(const Declaration::Param& p, const ParamValue& value) {
  if (auto* b = std::get_if<bool*>(&p.target)) {
    **b = std::get<bool>(value);
  } else if (auto* s = std::get_if<std::string*>(&p.target)) {
    **s = std::get<std::string>(value);
  } else if (auto* i = std::get_if<std::int64_t*>(&p.target)) {
    **i = std::get<std::int64_t>(value);
  } else {
    const auto* integer = std::get_if<std::int64_t>(&value);
    *std::get<double*>(p.target) = integer ? static_cast<double>(*integer) : std::get<double>(value);
  }
}

ParamValue current(const Declaration::Param& p) {
  return std::visit([](const auto* target) { return ParamValue(*target); }, p.target);
}

const Declaration::Param* find_param(const Declaration& declaration, std::string_view name) {
  for (const auto& p : declaration.params)
    if (p.name == name) return &p;
  return nullptr;
}

}  // namespace sinew::rt
