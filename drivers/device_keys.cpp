#include "drivers/device_keys.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

#include "drivers/key_number.hpp"
#include "hal/did_you_mean.hpp"

namespace sinew::drivers {
namespace {

constexpr double kMs = 1e6;  // ns
constexpr std::string_view kFamilyName = "NAME";

std::string number_text(std::int64_t value, bool hex) {
  if (!hex || value < 0) return std::to_string(value);
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, 16).ptr;
  for (char* c = text; c != end; ++c) *c = static_cast<char>(std::toupper(static_cast<unsigned char>(*c)));
  return "0x" + std::string(text, end);
}

std::string value_text(const rt::ParamValue& value, bool hex) {
  if (const auto* b = std::get_if<bool>(&value)) return *b ? "true" : "false";
  if (const auto* i = std::get_if<std::int64_t>(&value)) return number_text(*i, hex);
  if (const auto* d = std::get_if<double>(&value)) return key_number(*d);
  return '"' + std::get<std::string>(value) + '"';
}

/// The number that a key says. None: it says no number, or one outside [min, max]; NaN is outside.
std::optional<double> number_within(const rt::ParamValue& value, double min, double max) {
  double number = 0;
  if (const auto* whole = std::get_if<std::int64_t>(&value))
    number = static_cast<double>(*whole);
  else if (const auto* real = std::get_if<double>(&value))
    number = *real;
  else
    return std::nullopt;
  if (number >= min && number <= max) return number;
  return std::nullopt;
}

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

/// An error puts `before` in front of the allowed values.
KeyRow row(std::string_view type, std::string otherwise, std::string_view before, std::string allowed) {
  KeyRow r;
  r.type = type, r.otherwise = std::move(otherwise), r.allowed = std::move(allowed);
  r.says = std::string(before) + r.allowed;
  return r;
}

constexpr std::string_view kIntegerFrom = "an integer from ", kNumberFrom = "a number from ", kOneOf = "one of ";

}  // namespace

const DeviceKeys::Value* DeviceKeys::declare(std::string_view key, const KeyInfo& info, KeyRow row) {
  row.key = key, row.unit = info.unit, row.doc = info.doc, row.required = info.required, row.hex = info.hex;
  row.in_words = !info.otherwise.empty();
  if (row.in_words) row.otherwise = info.otherwise;
  if (info.required) row.otherwise.clear();
  if (!info.allowed.empty()) row.allowed = row.says = info.allowed;
  rows_.push_back(std::move(row));
  const auto it = spec_.keys.find(std::string(key));
  if (it != spec_.keys.end()) return &it->second;
  if (info.required) problem(key, rows_.back().says + "; it is required");
  return nullptr;
}

const KeyRow* DeviceKeys::row_of(std::string_view key) const {
  const auto it = std::find_if(rows_.begin(), rows_.end(), [&](const KeyRow& r) { return r.key == key; });
  return it == rows_.end() ? nullptr : &*it;
}

bool DeviceKeys::refuse(std::string_view key) {
  problem(key, row_of(key)->says);
  return false;
}

bool DeviceKeys::read(std::string_view key, std::string& out, std::string_view allowed, const KeyInfo& info) {
  const Value* value =
      declare(key, info, row("text", out.empty() ? std::string() : quoted(out), "", std::string(allowed)));
  if (!value) return false;
  const auto* text = std::get_if<std::string>(&value->value);
  if (!text || text->empty()) return refuse(key);
  out = *text;
  return true;
}

bool DeviceKeys::read_text_or_number(std::string_view key, std::string& out, std::string_view allowed,
                                     const KeyInfo& info) {
  const auto it = spec_.keys.find(std::string(key));
  const auto* whole = it == spec_.keys.end() ? nullptr : std::get_if<std::int64_t>(&it->second.value);
  if (!whole) return read(key, out, allowed, info);
  static_cast<void>(declare(key, info, row("text", {}, "", std::string(allowed))));
  out = std::to_string(*whole);
  return true;
}

bool DeviceKeys::read(std::string_view key, bool& out, const KeyInfo& info) {
  const Value* value = declare(key, info, row("boolean", out ? "true" : "false", "", "true or false"));
  if (!value) return false;
  const auto* flag = std::get_if<bool>(&value->value);
  if (!flag) return refuse(key);
  out = *flag;
  return true;
}

bool DeviceKeys::read(std::string_view key, double& out, double min, double max, const KeyInfo& info) {
  const Value* value =
      declare(key, info, row("number", key_number(out), kNumberFrom, key_number(min) + " to " + key_number(max)));
  if (!value) return false;
  if (const auto number = number_within(value->value, min, max)) {
    out = *number;
    return true;
  }
  return refuse(key);
}

bool DeviceKeys::read_ms(std::string_view key, hal::Duration& out, double min_ms, double max_ms, KeyInfo info) {
  info.unit = "ms";
  double ms = static_cast<double>(out.count()) / kMs;
  if (!read(key, ms, min_ms, max_ms, info)) return false;
  out = hal::Duration{static_cast<std::int64_t>(ms * kMs)};
  return true;
}

