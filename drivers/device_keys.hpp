#pragma once
#include <chrono>
#include <functional>
#include <initializer_list>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "drivers/device_spec.hpp"
#include "hal/clock.hpp"

namespace sinew::drivers {

/// What a key is, beside the values that it takes.
struct KeyInfo {
  std::string_view unit = {};
  std::string_view doc = {};
  std::string_view otherwise = {};  // words for the default, where it is no value of the key: "as it is"
  std::string_view allowed = {};    // replaces the allowed values that read() would tell, where they say too much
  bool required = false;
  bool hex = false;  // its numbers are written in hexadecimal
};

/// One row of a driver's table of keys: what a robot file may say, and the default.
struct KeyRow {
  std::string key;        // "rate_hz"; "control_NAME": all that begin so
  std::string type;       // "boolean", "integer", "number", "text", "choice"
  std::string unit;       // empty: none
  std::string otherwise;  // the default; empty: none. Words when `in_words`
  std::string allowed;    // "4 to 1000", "2, 4, 8, 16"
  std::string says;       // the same in an error: "an integer from 4 to 1000", "one of 2, 4, 8, 16"
  std::string doc;
  bool required = false, in_words = false, hex = false;
  bool family = false;  // see `key`
};

/// Reads the keys of a DeviceSpec one by one, which also declares them: each read() is a row of the driver's table,
/// whose default is the value that `out` held. So a driver's reader is the only source of its keys, their errors and
/// their documentation. It reads all of its keys, whatever the values of the others are.
/// A value that does not fit becomes a problem, and the default stays. One run finds all problems, at most one a key.
class DeviceKeys {
 public:
  DeviceKeys(const DeviceSpec& spec, std::string path, std::vector<rt::Problem>& problems)
      : spec_(spec), path_(std::move(path)), problems_(problems) {}

  const DeviceSpec& spec() const { return spec_; }
  const std::string& path() const { return path_; }
  std::vector<rt::Problem>& problems() { return problems_; }
  bool has(std::string_view key) const { return spec_.keys.contains(std::string(key)); }

  // True: the robot file has the key, and `out` holds its value.

  /// `allowed` in words; an empty text is never allowed.
  bool read(std::string_view key, std::string& out, std::string_view allowed, const KeyInfo& info);
  /// A whole number counts as its text.
  bool read_text_or_number(std::string_view key, std::string& out, std::string_view allowed, const KeyInfo& info);
  bool read(std::string_view key, bool& out, const KeyInfo& info);
  /// Limits are inclusive.
  bool read(std::string_view key, double& out, double min, double max, const KeyInfo& info);
  /// A number of milliseconds.
  bool read_ms(std::string_view key, hal::Duration& out, double min_ms, double max_ms, KeyInfo info);
  template <class Integer>
  bool read_integer(std::string_view key, Integer& out, std::int64_t min, std::int64_t max, const KeyInfo& info) {
    std::int64_t value = out;
    if (!read_int64(key, value, min, max, info)) return false;
    out = static_cast<Integer>(value);
    return true;
  }
  /// One of a few whole numbers.
  template <class Integer>
  bool read_one_of(std::string_view key, Integer& out, std::initializer_list<std::int64_t> values,
                   const KeyInfo& info) {
    std::int64_t value = out;
    if (!read_listed(key, value, values, info)) return false;
    out = static_cast<Integer>(value);
    return true;
  }
  template <class E>
  bool read_choice(std::string_view key, E& out, std::initializer_list<std::pair<std::string_view, E>> choices,
                   const KeyInfo& info) {
    return read_choice(key, out, std::span(choices.begin(), choices.size()), info);
  }
  template <class E>
  bool read_choice(std::string_view key, E& out,
                   std::span<const std::pair<std::string_view, std::type_identity_t<E>>> choices, const KeyInfo& info) {
    std::vector<std::string_view> names;
    std::size_t chosen = choices.size();
    for (const auto& [name, value] : choices) {
      if (value == out) chosen = names.size();
      names.push_back(name);
    }
    if (!read_named(key, chosen, names, info)) return false;
    out = choices[chosen].second;
    return true;
  }
  /// All keys that begin with `prefix`: numbers, by what follows it.
  void read_all(std::string_view prefix, std::map<std::string, double, std::less<>>& out, double min, double max,
                const KeyInfo& info);

  /// Adds a problem of `key` (its value is wrong or missing), unless it has one already.
  void problem(std::string_view key, std::string_view allowed);
  /// Whether `key` has a problem.
  bool told(std::string_view key) const { return told_.contains(key); }
  /// Adds a problem: the `driver` of the table is none of these. Its keys get no problems then.
  void refuse_driver(std::span<const std::string_view> drivers);
  /// The device needs `place` for itself: "serial line /dev/ttyS1". The value of `key` names it. check_devices() finds
  /// places that two devices claim.
  void claim(std::string_view key, std::string place) { claims_.push_back({std::string(key), std::move(place)}); }
  struct Claim {
    std::string key, place;
  };
  const std::vector<Claim>& claims() const { return claims_; }

  /// Every key that nobody asked for becomes a problem that lists the known ones.
  void finish();
  /// All that was read, in this order.
  const std::vector<KeyRow>& rows() const { return rows_; }

 private:
  using Value = rt::Located<rt::ParamValue>;
  // Notes the row. Null: the table lacks the key, which is a problem when the key is required.
  const Value* declare(std::string_view key, const KeyInfo& info, KeyRow row);
  const KeyRow* row_of(std::string_view key) const;
  bool read_int64(std::string_view key, std::int64_t& out, std::int64_t min, std::int64_t max, const KeyInfo& info);
  bool read_listed(std::string_view key, std::int64_t& out, std::initializer_list<std::int64_t> values,
                   const KeyInfo& info);
  bool read_named(std::string_view key, std::size_t& chosen, const std::vector<std::string_view>& names,
                  const KeyInfo& info);
  bool refuse(std::string_view key);

  const DeviceSpec& spec_;
  std::string path_;
  std::vector<rt::Problem>& problems_;
  std::vector<KeyRow> rows_;
  std::set<std::string, std::less<>> told_;
  bool has_driver_ = true;
  std::vector<Claim> claims_;
};

}  // namespace sinew::drivers
