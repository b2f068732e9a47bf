#pragma once
#include <initializer_list>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/device_spec.hpp"

namespace sinew::drivers {

/// Reads the keys of a DeviceSpec one by one, so that what is left over is unknown. What does not fit becomes a problem
/// and the default stays: all problems come in one run.
class DeviceKeys {
 public:
  DeviceKeys(const DeviceSpec& spec, std::string path, std::vector<rt::Problem>& problems)
      : spec_(spec), path_(std::move(path)), problems_(problems) {}

  const DeviceSpec& spec() const { return spec_; }
  const std::string& path() const { return path_; }
  std::vector<rt::Problem>& problems() { return problems_; }
  bool has(std::string_view key) const { return spec_.keys.contains(std::string(key)); }

  bool read(std::string_view key, std::string& out, std::string_view allowed);
  bool read(std::string_view key, bool& out);
  /// Limits are inclusive.
  bool read(std::string_view key, double& out, double min, double max);
  template <class Integer>
  bool read_integer(std::string_view key, Integer& out, std::int64_t min, std::int64_t max) {
    std::int64_t value = 0;
    if (!read_int64(key, value, min, max)) return false;
    return out = static_cast<Integer>(value), true;
  }
  template <class E>
  bool read_choice(std::string_view key, E& out, std::initializer_list<std::pair<std::string_view, E>> choices) {
    std::string text, allowed = "one of";
    for (const auto& [name, value] : choices)
      allowed += (allowed == "one of" ? " \"" : ", \"") + std::string(name) + '"';
    if (!read(key, text, allowed)) return false;
    for (const auto& [name, value] : choices)
      if (text == name) return out = value, true;
    problem(key, allowed);
    return false;
  }
  /// A key without which the device is nothing.
  void require(std::string_view key, std::string& out, std::string_view allowed);

  /// Says what is wrong with the value of `key`, or, where it is not there, that it is missing.
  void problem(std::string_view key, std::string_view allowed);
  /// The device has `place`, which the value of `key` names, for itself: "serial line /dev/ttyS1". check_devices()
  /// finds those that two devices claim.
  void claim(std::string_view key, std::string place) { claims_.push_back({std::string(key), std::move(place)}); }
  struct Claim {
    std::string key, place;
  };
  const std::vector<Claim>& claims() const { return claims_; }

  /// Every key that nobody asked for becomes a problem that lists the known ones.
  void finish();

 private:
  const rt::Located<rt::ParamValue>* take(std::string_view key);
  bool read_int64(std::string_view key, std::int64_t& out, std::int64_t min, std::int64_t max);

  const DeviceSpec& spec_;
  std::string path_;
  std::vector<rt::Problem>& problems_;
  std::set<std::string, std::less<>> known_;
  std::vector<Claim> claims_;
};

}  // namespace sinew::drivers
