#pragma once
#include <optional>
#include <string>

#include "msg/time.hpp"

namespace sinew::search {

/// An invariant that did not hold.
struct Violation {
  std::string invariant;  // "lease", "tilt", ...: docs/search.md
  msg::Time at;
  std::string what;
};

/// Keeps the first violation of a run: what comes after it may only follow from it.
/// Thread:  owner.
class Verdict {
 public:
  void fail(const char* invariant, msg::Time at, std::string what) {
    if (!first_) first_ = Violation{invariant, at, std::move(what)};
  }
  bool failed() const { return first_.has_value(); }
  const std::optional<Violation>& first() const { return first_; }

 private:
  std::optional<Violation> first_;
};

}  // namespace sinew::search