bool DeviceKeys::read_int64(std::string_view key, std::int64_t& out, std::int64_t min, std::int64_t max,
                            const KeyInfo& info) {
  const Value* value = declare(key, info,
                               row("integer", number_text(out, info.hex), kIntegerFrom,
                                   number_text(min, info.hex) + " to " + number_text(max, info.hex)));
  if (!value) return false;
  const auto* whole = std::get_if<std::int64_t>(&value->value);
  if (whole && *whole >= min && *whole <= max) {
    out = *whole;
    return true;
  }
  return refuse(key);
}

bool DeviceKeys::read_listed(std::string_view key, std::int64_t& out, std::initializer_list<std::int64_t> values,
                             const KeyInfo& info) {
  std::string list;
  for (const std::int64_t v : values) list += (list.empty() ? "" : ", ") + number_text(v, info.hex);
  const Value* value = declare(key, info, row("integer", number_text(out, info.hex), kOneOf, list));
  if (!value) return false;
  const auto* whole = std::get_if<std::int64_t>(&value->value);
  if (whole && std::find(values.begin(), values.end(), *whole) != values.end()) {
    out = *whole;
    return true;
  }
  return refuse(key);
}

bool DeviceKeys::read_named(std::string_view key, std::size_t& chosen, const std::vector<std::string_view>& names,
                            const KeyInfo& info) {
  std::string list;
  for (const std::string_view name : names) list += (list.empty() ? "" : ", ") + quoted(name);
  const Value* value =
      declare(key, info, row("choice", chosen < names.size() ? quoted(names[chosen]) : std::string(), kOneOf, list));
  if (!value) return false;
  const auto* text = std::get_if<std::string>(&value->value);
  const auto found = text ? std::find(names.begin(), names.end(), *text) : names.end();
  if (found == names.end()) {
    problem(key, row_of(key)->says +
                     hal::did_you_mean(text ? *text : "", std::vector<std::string>(names.begin(), names.end())));
    return false;
  }
  chosen = static_cast<std::size_t>(found - names.begin());
  return true;
}

void DeviceKeys::read_all(std::string_view prefix, std::map<std::string, double, std::less<>>& out, double min,
                          double max, const KeyInfo& info) {
  KeyRow family = row("number", {}, kNumberFrom, key_number(min) + " to " + key_number(max));
  family.family = true;
  static_cast<void>(declare(std::string(prefix) + std::string(kFamilyName), info, family));
  for (const auto& [key, value] : spec_.keys) {
    if (!key.starts_with(prefix)) continue;
    const auto number = number_within(value.value, min, max);
    if (number && key.size() > prefix.size())
      out.emplace(key.substr(prefix.size()), *number);
    else
      problem(key, family.says);
  }
}

void DeviceKeys::problem(std::string_view key, std::string_view allowed) {
  if (!told_.emplace(key).second) return;
  const auto it = spec_.keys.find(std::string(key));
  const KeyRow* row = row_of(key);
  if (it != spec_.keys.end()) {
    problems_.push_back({it->second.line, path_ + '.' + it->first, value_text(it->second.value, row && row->hex),
                         std::string(allowed)});
    return;
  }
  const bool has_default = row && !row->in_words && !row->otherwise.empty();
  problems_.push_back({spec_.line, path_ + '.' + std::string(key),
                       has_default ? "default " + row->otherwise : "missing", std::string(allowed)});
}

void DeviceKeys::refuse_driver(std::span<const std::string_view> drivers) {
  std::string names;
  for (const std::string_view name : drivers) names += (names.empty() ? "" : ", ") + quoted(name);
  names += hal::did_you_mean(spec_.driver, std::vector<std::string>(drivers.begin(), drivers.end()));
  problems_.push_back(
      {spec_.line, path_ + ".driver", spec_.driver.empty() ? "missing" : quoted(spec_.driver), "one of " + names});
  has_driver_ = false;
}

void DeviceKeys::finish() {
  if (!has_driver_) return;
  std::set<std::string> sorted;
  for (const KeyRow& r : rows_) sorted.insert(r.key);
  std::string names;
  for (const std::string& name : sorted) names += (names.empty() ? "" : ", ") + name;
  const std::vector<std::string> known(sorted.begin(), sorted.end());
  const auto is_known = [&](const std::string& key) {
    return std::any_of(rows_.begin(), rows_.end(), [&](const KeyRow& r) {
      return r.key == key || (r.family && key.starts_with(r.key.substr(0, r.key.size() - kFamilyName.size())));
    });
  };
  for (const auto& [key, value] : spec_.keys)
    if (!is_known(key)) problem(key, names.empty() ? "no key" : "one of " + names + hal::did_you_mean(key, known));
}

}  // namespace sinew::drivers
