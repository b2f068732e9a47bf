#include "drivers/device_keys.hpp"

#include <charconv>

namespace sinew::drivers {
namespace {

std::string number_text(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

std::string value_text(const rt::ParamValue& value) {
  if (const auto* b = std::get_if<bool>(&value)) return *b ? "true" : "false";
  if (const auto* i = std::get_if<std::int64_t>(&value)) return std::to_string(*i);
  if (const auto* d = std::get_if<double>(&value)) return number_text(*d);
  return '"' + std::get<std::string>(value) + '"';
}

}  // namespace

const rt::Located<rt::ParamValue>* DeviceKeys::take(std::string_view key) {
  known_.emplace(key);
  const auto it = spec_.keys.find(std::string(key));
  return it == spec_.keys.end() ? nullptr : &it->second;
}

bool DeviceKeys::read(std::string_view key, std::string& out, std::string_view allowed) {
  const auto* value = take(key);
  if (!value) return false;
  const auto* text = std::get_if<std::string>(&value->value);
  if (!text || text->empty()) return problem(key, allowed), false;
  return out = *text, true;
}

bool DeviceKeys::read(std::string_view key, bool& out) {
  const auto* value = take(key);
  if (!value) return false;
  const auto* flag = std::get_if<bool>(&value->value);
  if (!flag) return problem(key, "true or false"), false;
  return out = *flag, true;
}

bool DeviceKeys::read(std::string_view key, double& out, double min, double max) {
  const auto* value = take(key);
  if (!value) return false;
  const auto* whole = std::get_if<std::int64_t>(&value->value);
  const auto* real = std::get_if<double>(&value->value);
  const double number = whole ? static_cast<double>(*whole) : real ? *real : 0.0;
  // Written so that what is not a number is refused.
  if ((whole || real) && number >= min && number <= max) return out = number, true;
  problem(key, "a number from " + number_text(min) + " to " + number_text(max));
  return false;
}

bool DeviceKeys::read_int64(std::string_view key, std::int64_t& out, std::int64_t min, std::int64_t max) {
  const auto* value = take(key);
  if (!value) return false;
  const auto* whole = std::get_if<std::int64_t>(&value->value);
  if (whole && *whole >= min && *whole <= max) return out = *whole, true;
  problem(key, "an integer from " + std::to_string(min) + " to " + std::to_string(max));
  return false;
}

void DeviceKeys::require(std::string_view key, std::string& out, std::string_view allowed) {
  if (!has(key)) {
    known_.emplace(key);
    problem(key, std::string(allowed) + "; it is required");
    return;
  }
  read(key, out, allowed);
}

void DeviceKeys::problem(std::string_view key, std::string_view allowed) {
  const auto it = spec_.keys.find(std::string(key));
  const bool there = it != spec_.keys.end();
  problems_.push_back({there ? it->second.line : spec_.line, path_ + '.' + std::string(key),
                       there ? value_text(it->second.value) : "missing", std::string(allowed)});
}

void DeviceKeys::finish() {
  std::string names;
  for (const std::string& name : known_) names += (names.empty() ? "" : ", ") + name;
  for (const auto& [key, value] : spec_.keys)
    if (!known_.contains(key))
      problems_.push_back(
          {value.line, path_ + '.' + key, value_text(value.value), names.empty() ? "no key" : "one of " + names});
}

}  // namespace sinew::drivers
