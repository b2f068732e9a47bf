#include "monitor/control.hpp"

#include <algorithm>
#include <utility>

#include "monitor/gate.hpp"

namespace sinew::monitor {

std::string Control::take(std::string_view who, std::string_view key, std::string fresh_key, Time now) {
  if (is_held(now)) {
    if (!equal_in_constant_time(key, key_)) return {};
  } else {
    key_ = std::move(fresh_key);
    asked_.clear();
  }
  who_ = who.substr(0, kMostName);
  until_ = now + kLease;
  return key_;
}

bool Control::keep(std::string_view key, Time now) {
  if (!is_held(now) || !equal_in_constant_time(key, key_)) return false;
  until_ = now + kLease;
  return true;
}

bool Control::release(std::string_view key, Time now) {
  if (!is_held(now) || !equal_in_constant_time(key, key_)) return false;
  key_.clear(), who_.clear(), asked_.clear();
  return true;
}

bool Control::ask(std::string_view who, Time now) {
  if (!is_held(now)) return false;
  const std::string name(who.substr(0, kMostName));
  if (std::find(asked_.begin(), asked_.end(), name) != asked_.end()) return true;
  if (asked_.size() >= kMostAsked) return false;
  asked_.push_back(name);
  return true;
}

bool Control::allows(std::string_view key, Time now) const {
  return !is_held(now) || equal_in_constant_time(key, key_);
}

}  // namespace sinew::monitor
