#include "rt/parameters.hpp"

#include <charconv>

namespace sinew::rt {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::max();

std::string range_words(const Declaration::Param& p) {
  const bool low = p.min > -kUnbounded, high = p.max < kUnbounded;
  std::string words;
  if (low) words += " from " + format_number(p.min);
  if (high) words += (low ? " to " : " up to ") + format_number(p.max);
  if (low && !high) words += " up";
  if (!p.unit.empty() && p.unit != "1") words += (low || high ? " " : " in ") + p.unit;
  return words;
}

bool in_range(const Declaration::Param& p, double value) { return value >= p.min && value <= p.max; }  // false for NaN

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

std::string allowed_values(const Declaration::Param& p) {
  if (std::holds_alternative<bool*>(p.target)) return "true or false";
  if (std::holds_alternative<std::string*>(p.target)) return "a string";
  return (std::holds_alternative<std::int64_t*>(p.target) ? "an integer" : "a number") + range_words(p);
}

bool accepts(const Declaration::Param& p, const ParamValue& value) {
  if (std::holds_alternative<bool*>(p.target)) return std::holds_alternative<bool>(value);
  if (std::holds_alternative<std::string*>(p.target)) return std::holds_alternative<std::string>(value);
  const auto* integer = std::get_if<std::int64_t>(&value);
  if (integer) return in_range(p, static_cast<double>(*integer));
  const auto* number = std::get_if<double>(&value);
  return number && std::holds_alternative<double*>(p.target) && in_range(p, *number);
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
